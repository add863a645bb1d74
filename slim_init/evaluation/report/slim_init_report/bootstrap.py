# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
"""Differences between methods, window by window, with 95 % confidence intervals.

Moving-block bootstrap (Kuensch 1989; Politis and Romano 1992, circular blocks): windows overlap and
neighbours see the same motion, so consecutive ones are drawn together, in blocks of two windows'
length. Every sequence keeps its number of windows, and blocks never cross from one into another.
Method and reference keep the same windows. The percentiles are moved away from the value by
Student's factor for the number of blocks. Described in docs/evaluation.md, "Differences".
"""
import math
from dataclasses import dataclass, field

import numpy
import pandas

from .data import methods_of

REPLICATES = 2000
SEED = 1
# Blocks of one window's length leave out a quarter of what the overlap adds to the variance, blocks
# of two an eighth.
BLOCK_WINDOWS = 2.0
# Fewer degrees of freedom tell nothing about how much blocks differ.
MIN_FREEDOM = 4.0

# What is compared: key of the interval and column of windows.csv.
ERRORS = {"scale_rmse": "scale_error", "gravity_rmse_deg": "gravity_error_deg",
          "velocity_rmse": "velocity_rmse", "pose_rmse": "pose_rmse"}


@dataclass
class Interval:
    """A difference with its 95 % interval; NaN where it does not exist."""
    value: float = math.nan
    low: float = math.nan
    high: float = math.nan

    @property
    def significant(self):
        """Zero is outside the interval; False without one."""
        return self.low > 0.0 or self.high < 0.0


@dataclass
class Comparison:
    """One method minus the reference. Of an error a negative difference is in the method's favour,
    of the success rate a positive one."""
    method: str
    windows: int = 0       # of the sequences with truth that both ran on
    both_success: int = 0  # windows in which both succeed
    intervals: dict = field(default_factory=dict)  # "success_rate" and the keys of ERRORS


def student_factor(freedom):
    """97.5 % quantile of Student's t over that of the normal distribution (Abramowitz and Stegun
    1964, 26.7.5; 0.3 % at four degrees of freedom)."""
    z2, n = 1.959963985 ** 2, freedom
    return (1.0 + (z2 + 1.0) / (4.0 * n) + ((5.0 * z2 + 16.0) * z2 + 3.0) / (96.0 * n ** 2) +
            (((3.0 * z2 + 19.0) * z2 + 17.0) * z2 - 15.0) / (384.0 * n ** 3))


def block_length(start_s, duration_s, block_s=None):
    """Windows that begin within one block of `block_s` seconds (default: two windows' length)."""
    if len(start_s) < 2:
        return 1
    block_s = BLOCK_WINDOWS * numpy.median(duration_s) if block_s is None else block_s
    windows = math.ceil(block_s / numpy.median(numpy.diff(start_s)) - 1e-6)
    return int(min(max(windows, 1), len(start_s)))


class BlockDraws:
    """How often each window is drawn, per replicate; windows of the first sequence, then of the
    next, and so on."""

    def __init__(self, sequences, block_s=None, replicates=REPLICATES, seed=SEED):
        """sequences: per sequence the arrays (start_s, duration_s) of its windows."""
        self.lengths = [len(start) for start, _ in sequences]
        self.blocks = [block_length(start, duration, block_s) for start, duration in sequences]
        draws = [-(-n // block) for n, block in zip(self.lengths, self.blocks)]
        # 32 random bits a block, mapped to its first window by multiplication: the same on every
        # machine and with every numpy.
        bits = numpy.random.RandomState(seed).randint(0, 2 ** 32, size=(replicates, sum(draws)),
                                                      dtype=numpy.uint32)
        of_sequence = numpy.split(bits.astype(numpy.uint64), numpy.cumsum(draws)[:-1], axis=1)
        times = []
        for n, block, drawn in zip(self.lengths, self.blocks, of_sequence):
            starts = ((drawn * numpy.uint64(n)) >> numpy.uint64(32)).astype(numpy.int64)
            indices = (starts[:, :, None] + numpy.arange(block)) % max(n, 1)
            indices = indices.reshape(replicates, -1)[:, :n]  # the last block is cut short
            times.append([numpy.bincount(one, minlength=n) for one in indices])
        self.times = numpy.concatenate(times, axis=1).astype(float)
        self.share = numpy.repeat([1.0 / block for block in self.blocks], self.lengths)
        self.sequence = numpy.repeat(numpy.arange(len(self.lengths)), self.lengths)

    def interval(self, windows, method, reference, root):
        """95 % interval of the difference of two means (root: of root means; the values are
        squares). windows: indices of the windows; method, reference: a value for each."""
        if not len(windows):
            return Interval()

        def difference(weights):
            total = weights.sum(axis=-1)
            with numpy.errstate(invalid="ignore", divide="ignore"):
                a, b = (weights @ method) / total, (weights @ reference) / total
            return numpy.sqrt(a) - numpy.sqrt(b) if root else a - b

        value = float(difference(numpy.ones(len(windows))))
        blocks = self.share[windows].sum()
        freedom = blocks - len(numpy.unique(self.sequence[windows]))
        if not freedom >= MIN_FREEDOM:
            return Interval(value)
        replicates = difference(self.times[:, windows])
        low, high = numpy.percentile(replicates[numpy.isfinite(replicates)], [2.5, 97.5])
        # Draws from few blocks vary less than the blocks do.
        widening = student_factor(freedom) * math.sqrt(blocks / freedom)
        return Interval(value, value + widening * (low - value), value + widening * (high - value))


def compare(windows, reference, block_s=None, replicates=REPLICATES, seed=SEED, subset=None):
    """Every method but `reference` compared with it, in order of occurrence; [] if no sequence
    with ground truth has the reference. Sequences (column `run`) without it are skipped, and a method
    that did not run on a sequence is compared on the others. subset: name of a column of
    windows.csv that must be true ("excited"), or None for all windows."""
    sequences = []
    for _, rows in windows[windows["has_truth"]].groupby("run", sort=False):
        by_method = {name: group.sort_values("trial") for name, group in rows.groupby("method")}
        if reference in by_method:
            sequences.append(by_method)
    if not sequences:
        return []
    draws = BlockDraws([(s[reference]["t_start_s"].to_numpy(),
                         s[reference]["duration_s"].to_numpy()) for s in sequences],
                       block_s, replicates, seed)
    used = windows[windows["run"].isin([s[reference]["run"].iloc[0] for s in sequences])]
    return [_compare_method(method, reference, sequences, draws, subset)
            for method in methods_of(used) if method != reference]


def _compare_method(method, reference, sequences, draws, subset):
    """The paired values of two methods over all sequences, and their intervals."""
    first = numpy.cumsum([0] + draws.lengths)
    chosen = [i for i, sequence in enumerate(sequences) if method in sequence]
    index = numpy.concatenate([numpy.arange(first[i], first[i + 1]) for i in chosen])
    a, b = (pandas.concat([sequences[i][name] for i in chosen]) for name in (method, reference))
    if subset:
        keep = b[subset].to_numpy()
        index, a, b = index[keep], a[keep], b[keep]
    ok_a, ok_b = ((rows["attempted"] & rows["success"]).to_numpy() for rows in (a, b))
    both = ok_a & ok_b
    result = Comparison(method, len(index), int(both.sum()))
    result.intervals["success_rate"] = draws.interval(index, ok_a.astype(float),
                                                      ok_b.astype(float), root=False)
    for key, column in ERRORS.items():
        squares = (rows[column].to_numpy()[both] ** 2 for rows in (a, b))
        result.intervals[key] = draws.interval(index[both], *squares, root=True)
    return result
