# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
"""Tables, figures and HTML pages from the CSV and JSON files of `slim_init ab`.

    python3 -m slim_init_report DIR                   # report.md and report.html of one run
    python3 -m slim_init_report DIR DIR... --out OUT  # several runs together, as in the paper

Where to change what:

    data.py            what is read: windows.csv and summary.json of a run
    statistics.py      every number of a table, from the rows of windows.csv
    tables.py          a table: cells, best figure of a column, width
    method_tables.py   the columns of the tables with a row per method
    suite_tables.py    the paper's tables I to IV and Fig. 6
    paper_figures.json what the paper printed
    figures.py         the pictures
    run_report.py      the report of one run; text in templates/run.j2
    suite_report.py    the report of several runs; text in templates/suite.j2
    render.py          Markdown and HTML from the templates

Definitions of the numbers: docs/evaluation.md.
"""
