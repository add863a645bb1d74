# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
"""Command line of the reports: `slim_init report` and `python3 -m slim_init_report`."""
import argparse
import os
import sys

from . import demo_page, run_report, suite_report
from .data import InputError, load_run

EXIT_INTERNAL, EXIT_BAD_INPUT = 1, 2


def parse(arguments):
    """The command line as a namespace."""
    parser = argparse.ArgumentParser(
        prog="slim_init report", description="Tables, figures and HTML from the folders that "
        "`slim_init ab --out` wrote. One folder: report.md and report.html of that run, beside its "
        "data. Several: one report over all of them, with the paper's tables.")
    parser.add_argument("folders", nargs="*", metavar="DIR", help="folder of a run")
    parser.add_argument("--out", metavar="DIR",
                        help="where the report goes; needed with several folders")
    parser.add_argument("--suite", action="store_true",
                        help="the report over several runs also for a single folder")
    parser.add_argument("--demo", action="store_true",
                        help="the page of `slim_init demo` from its two folders")
    parser.add_argument("--note", action="append", default=[], metavar="TEXT",
                        help="a line for the report over several runs; may be repeated")
    parser.add_argument("--command", default="", metavar="TEXT",
                        help="how the runs were made, for the same report")
    options = parser.parse_args(arguments)
    if not options.folders:
        parser.error("the folder of a run is needed")
    if len(options.folders) > 1 and not options.out:
        parser.error("--out DIR is needed with several folders")
    return options


def main(arguments=None):
    """Returns the exit code: 0; 1: the report cannot be written; 2: bad input."""
    options = parse(arguments)
    try:
        runs = [load_run(folder) for folder in options.folders]
        out = options.out or options.folders[0]
        os.makedirs(out, exist_ok=True)
        if options.demo:
            files = demo_page.write(runs, out)
        elif len(runs) == 1 and not options.suite:
            files = run_report.write(runs[0], out)
        else:
            files = suite_report.write(runs, out, options.note, options.command)
    except InputError as error:
        print("slim_init report: %s" % error, file=sys.stderr)
        return EXIT_BAD_INPUT
    except OSError as error:
        print("slim_init report: %s" % error, file=sys.stderr)
        return EXIT_INTERNAL
    print("\n".join("Report: " + file for file in files))
    return 0


if __name__ == "__main__":
    sys.exit(main())
