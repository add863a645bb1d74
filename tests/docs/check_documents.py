#!/usr/bin/env python3
# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
"""Checks that the documents are true as far as names go.

    check_documents.py [REPOSITORY]

In every Markdown file of the repository: relative links lead to a file, and to a heading where they
name one; what looks like a path of the repository in backticks exists; a source file named without
its folder exists somewhere; functions (`name()`, `Class::name`), tests (`Suite.Name`) and keys
(`slim_init.section.key`) occur in the code; options of the program exist. Prints one line per fault
and ends with 1 if there is any. Needs python3's standard library only.
"""
import os
import re
import sys

SKIPPED_FOLDERS = {"build", "out", "seq", "demo", "__pycache__"}
# The changelog also names what is gone: only its links are checked.
LINKS_ONLY = {"CHANGELOG.md"}
CODE_SUFFIXES = (".cc", ".h", ".cpp", ".py", ".sh", ".cmake", ".in", ".launch", ".msg", ".txt",
                 ".yaml", ".yml", ".xml", ".json", ".j2")
# A file named with one of these endings belongs to the repository, with or without its folder.
SOURCE_SUFFIXES = (".cc", ".h", ".py", ".sh", ".cmake", ".launch", ".msg")
# Topics of ROS that begin like folders of the repository.
NOT_PATHS = {"feature_tracker_lines/lines", "/feature_tracker_lines/lines"}
PROGRAM = re.compile(r"\bslim_init (ab|doctor|methods|options|report|simulate)\b(.*)")


def files_of(root):
    """All files below root, relative, without build trees and hidden folders."""
    found = []
    for folder, names, files in os.walk(root):
        names[:] = sorted(n for n in names if not n.startswith((".", "build-"))
                          and n not in SKIPPED_FOLDERS)
        found += [os.path.relpath(os.path.join(folder, f), root) for f in files]
    return sorted(found)


def read(path):
    with open(path, encoding="utf-8", errors="replace") as file:
        return file.read()


def slug(heading):
    """The anchor that GitHub gives a heading."""
    text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).replace("`", "").strip().lower()
    return re.sub(r"[^\w\- ]", "", text).replace(" ", "-")


def without_fences(text):
    """The text with fenced code blanked, and the lines of the fences."""
    prose, code, fenced = [], [], False
    for line in text.split("\n"):
        if line.lstrip().startswith("```"):
            fenced = not fenced
            prose.append("")
            continue
        code.append(line if fenced else "")
        prose.append("" if fenced else line)
    return "\n".join(prose), code


class Repository:
    """What the documents may name."""

    def __init__(self, root):
        self.root = root
        self.files = files_of(root)
        self.folders = {os.path.dirname(f) for f in self.files}
        self.folders |= {parent for f in list(self.folders) for parent in parents(f)}
        self.top = {f.split("/")[0] for f in self.files if "/" in f}
        self.include_roots = sorted({f[:f.index("/include/") + 8] for f in self.files
                                     if "/include/" in f and not f.startswith("tests/")})
        code = [read(os.path.join(root, f)) for f in self.files
                if f.endswith(CODE_SUFFIXES) and not f.startswith("tests/docs/")]
        self.words = set(re.findall(r"\w+", "\n".join(code)))
        self.tests = set()
        for text in code:
            self.tests |= {"%s.%s" % (suite, name) for suite, name in re.findall(
                r"\b(?:TYPED_)?TEST(?:_F|_P)?\(\s*(\w+),\s*(\w+)\)", text)}
            self.tests |= {"%s/%s.*" % pair for pair in re.findall(
                r"\bINSTANTIATE_TEST_SUITE_P\(\s*(\w+),\s*(\w+)", text)}
        tools = "\n".join(read(os.path.join(root, f)) for f in self.files
                          if re.match(r"slim_init/(tools|evaluation/report)/.*\.(cc|h|py)$", f))
        self.options = set(re.findall(r'"(?:--)?([a-z][a-z0-9-]*)(?:,[a-z])?"', tools))

    def exists(self, path):
        path = path.rstrip("/")
        if path in self.files or path in self.folders:
            return True
        return any(root + "/" + path in self.files or root + "/" + path in self.folders
                   for root in self.include_roots)

    def names_source(self, path):
        return any(f == path or f.endswith("/" + path) for f in self.files)

    def has_test(self, name):
        if name in self.tests:
            return True
        suite = name.split(".")[0]
        return name.endswith(".*") and any(t.split(".")[0] in (suite, suite.split("/")[-1])
                                           for t in self.tests)


def parents(path):
    while path:
        path = os.path.dirname(path)
        yield path


def check_link(repository, document, target):
    """A message, or "" for a good link."""
    if re.match(r"[a-z]+:", target) or target.startswith("<"):
        return ""
    path, _, anchor = target.partition("#")
    full = os.path.normpath(os.path.join(os.path.dirname(document), path)) if path else document
    if full.startswith(".."):
        return "link out of the repository: " + target
    if full not in repository.files and full not in repository.folders:
        return "link to a file that does not exist: " + target
    if anchor and full.endswith(".md"):
        prose, _ = without_fences(read(os.path.join(repository.root, full)))
        headings = re.findall(r"^#+ +(.+?)\s*$", prose, re.MULTILINE)
        if anchor not in {slug(heading) for heading in headings}:
            return "link to a heading that does not exist: " + target
    return ""


def check_name(repository, document, name):
    """A message for one text in backticks, or ""."""
    if re.search(r"[\s<>*{}$~]", name) or name.startswith("-") or name in NOT_PATHS:
        return check_test(repository, name)
    path = re.sub(r":\d+$", "", name)
    if "/" in path and path.split("/")[0] in repository.top:
        beside = os.path.normpath(os.path.join(os.path.dirname(document), path))
        if repository.exists(path) or repository.exists(beside):
            return ""
        message_type = re.fullmatch(r"slim_init/(\w+)", path)
        if message_type and repository.names_source("msg/%s.msg" % message_type.group(1)):
            return ""
        return "path that does not exist: " + name
    if re.fullmatch(r"[\w./-]+", path) and path.endswith(SOURCE_SUFFIXES):
        return "" if repository.names_source(path) else "file that does not exist: " + name
    identifier = re.fullmatch(r"(\w+(?:::\w+)*)(\(\))?", name)
    if identifier and ("::" in name or identifier.group(2)):
        missing = [word for word in identifier.group(1).split("::")
                   if word not in repository.words]
        return "name that the code does not have: " + name if missing else ""
    key = re.fullmatch(r"slim_init((?:\.\w+)+)", name)
    if key and not all(word in repository.words for word in key.group(1)[1:].split(".")):
        return "key that the code does not have: " + name
    return check_test(repository, name)


def check_test(repository, name):
    if re.fullmatch(r"(?:[A-Z]\w+/)?[A-Z]\w+\.(?:[A-Z]\w+|\*)", name):
        return "" if repository.has_test(name) else "test that does not exist: " + name
    return ""


def check_document(repository, document):
    """Messages with line numbers."""
    text = read(os.path.join(repository.root, document))
    prose, code = without_fences(text)
    faults = []
    for number, line in enumerate(prose.split("\n"), 1):
        for target in re.findall(r"\]\(([^)\s]+)\)", re.sub(r"`[^`]*`", "", line)):
            faults.append((number, check_link(repository, document, target)))
        if document in LINKS_ONLY:
            continue
        for name in re.findall(r"`([^`]+)`", line):
            faults.append((number, check_name(repository, document, name)))
            faults += [(number, message) for message in check_command(repository, name)]
    if document not in LINKS_ONLY:
        joined = "\n".join(code).replace("\\\n", "  ")
        for number, line in enumerate(joined.split("\n"), 1):
            faults += [(number, message)
                       for message in check_command(repository, line.split("#")[0])]
    return ["%s:%d: %s" % (document, number, message) for number, message in faults if message]


def check_command(repository, text):
    call = PROGRAM.search(text)
    if not call:
        return []
    return ["slim_init %s has no option --%s" % (call.group(1), option)
            for option in re.findall(r"(?<!\S)--([a-z][a-z0-9-]*)", call.group(2))
            if option not in repository.options and option != "help"]


def main(arguments):
    root = arguments[0] if arguments else os.path.join(os.path.dirname(__file__), "..", "..")
    repository = Repository(os.path.abspath(root))
    documents = [f for f in repository.files if f.endswith(".md")]
    faults = [fault for document in documents for fault in check_document(repository, document)]
    print("\n".join(faults + ["%d documents, %d faults" % (len(documents), len(faults))]))
    return 1 if faults or not documents else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
