# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
"""The runs of the suite: what each is called and the arguments of `slim_init ab` that make it."""
import fnmatch
import os
import shutil
from collections import namedtuple

# Simulated features as trackers see them, with outliers and drift: docs/benchmark.md.
OUTLIERS = "0.03"
DRIFT_PX = "0.04"

# The protocol is the paper's, whatever a file of options says about windows; the cases "growing"
# have the windows of a host, of the files or the defaults.
WINDOW = ["--keyframes", "10"]

QUICK_WINDOWS = 5
QUICK_DURATION_S = "10"

Motion = namedtuple("Motion", "name motion world points ablation")
MOTIONS = [Motion("corridor-walk", "corridor-walk", "corridor", 12, True),
           Motion("constant-velocity-12", "constant-velocity", "hall", 12, True),
           Motion("constant-velocity", "constant-velocity", "hall", 100, False),
           Motion("pure-rotation", "pure-rotation", "room", 100, False),
           Motion("hover", "hover", "room", 100, False),
           Motion("circle", "circle", "room", 100, False),
           Motion("figure-eight", "figure-eight", "room", 100, False)]

# As EuRoC's files are named; the first five letters are the paper's name.
EUROC = ["MH_01_easy", "MH_02_easy", "MH_03_medium", "MH_04_difficult", "MH_05_difficult",
         "V1_01_easy", "V1_02_medium", "V1_03_difficult", "V2_01_easy", "V2_02_medium",
         "V2_03_difficult"]

# Methods of which `slim_init ab --ablation` has variants.
WITH_VARIANTS = ["slim", "slim-paper"]

# name: folder below `out`, e.g. "recorded/V1_01". arguments: of `slim_init ab`, without --out.
# inputs: files whose change makes the run anew.
Case = namedtuple("Case", "name arguments inputs")


class ConfigError(Exception):
    """An option of the suite cannot be used; the message names it."""


def switched_on(value):
    """Snakemake hands on what was typed as a text, a number or a bool, as its version pleases."""
    return str(value).lower() in ("1", "true", "yes", "on")


def find_program(config, suite_folder):
    """The program slim_init: that of the configuration, of the build folder or the installation
    that this suite belongs to, or of PATH."""
    given = config.get("program") or ""
    places = [os.path.normpath(os.path.join(suite_folder, place)) for place in (
        "../../../build/bin",  # slim_init/evaluation/suite of the sources
        "../../../bin")]       # share/slim_init/suite of an installation
    found = shutil.which(given or "slim_init",
                         path=os.pathsep.join(places + [os.environ.get("PATH", "")]))
    if found is None:
        raise ConfigError("program: %s is not a program" % given if given else
                          "program: no slim_init in the build folder of this source or in PATH; "
                          "name it with --config program=FILE")
    return found


def _common(config, ablation, fixed=True):
    """The options that go to every run; fixed: windows of one size, else those that grow."""
    methods = [name for name in str(config.get("methods") or "").split(",") if name]
    if ablation:
        methods = [name for name in (methods or WITH_VARIANTS) if name in WITH_VARIANTS]
    limit = int(config.get("limit") or 0)
    if switched_on(config.get("quick")) and limit == 0:
        limit = QUICK_WINDOWS
    arguments = list(WINDOW) if fixed else []
    values = [("methods", ",".join(methods)), ("stride", config.get("stride")), ("limit", limit),
              ("threads", config.get("threads")), ("options", config.get("options")),
              ("gates", config.get("gates"))]
    if not ablation:  # of a variant it is the answer that counts
        values.append(("downstream", config.get("downstream")))
    for name, value in values:
        if value not in (None, "", 0):
            arguments += ["--" + name, str(value)]
    return arguments + (["--ablation"] if ablation else [])


def _simulated(config):
    """The options of simulated features."""
    return ["--outliers", OUTLIERS, "--drift", DRIFT_PX, "--seed", str(config.get("seed", 1))]


def _builtin(config):
    for motion in MOTIONS:
        arguments = ["--builtin", motion.motion, "--world", motion.world, "--points",
                     str(motion.points)] + _simulated(config)
        if switched_on(config.get("quick")):
            arguments += ["--duration", QUICK_DURATION_S]
        yield "simulated/" + motion.name, arguments, [], motion.ablation


def _subfolders(folder):
    return sorted(entry.path for entry in os.scandir(folder) if entry.is_dir())


def _recorded(config, notes):
    folder = os.path.expanduser(config["recorded"])
    if not os.path.isdir(folder):
        raise ConfigError("recorded: there is no folder %s" % folder)
    found = 0
    for path in _subfolders(folder):
        name = os.path.basename(path)
        files = [os.path.join(path, file)
                 for file in ("imu0.csv", "cam0_timestamps.csv", "groundtruth.csv")]
        if not os.path.exists(files[0]):
            notes.append("recorded: %s has no imu0.csv and was skipped" % name)
            continue
        found += 1
        world = "hall" if name.startswith("MH_") else "room"
        yield ("recorded/" + name,
               ["--recorded", path, "--world", world] + _simulated(config), files, True)
    if not found:
        raise ConfigError("recorded: no folder in %s holds a recording (imu0.csv)%s" % (
            folder, "; it is one itself: name the folder above"
            if os.path.exists(os.path.join(folder, "imu0.csv")) else ""))


def _find_sequence(places, name):
    """Arguments and files of a sequence of EuRoC, or None."""
    for place in places:
        for inside in ("mav0/", ""):
            files = [os.path.join(place, name, inside + file)
                     for file in ("imu0/data.csv", "cam0/data.csv")]
            if all(map(os.path.exists, files)):
                return ["--asl", os.path.join(place, name)], files
        bag = os.path.join(place, name + ".bag")
        if os.path.isfile(bag):
            return ["--bag", bag], [bag]
    return None


def _euroc(config, notes):
    folder = os.path.expanduser(config["euroc"])
    if not os.path.isdir(folder):
        raise ConfigError("euroc: there is no folder %s" % folder)
    # EuRoC's archives unpack into a folder per hall and, as bags, one more per sequence.
    places = [folder]
    for path in _subfolders(folder):
        places += [path] + _subfolders(path)
    missing = []
    for name in EUROC:
        found = _find_sequence(places, name)
        if found is None:
            missing.append(name)
            continue
        arguments, files = found
        if arguments[0] == "--bag":
            if not config.get("config"):
                raise ConfigError("euroc: %s is a bag and needs config=YAML, which holds the "
                                  "calibration and names the topics" % files[0])
            arguments += ["--config", config["config"]]
        yield "images/" + name[:5], arguments, files, True
    if len(missing) == len(EUROC):
        raise ConfigError("euroc: none of EuRoC's sequences is in %s (looked for %s/mav0, %s.bag "
                          "and so on, there and two folders deep)" % (folder, EUROC[0], EUROC[0]))
    if missing:
        notes.append("euroc: not found: " + ", ".join(missing))


def _growing(plain):
    """Every method solving at every image until it accepts; named growing/SEQUENCE."""
    for name, arguments, files, _ in plain:
        yield "growing/" + name.replace("/", "-"), arguments, files


def list_cases(config):
    """The cases in the order of the report, and notes on what was looked for and is not there.
    Raises ConfigError."""
    notes, plain = [], []
    if config.get("euroc"):
        plain += _euroc(config, notes)
    if config.get("recorded"):
        plain += _recorded(config, notes)
    plain += _builtin(config)
    common = _common(config, False)
    cases = [Case(name, arguments + common, files) for name, arguments, files, _ in plain]
    variants = _common(config, True)
    if "--methods" in variants:
        cases += [Case("ablation/" + name, arguments + variants, files)
                  for name, arguments, files, ablation in plain if ablation]
    else:
        notes.append("no ablation: none of the methods has variants")
    if switched_on(config.get("growing")):
        growing = _common(config, False, fixed=False)
        cases += [Case(name, arguments + growing, files)
                  for name, arguments, files in _growing(plain)]
    patterns = [pattern for pattern in str(config.get("cases") or "").split(",") if pattern]
    if patterns:
        for pattern in patterns:
            if not any(fnmatch.fnmatchcase(case.name, pattern) for case in cases):
                raise ConfigError("cases: '%s' is none of %s" % (
                    pattern, ", ".join(case.name for case in cases)))
        cases = [case for case in cases
                 if any(fnmatch.fnmatchcase(case.name, pattern) for pattern in patterns)]
        notes.append("only the cases " + ", ".join(patterns))
    return cases, notes
