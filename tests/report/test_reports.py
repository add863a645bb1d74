# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
"""Whole reports: what they say, that the HTML opens by itself, and that nothing is wider than the
page."""
import contextlib
import io
import math
import os
import re
import unittest
from html.parser import HTMLParser

from handmade import by_hand, row, write_run
from scratch import Scratch, read
from slim_init_report import __main__ as program
from slim_init_report import data, render, run_report, suite_report, suite_tables

VOID = {"meta", "img", "br", "hr", "link"}


class Checker(HTMLParser):
    """Finds tags that do not match, resources from elsewhere, and the lines of tables."""

    def __init__(self, html):
        super().__init__()
        self.problems, self.open, self.pictures, self.text = [], [], 0, ""
        self.rows = []  # of all tables, the cells' texts
        self.feed(html)
        self.close()
        self.problems += ["<%s> is not closed" % tag for tag in self.open]

    def handle_starttag(self, tag, attrs):
        for name, value in attrs:
            if name in ("src", "href") and not re.match(r"#|data:image/png;base64,", value or ""):
                self.problems.append("%s=%s leads elsewhere" % (name, value[:40]))
        self.pictures += tag == "img"
        if tag in ("script", "iframe", "link"):
            self.problems.append("<%s>" % tag)
        if tag not in VOID:
            self.open.append(tag)
        if tag == "tr":
            self.rows.append([])
        if tag in ("td", "th"):
            self.rows[-1].append("")

    def handle_endtag(self, tag):
        if not self.open or self.open.pop() != tag:
            self.problems.append("</%s> closes nothing" % tag)

    def handle_data(self, text):
        self.text += text
        if self.open and self.open[-1] == "style" and "url(" in text:
            self.problems.append("the style loads something")
        if "td" in self.open or "th" in self.open:
            self.rows[-1][-1] += text


def check(test, files):
    """Reads a report; returns the Markdown and the checked HTML."""
    markdown, html = read(files[0]), read(files[1])
    page = Checker(html)
    test.assertEqual(page.problems, [])
    # Nothing scrolls; text wraps, pictures shrink.
    style = html[html.index("<style>"):html.index("</style>")]
    test.assertNotIn("overflow-x", style)
    for part in ("table-layout: auto", "th { background: var(--head); white-space: normal",
                 "white-space: pre-wrap", "figure img { max-width: 100%"):
        test.assertIn(part, style)
    test.assertEqual(re.findall(r"white-space: nowrap", style), ["white-space: nowrap"])  # .beside
    test.assertIn(".beside { color: var(--soft); white-space: nowrap; }", style)
    for cells in page.rows:
        # What cannot be wrapped: the longest word of every cell.
        width = sum(2 + max([len(word) for word in re.split(r"\s+(?![^(]*\))", cell)] or [0])
                    for cell in cells)
        test.assertLessEqual(width, render.HTML_WIDTH, cells)
    test.assertNotRegex(markdown + page.text, r"(?i)\bnan\b")
    return markdown, page, html


class RunReport(Scratch):
    def report(self, rows, **info):
        """The report of one run."""
        run = data.load_run(write_run(self.path("run"), rows, **info))
        return check(self, run_report.write(run, run.folder))

    def test_says_what_was_run_and_what_was_left_out(self):
        markdown, page, html = self.report(by_hand(), first_refusal="times | go back")
        for part in ("# A/B initialization on V9_99", "slim_init ab --something '<x>'",
                     "| pixel_noise | 0.6 |", "| true gyro bias | recorded |",
                     "| program | slim_init 1.2.3, commit 0123abcd |", "a\\|b",
                     "10 trials over 100 frames gave 5 windows, 3 of them excited",
                     "5 (the data end", "first: times | go back",
                     "0 IMU samples not finite, 4 beyond the IMU's limits, 3 out of order", "- rows & <columns> | bars",
                     "## Excited windows (3)", "## All windows (5)", "| hand | 60.0 |",
                     "How to read this",
                     "`hand`, median per stage [ms wall]: one 0.500, two 0.250"):
            self.assertIn(part, markdown)
        # All refusals and waits are there.
        self.assertIn("| hand | 5 | 4 | 1 | 3 | 1 |", markdown)
        self.assertIn("scale too uncertain", markdown)
        self.assertIn("rows &amp; &lt;columns&gt;", html)
        self.assertIn("<code>hand</code>, median", html)
        self.assertIn("rows & <columns>", page.text)
        self.assertEqual(page.pictures, 2)
        for picture in ("error_cdf.png", "solve_time.png"):
            self.assertGreater(os.path.getsize(self.path("run/" + picture)), 1000)
            self.assertIn("(%s)" % picture, markdown)
        self.assertNotIn("Differences", markdown)

    def test_what_was_found_of_a_wrong_rig(self):
        title = "## Injected calibration errors and their estimates"
        rows = [row(i, "slim", 1.02, scale_sigma=0.02, td_error_ms=2.0, td_sigma_ms=1.0,
                    rotation_error_deg=0.25, rotation_over_sigma=1.5) for i in range(4)]
        # A rolling shutter that the methods know is no error.
        self.assertNotIn(title, self.report(rows, options={"builtin": "circle", "readout_s": 0.02})[0])
        markdown, _, _ = self.report(rows, options={"builtin": "circle", "td_error_s": 0.02})
        self.assertIn(title, markdown)
        self.assertIn("| slim | 100.0 | 0.0200 | 1.00 | 2.00 | 2.00 | 0.250 | 1.50 | - |", markdown)

    def test_methods_are_compared_with_slim(self):
        rows = [row(i, method, None if method == "<other>" and i < 6 else 1.0 + error,
                    "success") for i in range(60)
                for method, error in (("slim", 0.02), ("<other>", 0.1))]
        markdown, page, html = self.report(rows)
        self.assertIn("| <other> | 60 | 54 | -10.0 | +0.080 | +0.80 | +0.160 | +0.320 |", markdown)
        self.assertIn("<td class=\"name\">&lt;other&gt;</td>", html)

    def test_without_truth_there_are_no_errors(self):
        rows = [dict(row(i, "m", 1.0), scale="", scale_error="", success=0,
                     gravity_error_deg="", velocity_rmse="", velocity_vec_rmse="", pose_rmse="",
                     gyro_bias_err_pct="", gyro_bias_vec_err="") for i in range(6)]
        rows[0].update(td_error_ms=2.0)
        markdown, page, _ = self.report(rows, has_truth=False, gyro_bias_truth="none",
                                        first_keyframes=4, options={"td_error_s": 0.02})
        self.assertIn("There is no ground truth", markdown)
        self.assertNotIn("scale rmse", markdown)
        self.assertNotIn("beyond 25 %", markdown)
        self.assertIn("| method | accepted % | td ms |", markdown)
        self.assertIn("| m | 100.0 | 2.00 |", markdown)
        self.assertIn("| m | 6 |", markdown)
        self.assertNotIn("error_cdf.png", markdown)
        self.assertEqual(page.pictures, 2)  # times, first estimates

    def test_a_method_that_never_answers(self):
        rows = [row(i, method, 1.1 if method == "slim" else None,
                    "success" if method == "slim" else "too_few_tracks")
                for i in range(12) for method in ("slim", "mute")]
        markdown, _, _ = self.report(rows)
        self.assertIn("| mute | 0.0 | - | - |", markdown)
        self.assertIn("| mute | 12 | 0 | 0 | 12 |", markdown)
        # And nobody does.
        markdown, page, _ = self.report([row(i, "mute", None, "stationary") for i in range(3)])
        self.assertIn("| mute | 3 | 0 | 3 |", markdown)
        self.assertEqual(page.pictures, 0)

    def test_growing_windows_images_variants_and_the_back_end(self):
        rows = [row(i, method, 1.05, answer_s=0.75 + 0.25 * (i % 3), answer_keyframes=4 + i % 3,
                    downstream=1, downstream_s=5.0, downstream_diverged=0, downstream_ate=0.1,
                    downstream_scale_error=0.01)
                for i in range(8) for method in ("slim", "slim[no-lines]")]
        tracking = {"images": 70, "tracked": 65, "outside_imu": 0, "unreadable": 5, "refused": 0,
                    "images_without_gyro": 0, "points": 123.0, "points_carried": 100.0,
                    "lines": 40.0, "lines_carried": None, "total_ms_median": 6.25}
        markdown, page, _ = self.report(
            rows, first_keyframes=4, tracking=tracking,
            method_notes={"slim[no-lines]": "without <lines>"},
            options={"asl": "DIR", "downstream_s": 5.0})
        for part in ("Accepted estimates, windows expanding from 4 keyframes",
                     "| slim | 100.0 | 1.00 | 1.25 | 5 |", "- `slim[no-lines]`: without <lines>",
                     "65 of 70 images tracked", "5 unreadable",
                     "| points | 123 | 100 |", "| lines | 40 | - |", "6.25 ms (median)",
                     "The back end started from the accepted estimates", "| slim | 8 | 0.0 |",
                     "windows expanding until the method accepts"):
            self.assertIn(part, markdown)
        self.assertEqual(page.pictures, 3)

    def test_pictures_of_an_earlier_report_do_not_stay(self):
        self.report(by_hand())
        self.report([row(i, "mute", None, "stationary") for i in range(3)])
        self.assertFalse(os.path.exists(self.path("run/error_cdf.png")))


class SuiteReport(Scratch):
    def run_of(self, name, methods, **more):
        rows = [row(i, method, 1.0 + error * (1.0 + 0.3 * math.sin(i)) if error else None,
                    "success" if error else "too_few_tracks")
                for i in range(60) for method, error in methods.items()]
        more.setdefault("dataset", os.path.basename(name))
        return data.load_run(write_run(self.path(name), rows, **more))

    def test_every_table(self):
        both = {"slim": 0.02, "drt-l": 0.1}
        variants = {"slim-paper": 0.1, "slim-paper[no-lines]": 0.2}

        def builtin(name):
            return {"builtin": name, "world": "corridor", "points": 12, "lines": 25}
        runs = [self.run_of("images/MH_01", both, options={"asl": "DIR"}),
                self.run_of("images/V1_01", both, options={"asl": "DIR"}),
                self.run_of("recorded/MH_03", both),
                self.run_of("recorded/V1_01", {"slim": 0.1, "drt-l": 0.02}),
                self.run_of("growing/recorded-V1_01", both, dataset="V1_01", first_keyframes=5),
                self.run_of("recorded/blind", both, has_truth=False),
                self.run_of("simulated/corridor-walk", both, options=builtin("corridor-walk")),
                self.run_of("simulated/hover", both, options=builtin("hover")),
                self.run_of("simulated/circle", {"slim": 0.02, "drt-l": 0}, options=builtin("circle")),
                self.run_of("ablation/recorded/V1_01", variants),
                self.run_of("ablation/simulated/corridor-walk", variants,
                            options=builtin("corridor-walk"))]
        out = self.path("out")
        os.makedirs(out)
        markdown, page, _ = check(self, suite_report.write(runs, out, ["euroc: not <found>"],
                                                           "snakemake -s Snakefile"))
        for part in ("snakemake -s Snakefile", "- euroc: not <found>",
                     "- recorded/blind: no ground truth", "| blind | slim | 0 | 0 | - | - | - |",
                     "| growing/recorded-V1_01 | Vicon Room 1 |", "| recorded/V1_01 | scale rmse |",
                     "slim_init 1.2.3, commit 0123abcd",
                     "## Table I, accuracy: EuRoC, from images",
                     "## Table I, accuracy: recorded motion and IMU, simulated features",
                     "## Table II, success rate: EuRoC, from images",
                     "| drt-l | 100.0 (91.8) |", "## Table III, degenerate motion",
                     "## Table IV, ablation: degenerate motion, simulated",
                     "## Ablation: recorded motion and IMU, simulated features",
                     "## Fig. 6, solve time", "(4.150)", "## Differences to slim",
                     "## Where slim is not first", "## Accuracy per sequence",
                     "## Statuses (all windows)", "| circle | drt-l | 60 | 0 | 0 | 0 | 60 |", "| circle | drt-l | 0 | 0 | 0 | 0 | - |",
                     "recorded_error_cdf.png", "images_solve_time.png",
                     "degenerate_solve_time.png", "How to read this"):
            self.assertIn(part, markdown)
        # Where a method succeeds in no window there is nothing to be first in but the success rate.
        self.assertIn("`slim` is first or level in", markdown)
        self.assertNotIn("NOT RUN", markdown)
        self.assertEqual(page.pictures, 8)

    def test_first_answers_have_a_table_of_their_own(self):
        both = {"slim": 0.02, "drt-l": 0.4}
        options = {"builtin": "circle", "world": "room", "points": 100, "lines": 25}
        runs = [self.run_of("simulated/circle", both, options=options),
                self.run_of("growing/simulated-circle", both, options=options, first_keyframes=5)]
        out = self.path("out")
        os.makedirs(out)
        markdown, _, _ = check(self, suite_report.write(runs, out))
        self.assertIn("## Time to the first estimate within 10 %", markdown)
        answers = markdown[markdown.index("## Time to the first estimate within 10 %"):]
        answers = answers[:answers.index("\n## ", 3)]
        # Right, wrong by more than a quarter.
        self.assertIn("| simulated-circle | slim | **100.0** | 0 |", answers)
        self.assertIn("| simulated-circle | drt-l | 0.0 | 60 |", answers)
        # And they are in no other table, where there are others.
        verdicts = markdown[markdown.index("## Statuses"):markdown.index("## Pictures")]
        self.assertNotIn("simulated-circle", verdicts)
        markdown, _, _ = check(self, suite_report.write(runs[1:], out))
        self.assertIn("simulated-circle", markdown[markdown.index("## Statuses"):])

    def test_without_the_reference_there_are_no_differences(self):
        run = self.run_of("recorded/MH_03", {"drt-l": 0.1, "vins": 0.2})
        markdown, _, _ = check(self, suite_report.write([run], self.folder))
        self.assertNotIn("Differences", markdown)
        self.assertNotIn("is not first", markdown)
        self.assertIn("| vins | 0.2", markdown)

    def test_eleven_sequences_fit_the_page(self):
        names = ["%s_%02d" % (hall, i) for hall, n in (("MH", 5), ("V1", 3), ("V2", 3))
                 for i in range(1, n + 1)]
        runs = [self.run_of("images/" + name, {"slim": 0.02, "drt-l": 0.1, "slim-paper": 0.1},
                            options={"asl": "DIR"}) for name in names]
        markdown, _, _ = check(self, suite_report.write(runs, self.folder))
        for name in names:
            self.assertIn(" %s |" % name, markdown)


class DemoPage(Scratch):
    def test_says_who_was_right(self):
        def rows(slim_scale, vins_scale):
            return [row(0, "slim", slim_scale), row(0, "vins", vins_scale),
                    row(1, "slim", None, "scale_too_uncertain"), row(1, "vins", 1.5)]
        folders = [write_run(self.path(name), written) for name, written in
                   (("recorded", rows(1.02, 0.97)), ("home_made", rows(1.02, 0.8)))]
        page = self.path("page")
        self.assertEqual(program.main(["--demo", "--out", page, *folders]), 0)
        text = self.text_of("page/report.md")
        self.assertIn("Of 2 starts as recorded, a scale within 10 % of the ground truth was found by "
                      "`slim` in 1 and `vins` in 1; of 2 starts as a home-made rig has it, by "
                      "`slim` in 1 and `vins` in 0.", text)
        self.assertIn("| as recorded | slim | 1 | 0 | 1 | 2.0 |", text)
        self.assertIn("| as a home-made rig has it | vins | 0 | 2 | 0 | 35.0 |", text)
        self.assertTrue(os.path.exists(os.path.join(page, "starts.png")))
        self.assertEqual(program.main(["--demo", "--out", page, folders[0]]), 2)


class CommandLine(Scratch):
    def call(self, *arguments):
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            try:
                code = program.main(list(arguments))
            except SystemExit as stop:  # of argparse
                code = stop.code
        return code, out.getvalue(), err.getvalue()

    def test_one_folder_and_several(self):
        first, second = (write_run(self.path(name), by_hand()) for name in "ab")
        code, out, _ = self.call(first)
        self.assertEqual((code, out), (0, "Report: %s/report.md\nReport: %s/report.html\n" %
                                       (first, first)))
        together = self.path("deep/er")
        code, out, _ = self.call(first, second, "--out", together, "--note", "a note")
        self.assertEqual(code, 0)
        self.assertIn("- a note", self.text_of("deep/er/report.md"))
        self.assertEqual(self.call("--suite", first, "--out", together)[0], 0)

    def test_bad_input(self):
        code, out, err = self.call(self.path("none"))
        self.assertEqual((code, out), (2, ""))
        self.assertTrue(err.startswith("slim_init report: ") and "summary.json" in err, err)
        self.assertIn("the folder of a run is needed", self.call()[2])
        self.assertEqual(self.call("a", "b")[0], 2)
        folder = write_run(self.path("a"), by_hand())
        self.assertEqual(self.call(folder, "--out", self.write("file"))[0], 1)


if __name__ == "__main__":
    unittest.main()
