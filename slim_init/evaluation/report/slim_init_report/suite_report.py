# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
"""The report of several runs together: the paper's tables, what it printed beside ours, and
paired differences. Its text is in templates/suite.j2."""
import os
from dataclasses import dataclass, replace

from . import figures, render
from .data import methods_of, pool
from .method_tables import DETAIL, DOWNSTREAM, FIRST_ANSWER, VERDICTS, difference_table
from .run_report import REFERENCE
from .suite_tables import (ablation_table, accuracy_tables, degenerate_table, not_first_table,
                           run_method_table, run_table, success_table, time_table)

SUBSETS = (("excited", "excited windows"), (None, "all windows"))


@dataclass
class Group:
    """Runs that are looked at together."""
    title: str
    prefix: str  # of the files of its pictures
    runs: list
    ablation: bool

    @property
    def kind(self):
        """"images", "recorded" or "builtin"."""
        return self.runs[0].kind

    @property
    def degenerate(self):
        """Motion along which scale is hard to see, or not at all."""
        return self.runs[0].group in ("Degenerate", "Without parallax")


def _named(runs):
    """The runs, named by their folders below the one that all of them share."""
    folders = [os.path.abspath(run.folder) for run in runs]
    shared = os.path.commonpath([os.path.dirname(folder) for folder in folders])
    return [replace(run, name=os.path.relpath(folder, shared))
            for run, folder in zip(runs, folders)]


def group_runs(runs):
    """Runs by where their features come from and what kind of motion it is, ablations apart; those of
    expanding windows are in none of them beside others."""
    runs = [run for run in runs if not run.is_growing] or runs
    kinds = (("EuRoC, from images", "images_", lambda run: run.kind == "images"),
             ("recorded motion and IMU, simulated features", "recorded_",
              lambda run: run.kind == "recorded"),
             ("degenerate motion, simulated", "degenerate_",
              lambda run: run.group in ("Degenerate", "Without parallax")),
             ("excited motion, simulated", "excited_",
              lambda run: run.kind == "builtin" and run.group == "Excited"))
    groups = []
    for ablation in (False, True):
        for title, prefix, belongs in kinds:
            members = [run for run in runs if run.is_ablation == ablation and belongs(run)]
            if members:
                groups.append(Group(title, prefix, _named(members), ablation))
    return groups


def _not_first(groups):
    """Where the reference is not the best: triples of subset, figures with a best one, table."""
    runs = [run for group in groups for run in group.runs if run.group != "Without parallax"]
    if not runs:
        return []
    result = []
    for subset, name in SUBSETS:
        table, figures_compared = not_first_table(run_method_table(_named(runs), DETAIL, subset),
                                                  REFERENCE)
        result.append((name, figures_compared, table))
    return result


def _details(groups):
    """Accuracy per run; slow motion is what the excitation gate leaves out."""
    return [run_method_table(group.runs, DETAIL, subset, "%s, %s" % (group.title, name))
            for group in groups for subset, name in SUBSETS
            if not (group.degenerate and subset == "excited")]


def _pictures(groups, out):
    """Errors, times and first estimates of every group."""
    drawn = []
    for group in groups:
        growing = all(run.is_growing for run in group.runs)
        drawn += [(file, "%s: %s" % (group.title, caption)) for file, caption in
                  figures.draw(pool(group.runs), out, growing, group.prefix)]
    return drawn


def _first_answers(runs):
    """First estimates of methods that solve at every image: tables per kind of sequence."""
    tables = []
    for kind, title in (("images", "From images"), ("recorded", "Recorded motion and IMU"),
                        ("builtin", "Simulated")):
        members = [run for run in runs if run.is_growing and run.kind == kind]
        tables += [run_method_table(_named(members), FIRST_ANSWER, subset, "%s, %s" % (title, name))
                   for subset, name in SUBSETS if members]
    return tables


def build(runs, out, notes=(), command=""):
    """Draws the pictures into `out` and returns the context of the template. notes: lines about what was not run; command: how the runs were made."""
    groups = group_runs(runs)
    plain = [group for group in groups if not group.ablation]
    real = [group for group in plain if group.kind != "builtin"]
    runs = _named(runs)
    methods = methods_of(pool([run for group in (plain or groups) for run in group.runs]))
    compared = REFERENCE in methods and len(methods) > 1
    timed = (real[:1] or plain or groups)
    return {
        "title": "The paper's tables", "reference": REFERENCE, "command": command,
        "programs": list(dict.fromkeys(run.program for run in runs)),
        "runs": run_table(runs),
        "notes": list(notes) + ["%s: no ground truth, so no errors and no success" %
                                run.name for run in runs if not run.has_truth],
        "accuracy": [(group, [replace(table, title="%s, %s" % (table.title, name))
                              for subset, name in SUBSETS
                              for table in accuracy_tables(group.runs, subset)]) for group in real],
        "success": [(group, [replace(success_table(group.runs, subset), title="Success [%%], %s" % name)
                             for subset, name in SUBSETS]) for group in real],
        "degenerate": [degenerate_table(group.runs) for group in plain if group.degenerate],
        "ablations": [(group, ablation_table(group.runs, group.degenerate))
                      for group in groups if group.ablation],
        "timed_title": real[0].title if real else "all runs",
        "times": time_table([run for group in timed for run in group.runs]),
        "first_answers": _first_answers(runs),
        "differences": [difference_table(pool(group.runs), REFERENCE, group.title)
                        for group in plain] if compared else [],
        "not_first": _not_first(plain) if compared else [],
        "details": _details(plain),
        "verdicts": [run_method_table(group.runs, VERDICTS, title=group.title) for group in plain],
        "downstream": [run_method_table(group.runs, DOWNSTREAM, title=group.title)
                       for group in plain if any(run.has_downstream for run in group.runs)],
        "pictures": _pictures(plain, out),
    }


def write(runs, out, notes=(), command=""):
    """Writes report.md, report.html and the pictures into `out`. Returns the two reports."""
    return render.write("suite.j2", build(runs, out, notes, command), out)
