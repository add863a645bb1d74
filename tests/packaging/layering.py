#!/usr/bin/env python3
# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
"""Who may include and link whom: dependencies point one way.

    layering.py REPOSITORY [LINKS]

Every #include of a layer has to be allowed: <...> by pattern, "..." by being found below the layer's
roots or beside the including file. LINKS is a file with lines "target:library;library". Prints one
line per violation and ends with 1 if there is any. Needs python3's standard library only.
"""
import os
import re
import sys

# Headers of the standard library have neither slash nor suffix.
PLAIN = r"[a-z_0-9]+|c[a-z]+|(unsupported/)?Eigen/[A-Za-z/]+"
OPENCV = r"opencv2/[a-z_0-9/]+\.hpp"
JSON = r"nlohmann/json\.hpp"

FRONT = "feature_tracker_lines"
HOST = "vins_estimator_patch"
CORE_HEADERS = "slim_init/include"
FRONT_HEADERS = FRONT + "/include"
HEALTH_HEADERS = HOST + "/host_health/include"
REFERENCE, SIMULATION, EVALUATION, BASELINES, CONFIG, DOCTOR, BACKEND = (
    "slim_init/" + name for name in ("reference", "simulation", "evaluation", "baselines", "config",
                                     "doctor", "backend"))

# Name, folders of the sources, where "..." may lie, patterns of <...> besides PLAIN.
LAYERS = [
    ("public headers", [CORE_HEADERS], [CORE_HEADERS], []),
    ("slim_init core", ["slim_init/src"], [CORE_HEADERS, "slim_init/src"], []),
    # What simulation and evaluation share without knowing each other: headers that need Eigen alone.
    ("reference", [REFERENCE], [], []),
    ("simulation", [SIMULATION],
     [CORE_HEADERS, FRONT_HEADERS, REFERENCE, SIMULATION + "/include", SIMULATION + "/src"],
     [OPENCV, r"(sys/)?[a-z]+\.h"]),
    ("evaluation", [EVALUATION + "/include", EVALUATION + "/src"],
     [CORE_HEADERS, FRONT_HEADERS, REFERENCE, EVALUATION + "/include", EVALUATION + "/src",
      HEALTH_HEADERS],
     [JSON, OPENCV, r"sys/wait\.h", r"unistd\.h", r"(rosbag|(geometry|sensor)_msgs)/[A-Za-z_]+\.h"]),
    # Instruments of this repository, not installed, that look into the core.
    ("back end", [BACKEND],
     [CORE_HEADERS, "slim_init/src", EVALUATION + "/include", BACKEND + "/include", BACKEND + "/src",
      BASELINES + "/src"], [r"ceres/[a-z_]+\.h"]),
    ("config", [CONFIG], [CORE_HEADERS, FRONT_HEADERS, BASELINES + "/include", CONFIG + "/include"],
     [r"opencv2/(core|core/eigen|imgcodecs)\.hpp"]),
    # It judges with the solver's own parts.
    ("doctor", [DOCTOR],
     [CORE_HEADERS, "slim_init/src", FRONT_HEADERS, REFERENCE, EVALUATION + "/include",
      DOCTOR + "/include", HEALTH_HEADERS], [JSON, OPENCV]),
    ("baselines", [BASELINES],
     [CORE_HEADERS, "slim_init/src", BASELINES + "/include", BASELINES + "/src"],
     [r"ceres/[a-z_]+\.h", OPENCV]),
    (FRONT, [FRONT_HEADERS, FRONT + "/src"],
     [CORE_HEADERS, "slim_init/src", FRONT_HEADERS, FRONT + "/src"], [OPENCV]),
    ("host_health", [HOST + "/host_health"],
     [CORE_HEADERS, HEALTH_HEADERS, HOST + "/host_health/src"], []),
    (HOST, [HOST + "/src", HOST + "/include/slim_init/vins_adapter"],
     [CORE_HEADERS, FRONT_HEADERS, BASELINES + "/include", CONFIG + "/include", HEALTH_HEADERS,
      HOST + "/include", HOST + "/src"], []),
    ("tools", ["slim_init/tools"],
     [CORE_HEADERS, SIMULATION + "/include", EVALUATION + "/include", FRONT_HEADERS,
      HOST + "/include", BASELINES + "/include", CONFIG + "/include", DOCTOR + "/include",
      BACKEND + "/include", "slim_init/tools"],
     [r"(sys/)?[a-z_]+\.h", r"(opencv2|nlohmann|boost)/[A-Za-z_0-9/]+\.h(pp)?"]),
    # For nodes alone, the hosts' and ours.
    ("node headers", [HOST + "/include/slim_init/vins_ros"], [CORE_HEADERS, HOST + "/include"],
     [r"(ros|[a-z]+_msgs)/[A-Za-z_]+\.h"]),
    # Nothing includes these two.
    ("ros edge", ["slim_init/ros", FRONT + "/ros"],
     [CORE_HEADERS, FRONT_HEADERS, HOST + "/include", HEALTH_HEADERS, BASELINES + "/include",
      CONFIG + "/include", "slim_init/ros/include", FRONT + "/ros/include"],
     [OPENCV, r"(ros|slim_init|[a-z0-9]+_(msgs|srvs))/[A-Za-z_0-9]+\.h"]),
]

# The order inside the core: a module may include those before it. A new one has to be given a place.
CORE_MODULES = ["geometry", "data", "imu", "lines", "priors", "rotation", "shape", "estimation",
                "scale", "verdict", "pipeline", "session"]
SIDE_BY_SIDE = {("priors", "lines"), ("shape", "priors"), ("shape", "rotation")}
# Public headers of what stands on all modules; one module holds a solver.
ON_TOP, HOLDS_A_SOLVER = ("initializer.h", "window_solver.h"), "session"

# Libraries by name, with "slim_init_" before our own.
EIGEN, CV, CERES, THREADS = ("Eigen3::Eigen", "SlimInitOpenCV::SlimInitOpenCV", "Ceres::ceres",
                             "Threads::Threads")
MAY_LINK = {
    "core": [EIGEN],
    "host_health": [EIGEN, "core"],
    "vins_adapter": [EIGEN, "core", "host_health", "config", THREADS],
    "config": [EIGEN, "core", FRONT, "baselines", CV],
    "doctor": [EIGEN, "core", FRONT, "evaluation", "host_health", CV],
    FRONT: [EIGEN, "core", CV],
    "simulation": [EIGEN, "core", FRONT],
    "rendering": [EIGEN, "core", FRONT, "simulation", CV],
    "evaluation": [EIGEN, "core", "host_health", FRONT, "nlohmann_json::nlohmann_json", CV,
                   "SlimInitRosbag::SlimInitRosbag", THREADS],
    "backend": [EIGEN, "core", "evaluation", CERES],
    "baselines": [EIGEN, "core"],
    "ceres_baselines": ["baselines", CERES, CV],
}


def includes_below(root, folder):
    """(file, header, whether in quotes) of every #include below a folder of the repository."""
    for path, _, names in sorted(os.walk(os.path.join(root, folder))):
        for name in sorted(name for name in names if name.endswith((".h", ".cc"))):
            file = os.path.relpath(os.path.join(path, name), root)
            with open(os.path.join(root, file), encoding="utf-8") as source:
                for quote, header in re.findall(r'^[ \t]*#[ \t]*include[ \t]*(["<]?)([^">\n]*)',
                                                source.read(), re.MULTILINE):
                    yield file, header, quote == '"'


def check_layers(root):
    for layer, folders, roots, patterns in LAYERS:
        for folder in folders:
            for file, header, quoted in includes_below(root, folder):
                if quoted:
                    places = [os.path.join(root, place) for place in roots]
                    if ".." not in header:  # which could lead anywhere
                        places.append(os.path.join(root, os.path.dirname(file)))
                    allowed = any(os.path.exists(os.path.join(place, header)) for place in places)
                else:
                    allowed = re.fullmatch("|".join([PLAIN] + patterns), header)
                if not allowed:
                    yield "%s: the layer %s must not include %s" % (file, layer, header)


def check_core(root):
    source = os.path.join(root, "slim_init/src")
    for module in sorted(os.listdir(source)):
        if not os.path.isdir(os.path.join(source, module)):
            continue
        if module not in CORE_MODULES:
            yield "slim_init/src/%s: the core module has no place in the order" % module
            continue
        below = [one for one in CORE_MODULES[:CORE_MODULES.index(module) + 1]
                 if (module, one) not in SIDE_BY_SIDE]
        on_top = ON_TOP[:1] if module == HOLDS_A_SOLVER else ON_TOP
        for file, header, quoted in includes_below(root, "slim_init/src/" + module):
            folder, _, name = header.rpartition("/")
            if quoted and (folder not in below + ["slim_init"] or
                           folder == "slim_init" and name in on_top):
                yield "%s: the core module %s must not include %s" % (file, module, header)


def check_links(links):
    for line in links.splitlines():
        target, _, libraries = line.partition(":")
        allowed = MAY_LINK.get(target[len("slim_init_"):], [])
        for library in libraries.split(";"):
            # What a generator expression wraps is what counts: $<LINK_ONLY:x>, $<BUILD_INTERFACE:x>.
            library = re.sub(r"^(\$<[A-Z_]+:)+([^>]*)>+$", r"\2", library)
            known = re.sub(r"^slim_init(_|::)", "", library) in allowed
            if library and not re.search(r"-NOTFOUND$|^::@", library) and not known:
                yield "%s must not link %s" % (target, library)


def violations_of(root, links):
    """What is wrong in a repository, given the text of LINKS."""
    return [*check_layers(root), *check_core(root), *check_links(links)]


def main(arguments):
    links = ""
    if len(arguments) > 1:
        with open(arguments[1], encoding="utf-8") as file:
            links = file.read()
        if "slim_init_core:" not in links:
            sys.exit("layering: %s names no target of ours" % arguments[1])
    violations = violations_of(arguments[0], links)
    print("\n".join(violations + ["layering: %d violations" % len(violations)]))
    return 1 if violations else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
