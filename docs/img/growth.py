#!/usr/bin/env python3
# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
"""growth.png from the rows that `slim_init_bench growth` prints: a panel for each of its quantities,
with the median time of a solve and, dotted, the slowest of ten. Times are logarithmic, and so are
quantities that reach far.

    growth.py growth.csv growth.png
"""
import sys

import matplotlib

matplotlib.use("Agg")
import pandas
from matplotlib import pyplot


def draw(rows, path):
    quantities = list(dict.fromkeys(rows["what"]))
    methods = list(dict.fromkeys(rows["method"]))
    figure, axes = pyplot.subplots(1, len(quantities), squeeze=False, sharey=True,
                                   figsize=(3.2 * len(quantities), 3.4), constrained_layout=True)
    for axis, quantity in zip(axes[0], quantities):
        panel = rows[rows["what"] == quantity]
        for k, method in enumerate(methods):
            of_method = panel[panel["method"] == method]
            axis.plot(of_method["value"], of_method["median_ms"], "o-", color="C%d" % k, markersize=3,
                      label=method)
            axis.plot(of_method["value"], of_method["p90_ms"], ":", color="C%d" % k)
        axis.set_yscale("log")
        if panel["value"].min() > 0 and panel["value"].max() >= 10 * panel["value"].min():
            axis.set_xscale("log")
        axis.set_xlabel(quantity)
        axis.grid(True, which="both", alpha=0.3)
    axes[0][0].set_ylabel("time of a solve [ms]")
    axes[0][0].legend(fontsize=8)
    figure.savefig(path, dpi=110)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    draw(pandas.read_csv(sys.argv[1]), sys.argv[2])
