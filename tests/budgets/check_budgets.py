#!/usr/bin/env python3
# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
"""Checks the size of the code against its budgets, so that growth is a decision.

    check_budgets.py [REPOSITORY] [--report]

Fails if a figure is above its budget in SIZES, and also if it has fallen by more than SLACK below
it: then the budget follows, in the same commit. Raising one needs its reason in the commit message.
The target is where the figure is meant to go; it does not fail.

Reads the source as clang-format leaves it. A function ends at the first line that is a closing
brace in the column of its first line. Constants are `constexpr` names that begin with k; option
fields are the members with a default of the structs in slim_init/options.h.
Needs python3's standard library only.
"""
import os
import re
import sys

CORE = ["slim_init/include", "slim_init/src"]
SURROUNDINGS = ["feature_tracker_lines", "launch", "slim_init", "vins_estimator_patch"]
SOURCE = (".cc", ".h", ".py", ".sh", ".cmake")
CXX = (".cc", ".h")
LONGEST_FUNCTION = 60  # lines, with signature and closing brace
MOST_PARAMETERS = 6
SLACK = 0.03

# name: (what is counted, budget, target)
SIZES = {
    "core_lines": ("lines of slim_init/src and public headers", 13364, 10500),
    "surrounding_lines": ("lines outside core and tests", 35367, 26000),
    "test_lines": ("lines of tests", 41611, 26000),
    "core_numbers": ("named constants and option fields of the core", 231, 170),
    "core_long_functions": (f"functions of the core above {LONGEST_FUNCTION} lines", 0, 0),
    "core_wide_functions": (f"functions of the core above {MOST_PARAMETERS} parameters", 0, 0),
    "core_top_files": ("files at the top of slim_init/src", 2, 4),
    "virtual_calls": ("virtual calls of IInitializer", 9, 9),
}


def files_in(root, folders, endings):
    found = []
    for folder in folders:
        for path, folders_here, names in os.walk(os.path.join(root, folder)):
            folders_here[:] = [name for name in folders_here if name != "__pycache__"]
            found += [os.path.join(path, name) for name in names if name.endswith(endings)]
    return sorted(found)


def lines_of(path):
    with open(path, encoding="utf-8") as file:
        return file.read().splitlines()


def count_lines(paths):
    return sum(len(lines_of(path)) for path in paths)


def parameters_of(signature):
    """Number of parameters in the text of a signature, from its name to its body."""
    begin = signature.find("(")
    depth, count, has_text = 0, 0, False
    for character in signature[begin:]:
        if character in "([{<":
            depth += 1
        elif character in ")]}>":
            depth -= 1
            if depth == 0:
                break
        elif character == "," and depth == 1:
            count += 1
        elif depth >= 1 and not character.isspace():
            has_text = True
    return count + 1 if has_text else 0


def functions_in(lines):
    """(line, length, parameters) of each function with a body, outside other functions."""
    no_function = re.compile(r"^\s*(namespace|struct|class|enum|union|using|extern|#|//|/\*)")
    index = 0
    while index < len(lines):
        line = lines[index]
        indent = len(line) - len(line.lstrip())
        starts = (indent in (0, 2) and "(" in line and not no_function.match(line)
                  and re.match(r"^\s*[A-Za-z~]", line) and not re.match(r"^\s*(return|public|if)\b", line))
        if not starts:
            index += 1
            continue
        last = index  # of the signature
        while last < len(lines) and not re.search(r"[;{}]\s*(//.*)?$", lines[last]):
            last += 1
        if last == len(lines) or not re.search(r"{\s*(//.*)?$", lines[last]):
            index = last + 1
            continue
        end = last + 1
        while end < len(lines) and not re.match(rf"^ {{{indent}}}}}", lines[end]):
            end += 1
        yield index + 1, end - index + 1, parameters_of(" ".join(lines[index:last + 1]))
        index = end + 1


def figures_of(root):
    core = files_in(root, CORE, CXX)
    functions = [(path, *function) for path in core for function in functions_in(lines_of(path))]
    constants = sum(len(re.findall(r"\bconstexpr\b[^=({;]*?\bk[A-Z]\w*", "\n".join(lines_of(path))))
                    for path in core)
    options = lines_of(os.path.join(root, "slim_init/include/slim_init/options.h"))
    fields = sum(1 for line in options if re.match(r"^  [\w:<>]+ \w+ = [^;]+;", line))
    interface = "\n".join(lines_of(os.path.join(root, "slim_init/include/slim_init/initializer.h")))
    of_interface = interface[interface.find("class IInitializer"):]
    of_interface = of_interface[:of_interface.find("\n};")]
    core_folders = set(files_in(root, CORE, SOURCE))
    surroundings = [path for path in files_in(root, SURROUNDINGS, SOURCE)
                    if path not in core_folders]
    top = os.path.join(root, "slim_init/src")
    figures = {
        "core_lines": count_lines(core),
        "surrounding_lines": count_lines(surroundings),
        "test_lines": count_lines(files_in(root, ["tests"], SOURCE)),
        "core_numbers": constants + fields,
        "core_long_functions": sum(1 for one in functions if one[2] > LONGEST_FUNCTION),
        "core_wide_functions": sum(1 for one in functions if one[3] > MOST_PARAMETERS),
        "core_top_files": sum(1 for name in os.listdir(top) if name.endswith(CXX)),
        "virtual_calls": len(re.findall(r"\bvirtual (?!~)", of_interface)),
    }
    beyond = [f"{os.path.relpath(path, root)}:{line}: {length} lines, {parameters} parameters"
              for path, line, length, parameters in functions
              if length > LONGEST_FUNCTION or parameters > MOST_PARAMETERS]
    return figures, beyond


def faults_of(figures, sizes):
    faults = []
    for name, figure in figures.items():
        what, budget, _ = sizes[name]
        if figure > budget:
            faults.append(f"{what}: {figure} (limit {budget}); remove something, or raise the budget "
                          f"of {name} and say why in the commit")
        elif figure < budget - max(SLACK * budget, 2):
            faults.append(f"{what}: {figure}, the budget of {name} is {budget}; lower it")
    return faults


def main(arguments):
    paths = [one for one in arguments if one != "--report"]
    here = os.path.dirname(os.path.abspath(__file__))
    root = paths[0] if paths else os.path.join(here, "..", "..")
    figures, beyond = figures_of(root)
    if "--report" in arguments:
        print(f"{'now':>7} {'budget':>7} {'target':>7}")
        for name, figure in figures.items():
            what, budget, target = SIZES[name]
            print(f"{figure:>7} {budget:>7} {target:>7}  {what}")
        print("\n".join(beyond))
        return 0
    faults = faults_of(figures, SIZES)
    print("\n".join(faults))
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
