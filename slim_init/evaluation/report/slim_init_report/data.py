# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
"""What `slim_init ab` left in a folder."""
import json
import os
from dataclasses import dataclass

import pandas

# Columns of windows.csv that hold text; an empty one is an empty text. All others are numbers, and
# an empty one is a number that does not exist (NaN).
TEXT_COLUMNS = ("dataset", "method", "status", "gates", "message", "not_evaluated",
                "downstream_message", "warnings", "stages_ms")

# Options on what is wrong with a rig; they are in the options of a run where they were typed.
RIG_OPTIONS = ("td_error_s", "extrinsic_error_deg", "random_rig", "readout_error_s", "imu_rate_hz",
               "imu_jitter_s", "imu_dropout")

# Built-in motions along which scale is hard to see, and those along which there is none to see.
DEGENERATE_MOTIONS = ("corridor-walk", "constant-velocity")
MOTIONS_WITHOUT_PARALLAX = ("pure-rotation", "hover")

EUROC_GROUPS = {"MH_": "Machine Hall", "V1_": "Vicon Room 1", "V2_": "Vicon Room 2"}


class InputError(Exception):
    """The data cannot be used; the message names the file."""


@dataclass
class Run:
    """One run of `slim_init ab`.

    windows: a row per window and method, as in windows.csv, and the columns `run` (the folder,
    which tells sequences apart when several runs are pooled) and `has_truth`.
    name: the folder's; in a report on several runs it tells them apart.
    """
    folder: str
    info: dict  # summary.json
    windows: pandas.DataFrame
    name: str

    @property
    def options(self):
        """The options of the run by name, as `slim_init ab` reports them."""
        return self.info.get("options", {})

    @property
    def has_truth(self):
        """False: there was no ground truth, so no error of any window is known."""
        return bool(self.info.get("has_truth", True))

    @property
    def has_downstream(self):
        """The back end was started from the accepted estimates."""
        return float(self.options.get("downstream_s") or 0.0) > 0.0

    @property
    def has_rig_errors(self):
        """The calibration had injected errors."""
        return any(key in self.options for key in RIG_OPTIONS)

    @property
    def is_growing(self):
        """Methods solved at every image until they accepted."""
        return "first_keyframes" in self.info

    @property
    def sequence(self):
        """The recording or the motion; the name of the folder is the user's."""
        return self.info.get("dataset", self.name)

    @property
    def kind(self):
        """Where the features come from: "images", "recorded" (true IMU, simulated features), else
        "builtin" (all simulated)."""
        if self.options.get("asl") or self.options.get("bag"):
            return "images"
        return "recorded" if self.options.get("recorded") else "builtin"

    @property
    def group(self):
        """The rows of the paper's Table II, or what kind of motion a built-in one is."""
        if self.kind != "builtin":
            return EUROC_GROUPS.get(self.sequence[:3], "Other")
        motion = self.options.get("builtin", "")
        if motion in DEGENERATE_MOTIONS:
            return "Degenerate"
        return "Without parallax" if motion in MOTIONS_WITHOUT_PARALLAX else "Excited"

    @property
    def is_ablation(self):
        """Methods with one ingredient changed are named `slim[no-lines]`."""
        return any("[" in method for method in methods_of(self.windows))

    @property
    def features(self):
        """What the methods saw, in words."""
        if self.kind == "images":
            return "tracked in the images"
        return "%s, %s points, %s lines" % tuple(
            self.options.get(key, "?") for key in ("world", "points", "lines"))

    @property
    def program(self):
        """Version and commit of the program."""
        commit = self.info.get("commit")
        return "slim_init %s%s" % (self.info.get("version", "?"),
                                   ", commit %s" % commit if commit else "")


def load_run(folder):
    """Reads windows.csv and summary.json of `folder`. Raises InputError naming the file."""
    summary, table = (os.path.join(folder, name) for name in ("summary.json", "windows.csv"))
    try:
        with open(summary, encoding="utf-8", errors="replace") as file:
            info = json.load(file)
        with open(table, newline="", encoding="utf-8", errors="replace") as file:
            windows = pandas.read_csv(file, keep_default_na=False, na_values=[""],
                                      dtype={name: str for name in TEXT_COLUMNS})
    except OSError as error:
        raise InputError("%s: %s (a folder of `slim_init ab --out` is needed)" %
                         (error.filename or folder, error.strerror))
    except ValueError as error:  # both parsers
        raise InputError("%s: summary.json or windows.csv cannot be read: %s" % (folder, error))
    try:
        for name in TEXT_COLUMNS:
            windows[name] = windows[name].fillna("")
        for name in ("excited", "attempted", "success", "downstream"):
            windows[name] = windows[name] == 1
        windows["downstream_diverged"] = windows["downstream_diverged"] == 1
        windows["run"] = folder
        windows["has_truth"] = bool(info.get("has_truth", True))
    except (KeyError, AttributeError) as error:
        raise InputError("%s lacks the column %s" % (table, error))
    return Run(folder, info, windows, os.path.basename(os.path.abspath(folder)))


def methods_of(windows):
    """Methods in the order in which they first occur."""
    return list(pandas.unique(windows["method"]))


def pool(runs):
    """The windows of several runs in one table."""
    if not runs:
        raise InputError("no run to report")
    return pandas.concat([run.windows for run in runs], ignore_index=True)
