# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
"""Tables, and what the paper printed."""
import math
import unittest

import numpy
from handmade import row, write_run
from scratch import Scratch
from slim_init_report import data, method_tables, paper, statistics, suite_tables
from slim_init_report.tables import Cell, Table, count, number


def texts(table, row_index):
    """The cells of a row as they are shown: a star behind the best,
    the figure beside in brackets."""
    return [cell.text + ("*" if cell.best else "") + (" (%s)" % cell.beside if cell.beside else "")
            for cell in table.rows[row_index]]


class Cells(unittest.TestCase):
    def test_a_number_that_does_not_exist_is_a_dash(self):
        self.assertEqual(number("%.1f", 0.5, 100.0).text, "50.0")
        self.assertEqual(number("%.1f", math.nan).text, "-")
        self.assertEqual(number("%.1f", None).text, "-")
        self.assertEqual(count(-3).text, "-3")

    def test_best_are_all_that_show_the_same_and_none_where_all_are_level(self):
        def table(*values):
            result = Table(["method", "x"])
            for value in values:
                result.add("m", number("%.3f", value))
            return result

        def best(t):
            return [r[1].best for r in t.rows]
        lowest = table(0.2004, 0.2001, 0.3, math.nan)
        lowest.mark_best(1)
        self.assertEqual(best(lowest), [True, True, False, False])
        highest = table(0.2004, 0.2001, 0.3, math.nan)
        highest.mark_best(1, lowest=False)
        self.assertEqual(best(highest), [False, False, True, False])
        block = table(0.2004, 0.2001, 0.3, math.nan)
        block.mark_best(1, rows=range(2, 4))
        self.assertEqual(best(block), [False, False, True, False])
        level = table(1.0, 1.0)
        level.mark_best(1)
        self.assertEqual(best(level), [False, False])


class Width(unittest.TestCase):
    def table(self, columns):
        table = Table(["method"] + ["error m/s"] * columns)
        table.add("slim", *[Cell("0.1234", beside="0.56") for _ in range(columns)])
        return table

    def test_wide_tables_are_split_evenly_and_keep_their_names(self):
        parts = self.table(12).split(50)  # 8 for the method, 8 for every other column
        self.assertEqual([len(part.columns) for part in parts], [5, 5, 5])
        for part in parts:
            self.assertEqual(part.columns[0], "method")
            self.assertLessEqual(sum(part.width(c) + 2 for c in range(5)), 50)
        self.assertEqual(sum(len(part.columns) - 1 for part in parts), 12)

    def test_tables_that_fit_stay(self):
        table = self.table(3)
        self.assertEqual(table.split(50), [table])

    def test_columns_that_are_too_wide_stand_alone(self):
        self.assertEqual(len(self.table(4).split(3)), 4)
        self.assertEqual(len(Table(["a", "b"], names=2).split(1)), 1)


class Paper(unittest.TestCase):
    KEYS = ("scale_rmse", "gravity_rmse_deg", "velocity_rmse", "pose_rmse")
    METHODS = ("vins", "openvins", "drt-l", "slim-paper")

    def test_the_averages_are_those_of_the_columns(self):
        for key in self.KEYS:
            for method in self.METHODS:
                columns = [paper.printed("table_1", key, method, name) for name in paper.SEQUENCES]
                self.assertEqual(len(columns), 11)
                self.assertAlmostEqual(numpy.mean(columns),
                                       paper.FIGURES["table_1_average"][key][method], delta=0.0016)

    def test_single_figures(self):
        for path, value in ((("table_1", "scale_rmse", "slim-paper", "V2_03"), 0.149),
                            (("table_2_success_pct", "Machine Hall", "slim-paper"), 94.01),
                            (("table_3_average", "slim-paper", "gravity_rmse_deg"), 4.137),
                            (("gyro_bias_err_pct", "slim-paper[no-vp]"), 1.941),
                            (("figure_6_solve_ms", "openvins"), 284.715)):
            self.assertEqual(paper.printed(*path), value)

    def test_the_ablation_begins_and_ends_where_table_3_does(self):
        for key in self.KEYS:
            self.assertEqual(paper.printed("table_4_average", "slim-paper", key),
                             paper.printed("table_3_average", "slim-paper", key))
            self.assertEqual(paper.printed("table_4_average", "slim-paper[no-lines]", key),
                             paper.printed("table_3_average", "drt-l", key))

    def test_what_is_not_printed(self):
        for path in (("table_1", "scale_rmse", "slim", "MH_01"),
                     ("table_1", "scale_rmse", "drt-l", "TUM"),
                     ("table_1", "gyro_bias_err_pct", "drt-l", "MH_01"),
                     ("table_2_success_pct", "Other", "drt-l"), ("gyro_bias_err_pct", "slim")):
            self.assertTrue(math.isnan(paper.printed(*path)))
        self.assertEqual([paper.sequence_of(name) for name in ("MH_01_easy", "V2_03", "fr1")],
                         ["MH_01", "V2_03", ""])


class SuiteTables(Scratch):
    """slim succeeds in all of 30 windows, drt-l in every third."""

    def run_of(self, name, slim, drt, **options):
        rows = []
        for i in range(30):
            rows.append(row(i, "slim", 1.0 + slim))
            rows.append(row(i, "drt-l", 1.0 + drt) if i % 3 == 0
                        else row(i, "drt-l", None, "too_few_tracks"))
        options = options or {"recorded": name, "world": "hall", "points": 100, "lines": 25}
        return data.load_run(write_run(self.path(name), rows, options=options,
                                       dataset=name))

    def halls(self):
        return [self.run_of("MH_03", 0.03, 0.2), self.run_of("MH_04", 0.05, 0.1)]

    def test_table_1(self):
        table = suite_tables.accuracy_tables(self.halls(), "excited")[0]
        self.assertEqual(table.title, "Scale RMSE")
        self.assertEqual(table.columns, ["method", "MH_03", "MH_04", "mean"])
        self.assertEqual(texts(table, 0), ["slim", "0.030*", "0.050*", "0.040*"])
        # In fewer than half of the windows; beside it what the paper printed, and its mean.
        self.assertEqual(texts(table, 1), ["drt-l", "0.200\u2020 (0.119)", "0.100\u2020 (0.157)",
                                           "0.150 (0.138)"])

    def test_table_1_has_no_mean_over_different_sequences(self):
        runs = self.halls() + [self.run_of("V1_01", 0.1, 0.6)]  # no success of drt-l
        table = suite_tables.accuracy_tables(runs, None)[0]
        self.assertEqual(texts(table, 1)[3:], ["- (0.127)", "- (0.134)"])

    def test_table_2_pools_the_windows_of_a_group(self):
        table = suite_tables.success_table(self.halls() + [self.run_of("V1_01", 0.6, 0.1)], None)
        self.assertEqual(table.columns, ["method", "Machine Hall (MH_03, MH_04)",
                                         "Vicon Room 1 (V1_01)"])
        self.assertEqual(texts(table, 0), ["slim", "100.0*", "0.0"])
        self.assertEqual(texts(table, 1), ["drt-l", "33.3 (91.8)", "33.3* (72.1)"])

    def test_table_3_stands_beside_the_corridor_walk_only(self):
        walk = self.run_of("corridor-walk", 0.04, 0.3, builtin="corridor-walk", world="corridor",
                           points=12, lines=25)
        hover = self.run_of("hover", 0.04, 0.3, builtin="hover", world="room", points=100, lines=25)
        self.assertEqual((walk.group, hover.group), ("Degenerate", "Without parallax"))
        table = suite_tables.degenerate_table([walk, hover])
        self.assertEqual(texts(table, 1)[:4], ["corridor-walk", "drt-l", "33.3",
                                               "0.300\u2020 (0.166)"])
        self.assertEqual(texts(table, 3)[3], "0.300\u2020")
        self.assertEqual(texts(table, 0)[-2:], ["30", "0"])

    def test_the_ablation(self):
        rows = [row(i, method, 1.0 + error) for i in range(10)
                for method, error in (("slim-paper", 0.1), ("slim-paper[no-lines]", 0.2))]
        run = data.load_run(write_run(self.path("ablation"), rows,
                                      method_notes={"slim-paper[no-lines]": "without lines"}))
        self.assertTrue(run.is_ablation)
        table = suite_tables.ablation_table([run], degenerate=True)
        self.assertEqual(texts(table, 0)[:4], ["slim-paper", "", "100.0", "0.100* (0.151)"])
        self.assertEqual(texts(table, 1)[:4], ["slim-paper[no-lines]", "without lines", "100.0",
                                               "0.200 (0.166)"])
        table = suite_tables.ablation_table([run], degenerate=False)
        self.assertEqual(texts(table, 0)[7], "5.000* (1.913)")
        self.assertEqual(texts(table, 0)[3], "0.100*")

    def test_figure_6(self):
        table = suite_tables.time_table(self.halls())
        self.assertEqual(texts(table, 1)[:5], ["drt-l", "20", "1.000", "1.000 (4.150)", "1.000"])

    def test_where_a_method_is_not_first(self):
        runs = [self.run_of("MH_03", 0.03, 0.2), self.run_of("V1_01", 0.2, 0.1)]
        table = suite_tables.run_method_table(runs, method_tables.DETAIL)
        listed, figures = suite_tables.not_first_table(table, "slim")
        self.assertEqual(figures, 26)  # success and twelve errors, two runs
        self.assertEqual({r[0].text for r in listed.rows}, {"V1_01"})
        self.assertEqual(len(listed.rows), 12)
        self.assertEqual(texts(listed, 0), ["V1_01", "scale rmse", "0.2000", "0.1000\u2020",
                         "drt-l"])

    def test_verdicts_add_up(self):
        table = suite_tables.run_method_table(self.halls(), method_tables.VERDICTS)
        self.assertEqual(texts(table, 1)[:9],
                         ["MH_03", "drt-l", "30", "10", "10", "10", "20", "0", "0"])

    def test_accuracy_of_one_run(self):
        run = self.run_of("MH_03", 0.03, 0.2)
        table = method_tables.method_table(method_tables.ACCURACY,
                                           statistics.summarize(run.windows))
        self.assertEqual(texts(table, 0), ["slim", "100.0*", "0.0300*", "0.0300*", "0.0300*",
                                           "0.300*", "0.0600*", "0.0900*", "0.1200*", "1.50*", "30",
                                           "100.0*", "1.000"])
        blind = method_tables.method_table(method_tables.ACCURACY,
                                           statistics.summarize(run.windows), has_truth=False)
        self.assertEqual(blind.columns, ["method", "accepted", "solve ms"])


if __name__ == "__main__":
    unittest.main()
