# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
"""The bootstrap: values by hand, and intervals that hold the truth as often as they say."""
import math
import unittest

import numpy
import pandas
from slim_init_report import bootstrap

STEP_S, LENGTH_S = 0.5, 2.25


def sequence(run, has_truth=True, excited=None, **errors):
    """The windows of a sequence with the scale errors of each method by window."""
    frames = []
    for method, values in errors.items():
        values = numpy.asarray(values, dtype=float)
        frames.append(pandas.DataFrame({
            "run": run, "has_truth": has_truth, "method": method, "trial": range(len(values)),
            "t_start_s": STEP_S * numpy.arange(len(values)), "duration_s": LENGTH_S,
            "excited": True if excited is None else excited, "attempted": True,
            "success": values < 0.5, "scale_error": values, "gravity_error_deg": 2.0 * values,
            "velocity_rmse": 3.0 * values, "pose_rmse": 4.0 * values}))
    return pandas.concat(frames, ignore_index=True)


def independent(generator, n, sigma):
    return numpy.minimum(0.49, numpy.abs(sigma * generator.normal(size=n)))


def overlapping(generator, n, sigma, span):
    """As overlapping windows have them: neighbours share most of their data."""
    noise = generator.normal(size=n + span - 1)
    return numpy.minimum(0.49, numpy.abs(
        sigma * numpy.convolve(noise, numpy.ones(span), "valid") / math.sqrt(span)))


def scale_interval(windows, **options):
    return bootstrap.compare(windows, "ref", **options)[0].intervals["scale_rmse"]


class Values(unittest.TestCase):
    def test_by_hand(self):
        # 60 windows: the method fails in three, the reference in two, in one of them both.
        method, reference = numpy.full(60, 0.2), numpy.full(60, 0.1)
        method[3:6], reference[5:7], method[10] = 0.9, 0.6, 0.4
        c, = bootstrap.compare(sequence("a", ref=reference, other=method), "ref")
        self.assertEqual((c.method, c.windows, c.both_success), ("other", 60, 56))
        self.assertAlmostEqual(c.intervals["success_rate"].value, -1.0 / 60.0, 12)
        difference = math.sqrt((55 * 0.04 + 0.16) / 56.0) - 0.1
        for key, factor in (("scale_rmse", 1.0), ("gravity_rmse_deg", 2.0), ("velocity_rmse", 3.0),
                            ("pose_rmse", 4.0)):
            interval = c.intervals[key]
            self.assertAlmostEqual(interval.value, factor * difference, 12)
            self.assertTrue(interval.low <= interval.value <= interval.high)
        self.assertTrue(c.intervals["scale_rmse"].significant)
        self.assertFalse(c.intervals["success_rate"].significant)

    def test_blocks_are_two_windows_long_and_drawn_with_a_known_generator(self):
        start = STEP_S * numpy.arange(60)
        self.assertEqual(bootstrap.block_length(start, numpy.full(60, LENGTH_S)), 9)
        self.assertEqual(bootstrap.block_length(start[:5], numpy.full(5, LENGTH_S)), 5)
        self.assertEqual(bootstrap.block_length(start[:1], numpy.full(1, LENGTH_S)), 1)
        draws = bootstrap.BlockDraws([(start[:10], numpy.full(10, LENGTH_S))], replicates=1)
        # The first outputs of the Mersenne twister with seed 1 are 1791095845 and 4282876139: a
        # block of nine from window 4 on, around the end, and one more window, the last.
        expected = numpy.ones(10)
        expected[3], expected[9] = 0.0, 2.0
        self.assertEqual(list(draws.times[0]), list(expected))

    def test_no_difference_is_exactly_none(self):
        same = independent(numpy.random.RandomState(1), 60, 0.2)
        for interval in bootstrap.compare(sequence("a", ref=same, twin=same),
                                          "ref")[0].intervals.values():
            self.assertEqual((interval.value, interval.low, interval.high), (0.0, 0.0, 0.0))
            self.assertFalse(interval.significant)

    def test_every_sequence_keeps_its_share(self):
        # The method fails on all of one sequence and on none of the other: no draw can change the
        # rate, unless blocks or windows wander between sequences.
        windows = pandas.concat([
            sequence("easy", ref=numpy.full(61, 0.1), other=numpy.full(61, 0.1)),
            sequence("hard", ref=numpy.full(37, 0.1), other=numpy.full(37, 0.9))])
        c, = bootstrap.compare(windows, "ref")
        self.assertEqual((c.windows, c.both_success), (98, 61))
        rate = c.intervals["success_rate"]
        for bound in (rate.value, rate.low, rate.high):
            self.assertAlmostEqual(bound, -37.0 / 98.0, 12)

    def test_too_little_data_gives_no_interval(self):
        generator = numpy.random.RandomState(5)
        # Four blocks of nine windows, however many draws are made of them.
        interval = scale_interval(sequence("a", ref=independent(generator, 36, 0.1),
                                           other=independent(generator, 36, 0.1)))
        self.assertTrue(math.isfinite(interval.value))
        self.assertTrue(math.isnan(interval.low) and math.isnan(interval.high))
        self.assertFalse(interval.significant)
        # Enough windows, but none in which both succeed.
        c, = bootstrap.compare(sequence("a", ref=independent(generator, 60, 0.1),
                                        other=numpy.full(60, 0.9)), "ref")
        self.assertEqual(c.both_success, 0)
        self.assertTrue(math.isnan(c.intervals["scale_rmse"].value))
        self.assertLess(c.intervals["success_rate"].high, -0.9)
        self.assertTrue(c.intervals["success_rate"].significant)
        # Many sequences, none of which is long enough to tell how its blocks differ.
        short = [sequence(str(i), ref=independent(generator, 8, 0.1),
                          other=independent(generator, 8, 0.1)) for i in range(20)]
        c, = bootstrap.compare(pandas.concat(short), "ref")
        self.assertEqual(c.windows, 160)
        self.assertTrue(math.isnan(c.intervals["scale_rmse"].low))
        self.assertAlmostEqual(scale_interval(sequence("a", ref=[0.1], other=[0.2])).value, 0.1)

    def test_missing_methods_and_sequences_without_truth(self):
        good, bad = numpy.full(40, 0.1), numpy.full(40, 0.9)
        windows = pandas.concat([sequence("both", ref=good, a=bad), sequence("more", b=good, ref=good),
                                 sequence("without", a=good, c=good),
                                 sequence("blind", has_truth=False, ref=good, a=good)])
        first, second = bootstrap.compare(windows, "ref")
        self.assertEqual((first.method, first.windows, second.method, second.windows),
                         ("a", 40, "b", 40))
        self.assertEqual(first.intervals["success_rate"].value, -1.0)
        self.assertEqual(second.intervals["success_rate"].value, 0.0)
        self.assertEqual(bootstrap.compare(sequence("x", a=good), "ref"), [])

    def test_a_subset(self):
        excited = numpy.arange(120) % 2 == 0
        windows = sequence("a", excited=numpy.concatenate([excited, excited])[:120],
                           ref=numpy.full(120, 0.1), other=numpy.where(excited, 0.1, 0.3))
        c, = bootstrap.compare(windows, "ref", subset="excited")
        self.assertEqual(c.windows, 60)
        self.assertEqual((c.intervals["scale_rmse"].value, c.intervals["scale_rmse"].high), (0.0, 0.0))

    def test_equal_seeds_give_equal_intervals(self):
        generator = numpy.random.RandomState(9)
        windows = sequence("a", ref=independent(generator, 50, 0.1),
                           other=independent(generator, 50, 0.1))
        first, again = scale_interval(windows), scale_interval(windows)
        self.assertEqual((first.low, first.high), (again.low, again.high))
        self.assertNotEqual(scale_interval(windows, seed=2).low, first.low)

    def test_pairing_removes_what_both_methods_share(self):
        shared = overlapping(numpy.random.RandomState(3), 150, 0.1, 5)
        windows = sequence("a", ref=shared, other=numpy.minimum(0.49, 1.1 * shared))
        self.assertTrue(scale_interval(windows).significant)


class Coverage(unittest.TestCase):
    """How often an interval holds the true difference, which is zero."""
    RUNS = 300

    def coverage(self, windows, span, block_s=None):
        """Share of the intervals that do, and their mean width."""
        held = width = 0.0
        for run in range(self.RUNS):
            generator = numpy.random.RandomState(1000 + run)
            interval = scale_interval(
                sequence("a", ref=overlapping(generator, windows, 0.1, span),
                         other=overlapping(generator, windows, 0.1, span)),
                block_s=block_s, replicates=400)
            held += (interval.low <= 0.0 <= interval.high) / self.RUNS
            width += (interval.high - interval.low) / self.RUNS
        return held, width

    def test_independent_windows(self):
        held, _ = self.coverage(200, 1, block_s=0.5)
        self.assertTrue(0.92 < held < 0.98, held)

    def test_overlapping_windows(self):
        held, width = self.coverage(200, 5)
        self.assertTrue(0.90 < held < 0.98, held)
        # Taken for independent, overlapping windows promise far too much.
        held_singles, width_singles = self.coverage(200, 5, block_s=0.5)
        self.assertLess(held_singles, 0.75)
        self.assertGreater(width, 1.4 * width_singles)

    def test_few_blocks(self):
        held, _ = self.coverage(60, 5)
        self.assertGreater(held, 0.91)


if __name__ == "__main__":
    unittest.main()
