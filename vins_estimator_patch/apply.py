#!/usr/bin/env python3
# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
"""Inserts slim_init into your own checkout of a host of the VINS family, or takes it out again.

Every insertion is a marked block of whole lines beside an anchor that has to be found exactly once.
Nothing else is touched, so that --revert gives back the same bytes. Either all files are written or
none. Applying twice changes nothing; applying a newer version of this tool replaces the old blocks.
What is inserted where is data: hosts/*.json name files and anchors of a host, insertions/*.txt hold
the text.
"""
import argparse
import bisect
import difflib
import itertools
import json
import os
import re
import stat
import sys
import tempfile

BEGIN = ">>> slim_init"
END = "<<< slim_init"


class Problem(Exception):
    """A message for the user."""


class Insertion:
    """Lines of ours before or after the lines of the host that read like `anchor`.

    Whitespace, comments and the breaks of lines do not count in the comparison: forks differ in
    them. An anchor that ends with "..." is the beginning of a statement, to insert before.
    With `inside`, the anchor is looked for from the line that reads like that one to the first
    line that begins with "}": a host may have several functions that hold the same lines.
    """

    def __init__(self, anchor, where, code, inside="", name=""):
        assert where in ("before", "after")
        self.anchor = anchor if isinstance(anchor, list) else [anchor]
        self.where = where
        self.code = code.strip("\n").split("\n")
        self.inside = inside
        self.name = name

    def missing(self, scope):
        """The line that was not found: of the anchor, or of the function that holds it."""
        return self.inside if self.inside and scope[0] == scope[1] else self.anchor[0]


STRING = r'("(?:\\.|[^"\\\n])*")'
COMMENTS = {"xml": r"<!--.*?-->", "txt": r"#\[(=*)\[.*?\]\2\]|#[^\n]*"}  # by the ends of names


def code_of(path, text):
    """The lines of `text` without whitespace and comments."""
    remark = STRING + "|" + COMMENTS.get(path[-3:], r"//[^\n]*|/\*.*?\*/")
    kept = re.sub(remark, lambda match: match.group(1) or "\n" * match.group().count("\n"), text,
                  flags=re.DOTALL)
    return [re.sub(r"\s+", "", line) for line in kept.split("\n")]


# ------------------------------------------------------------------------------------------- hosts

HERE = os.path.dirname(os.path.abspath(__file__))
HOST_KEYS = {"title", "repository", "checked_at", "like", "folder", "files", "recognised_by", "in",
             "words", "insertions", "repairs", "why"}
INSERTION_KEYS = {"file", "before", "after", "text", "in", "why"}
PLACEHOLDER = re.compile("@([a-z_]+)@")


class Host:
    """A description in hosts/, with what it takes over from the one that it is like.

    Its "repairs" are names of insertions and of words that improve the host itself: without
    `repaired` these insertions are omitted, and these words are empty."""

    def __init__(self, name, data, repaired=True):
        self.name = name
        self.title = data["title"]
        self.checked_at = data.get("checked_at", "")
        folder = data.get("folder", "")
        paths = {kind: "/".join(filter(None, [folder, path]))
                 for kind, path in data["files"].items()}
        self.code_files = [paths[kind] for kind in ("header", "source", "node")]
        self.recognised_by = [(paths[sign["file"]], sign["line"])
                              for sign in data.get("recognised_by", [])]
        self.files = {}  # path: insertions
        repairs = data.get("repairs", [])
        for key in repairs:
            if key not in data["insertions"] and key not in data["words"]:
                raise Problem("%s: the repair \"%s\" is no insertion and no word" % (name, key))
        left_out = [] if repaired else repairs
        words = {key: type(word)() if key in left_out else word
                 for key, word in data["words"].items()}
        for key, entry in data["insertions"].items():
            if entry is not None and key not in left_out:
                self.add(key, entry, data, paths, words)

    def add(self, key, entry, data, paths, words):
        what = "%s, insertion \"%s\"" % (self.name, key)
        unknown = set(entry) - INSERTION_KEYS
        if unknown:
            raise Problem("%s: unknown key \"%s\"" % (what, sorted(unknown)[0]))
        if entry.get("file") not in paths:
            raise Problem("%s: \"file\" is %s, must be one of %s"
                          % (what, entry.get("file"), ", ".join(sorted(paths))))
        if ("before" in entry) == ("after" in entry):
            raise Problem("%s: needs either \"before\" or \"after\"" % what)
        where = "before" if "before" in entry else "after"
        inside = entry.get("in", data.get("in", {}).get(entry["file"], ""))
        code = filled(text_of(entry.get("text", key), what), words, what)
        insertion = Insertion(entry[where], where, "\n".join(code), inside, key)
        insertion.anchor = filled(insertion.anchor, words, what)
        self.files.setdefault(paths[entry["file"]], []).append(insertion)

    def total(self):
        return sum(map(len, self.files.values()))


def text_of(name, what):
    path = os.path.join(HERE, "insertions", name + ".txt")
    try:
        return read(path).rstrip("\n").split("\n")
    except OSError:
        raise Problem("%s: there is no text %s" % (what, path))


def filled(lines, words, what):
    """`lines` with @word@ replaced; one alone on its line may stand for any number of lines."""
    def word(name):
        if name not in words:
            raise Problem("%s: the word \"%s\" is not defined" % (what, name))
        return words[name]

    result = []
    for line in lines:
        alone = PLACEHOLDER.match(line.strip())
        if alone and alone.group() == line.strip() and isinstance(word(alone.group(1)), list):
            margin = line[:len(line) - len(line.lstrip())]
            result += [margin + more for more in word(alone.group(1))]
        else:
            result.append(PLACEHOLDER.sub(lambda match: word(match.group(1)), line))
    return result


def description(path, seen=()):
    """Data of a host's JSON file, over those of the host that it is "like": of files, words and
    insertions single entries are replaced. Faults of the file are Problems."""
    try:
        data = json.loads(read(path))
    except OSError as problem:
        raise Problem("%s: cannot be read: %s" % (path, problem.strerror))
    except ValueError as problem:
        raise Problem("%s: not JSON: %s" % (path, problem))
    if not isinstance(data, dict):
        raise Problem("%s: must be an object" % path)
    unknown = set(data) - HOST_KEYS
    if unknown:
        raise Problem("%s: unknown key \"%s\", known are %s"
                      % (path, sorted(unknown)[0], ", ".join(sorted(HOST_KEYS))))
    parent = {}
    if "like" in data:
        seen += (name_of(path),)
        if data["like"] in seen:
            raise Problem("%s: \"%s\" is like itself" % (path, data["like"]))
        parent = description(os.path.join(HERE, "hosts", data["like"] + ".json"), seen)
    merged = {key: value for key, value in parent.items() if key not in ("recognised_by", "in")}
    for key, value in data.items():
        merged[key] = value
        if key in ("files", "words", "insertions") and key in parent:
            merged[key] = {**parent[key], **value}
    for key in ("title", "files", "words", "insertions"):
        if key not in merged:
            raise Problem("%s: needs \"%s\", or \"like\" with the name of another host"
                          % (path, key))
    return merged


def name_of(path):
    return os.path.splitext(os.path.basename(path))[0]


def load_host(path, repaired=True):
    try:
        return Host(name_of(path), description(path), repaired)
    except (AttributeError, KeyError, TypeError, ValueError) as problem:
        raise Problem("%s: not a description of a host: %s" % (path, problem))


def known_hosts(repaired=True):
    """{name: Host}"""
    names = sorted(os.listdir(os.path.join(HERE, "hosts")))
    return {name[:-len(".json")]: load_host(os.path.join(HERE, "hosts", name), repaired)
            for name in names if name.endswith(".json")}


# ------------------------------------------------------------------------------------ text of files


def comment(path, text):
    if path.endswith(".xml"):
        return "<!-- %s -->" % text
    if path.endswith("CMakeLists.txt"):
        return "# " + text
    return "// " + text


def lines_of(text):
    """Lines with their ends; "\r" alone ends none."""
    return re.findall(r"[^\n]*\n|[^\n]+", text)


def end_of(line):
    return "\r\n" if line.endswith("\r\n") else "\n" if line.endswith("\n") else ""


def stripped(path, text):
    """`text` without our blocks, and how many there were."""
    kept, opened, blocks = [], None, 0
    for number, line in enumerate(lines_of(text), 1):
        content = line.strip()
        if content == comment(path, BEGIN):
            if opened is not None:
                raise Problem("%s:%d: \"%s\" inside the block that starts in line %d; repair the "
                              "file by hand" % (path, number, BEGIN, opened))
            opened, blocks = number, blocks + 1
        elif content == comment(path, END):
            if opened is None:
                raise Problem("%s:%d: \"%s\" without its \"%s\"; repair the file by hand"
                              % (path, number, END, BEGIN))
            opened = None
            if not end_of(line) and kept:
                # The block stands behind a last line without an end, and brought that end along.
                kept[-1] = kept[-1][:-len(end_of(kept[-1]))]
        elif opened is None:
            kept.append(line)
    if opened is not None:
        raise Problem("%s:%d: \"%s\" without its \"%s\"; repair the file by hand"
                      % (path, opened, BEGIN, END))
    return "".join(kept), blocks


def places(path, lines, anchor, where="before", scope=None):
    """[(first line of the anchor, line after it)] in `scope`, [first, last), or all of `lines`. What
    is inserted `where` "before" may stand before an anchor that a brace follows."""
    codes = code_of(path, "".join(lines))
    begins = [0] + list(itertools.accumulate(map(len, codes)))
    code, wanted = "".join(codes), "".join(code_of(path, "\n".join(anchor)))
    begun = wanted.endswith("...")
    wanted = wanted[:-3] if begun else wanted
    found = []
    for i in range(*scope or (0, len(lines))):
        end = begins[i] + len(wanted)
        if not wanted or begins[i] == begins[i + 1] or not code.startswith(wanted, begins[i]):
            continue
        after = bisect.bisect_left(begins, end)
        opens = where == "before" and (begun or code.startswith("{", end))
        place = i if where == "before" else after
        in_comment = "".join(code_of(path, "".join(lines[:place]))) != code[:begins[place]]
        if (opens or not begun and begins[after] == end) and not in_comment:
            found.append((i, after))
    return found


def found_at(path, lines, insertion):
    """places() of the anchor, and the scope that was searched."""
    scope = (0, len(lines))
    if insertion.inside:
        heads = places(path, lines, [insertion.inside])
        if len(heads) != 1:
            return [], (0, 0)
        first = heads[0][0]
        last = next((i for i in range(first, len(lines)) if lines[i].startswith("}")), len(lines))
        scope = (first, last)
    return places(path, lines, insertion.anchor, insertion.where, scope), scope


def anchored(path, lines, insertion):
    """The only one of its places()."""
    found, scope = found_at(path, lines, insertion)
    if len(found) != 1:
        times = "not found" if not found else "found %d times (lines %s)" % (
            len(found), ", ".join(str(i + 1) for i, _ in found))
        raise Problem("%s: the anchor \"%s\" is %s, must be there once: this checkout differs from "
                      "the one that the tool knows; --diagnose lists what fits"
                      % (path, insertion.missing(scope), times))
    return found[0]


def inserted(path, text, insertions):
    lines = lines_of(text)
    at = {}
    for insertion in insertions:
        first, after = anchored(path, lines, insertion)
        place = first if insertion.where == "before" else after
        beside = lines[first if insertion.where == "before" else place - 1]
        eol = end_of(beside) or end_of(lines[0]) or "\n"
        block = "".join(line + eol for line in [comment(path, BEGIN)] + insertion.code +
                        [comment(path, END)])
        if insertion.where == "after" and not end_of(beside):
            block = eol + block[:-len(eol)]
        at.setdefault(place, []).append(block)
    result = []
    for i in range(len(lines) + 1):
        result += at.get(i, [])
        if i < len(lines):
            result.append(lines[i])
    return "".join(result)


# ---------------------------------------------------------------------------------------- the tool


def read(path):
    # One character per byte: whatever encoding the file has comes back as it was.
    with open(path, "rb") as stream:
        return stream.read().decode("latin-1")


def write_all(contents):
    """{path: text}: all of them or none."""
    staged, replaced = {}, {}
    try:
        for path, text in contents.items():
            target = os.path.realpath(path)
            handle, name = tempfile.mkstemp(prefix=".slim_init-", dir=os.path.dirname(target))
            staged[target] = name
            with os.fdopen(handle, "wb") as stream:
                stream.write(text.encode("latin-1"))
                stream.flush()
                os.fsync(stream.fileno())
            os.chmod(name, stat.S_IMODE(os.stat(target).st_mode))
        for target, name in list(staged.items()):
            before = read(target)
            os.replace(name, target)
            del staged[target]
            replaced[target] = before
    except OSError as problem:
        for target, before in replaced.items():
            with open(target, "wb") as stream:
                stream.write(before.encode("latin-1"))
        raise Problem("%s cannot be written: %s; nothing was changed"
                      % (problem.filename or "a file", problem.strerror))
    finally:
        for name in staged.values():
            if os.path.exists(name):
                os.remove(name)


def holds(checkout, host):
    """The host's sources are there, and so are the lines that tell it from its relatives."""
    for path in host.code_files:
        if not os.path.isfile(os.path.join(checkout, path)):
            return False
    for path, line in host.recognised_by:
        file = os.path.join(checkout, path)
        if not os.path.isfile(file) or not places(path, lines_of(read(file)), [line]):
            return False
    return True


def host_of(checkout, hosts):
    fits = [host for host in hosts.values() if holds(checkout, host)]
    # The one that asks for most: a fork has the files of its original.
    most = max([len(host.recognised_by) for host in fits] or [0])
    fits = [host for host in fits if len(host.recognised_by) == most]
    if len(fits) == 1:
        return fits[0]
    raise Problem("%s: holds %s; give the folder that holds the host, or --host, or describe your "
                  "fork (docs/port_to_your_fork.md)"
                  % (checkout, "the files of " + " and ".join(host.name for host in fits) if fits
                     else "none of the known hosts (%s)" % ", ".join(hosts)))


def chosen_host(options):
    if options.host and options.host.endswith(".json"):
        return load_host(options.host, not options.without_repairs)
    hosts = known_hosts(not options.without_repairs)
    if options.host and options.host not in hosts:
        raise Problem("%s: no such host; known are %s, or give a file *.json"
                      % (options.host, ", ".join(hosts)))
    return hosts[options.host] if options.host else host_of(options.checkout, hosts)


# ---------------------------------------------------------------------------------- what fits

def examined(checkout, host):
    """[(path, problem or "", its lines, [(insertion, places found, scope)])]"""
    result = []
    for path, insertions in host.files.items():
        file = os.path.join(checkout, path)
        if not os.path.isfile(file):
            result.append((path, "not there", [], []))
            continue
        try:
            lines = lines_of(stripped(file, read(file))[0])
        except Problem as problem:
            result.append((path, str(problem), [], []))
            continue
        rows = [(insertion,) + found_at(path, lines, insertion) for insertion in insertions]
        result.append((path, "", lines, rows))
    return result


def count_matches(examination):
    return sum(len(found) == 1 for _, _, _, rows in examination for _, found, _ in rows)


def nearest(path, insertion, scope, lines):
    """(line number, text) of the line most like the one that is missing, or None."""
    first, last = scope if scope[0] < scope[1] else (0, len(lines))
    bodies = code_of(path, "".join(lines))[first:last]
    close = difflib.get_close_matches(code_of(path, insertion.missing(scope))[0],
                                      [body for body in bodies if body], 1, 0.5)
    return (first + bodies.index(close[0]) + 1, lines[first + bodies.index(close[0])].strip()) \
        if close else None


def shortened(text, width=100):
    return text if len(text) <= width else text[:width - 3] + "..."


def diagnosis(options):
    """Text, and whether everything fits."""
    out = []
    if options.host:
        host = chosen_host(options)
    else:
        scored = []
        for host in known_hosts(not options.without_repairs).values():
            found = count_matches(examined(options.checkout, host))
            scored.append((holds(options.checkout, host), len(host.recognised_by), found, host))
        scored.sort(key=lambda row: (row[0], row[1] if row[0] else 0, row[2]), reverse=True)
        out.append("hosts by how well they fit (anchors found once, of all):")
        out += ["  %-12s %2d of %2d%s" % (host.name, found, host.total(),
                                        "" if known else ", files or signs of it are missing")
                for known, _, found, host in scored]
        host = scored[0][3]
    out.append("%s: %s%s, %d insertions in %d files"
               % (host.name, host.title, " at " + host.checked_at if host.checked_at else "",
                  host.total(), len(host.files)))
    examination = examined(options.checkout, host)
    fits = True
    for path, problem, lines, rows in examination:
        out.append("  %s%s" % (path, ": " + problem if problem else ""))
        fits = fits and not problem
        for insertion, found, scope in rows:
            name, anchor = insertion.name, shortened(insertion.missing(scope))
            if len(found) == 1:
                out.append("    ok        %-12s line %d: %s" % (name, found[0][0] + 1, anchor))
                continue
            fits = False
            if found:
                out.append("    %d TIMES   %-12s lines %s: %s" % (
                    len(found), name, ", ".join(str(i + 1) for i, _ in found), anchor))
                out.append("              give the function as \"in\", or more lines of the anchor")
                continue
            out.append("    NOT FOUND %-12s %s%s" % (
                name, "" if insertion.missing(scope) == insertion.anchor[0] else "the function ",
                anchor))
            close = nearest(path, insertion, scope, lines)
            if close:
                out.append("              nearest is line %d: %s" % (close[0], shortened(close[1])))
    out.append("%d of %d anchors match%s" % (
        count_matches(examination), host.total(),
        "; the patch can be applied" if fits else "; what to do: docs/port_to_your_fork.md"))
    return "\n".join(out), fits


def run(options):
    host = chosen_host(options)
    present, wanted, blocks = {}, {}, 0
    for path, insertions in host.files.items():
        file = os.path.join(options.checkout, path)
        try:
            present[file] = read(file)
        except OSError as problem:
            raise Problem("%s: cannot be read: %s" % (file, problem.strerror))
        bare, count = stripped(file, present[file])
        blocks += count
        wanted[file] = bare if options.revert else inserted(file, bare, insertions)
    changed = {file: text for file, text in wanted.items() if text != present[file]}
    made = "%d insertions in %d files" % (host.total(), len(wanted))
    if not changed:
        return "%s: %s" % (host.name, "nothing of slim_init is in it" if options.revert
                           else "already applied, " + made)
    if not options.check:
        write_all(changed)
    if options.revert:
        return "%s: %d insertions %s %d files" % (
            host.name, blocks, "can be taken out of" if options.check else "taken out of",
            len(changed))
    return "%s: %s%s%s" % (host.name, made, " can be made" if options.check else "",
                           ", in place of %d earlier ones" % blocks if blocks else "")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("checkout", metavar="CHECKOUT", help="folder of the host's repository")
    what = parser.add_mutually_exclusive_group()
    what.add_argument("--check", action="store_true", help="print what would be done and stop")
    what.add_argument("--diagnose", action="store_true",
                      help="list every anchor: found, found more than once, not found and the "
                      "nearest line; ends with 1 unless all fit; changes nothing")
    parser.add_argument("--revert", action="store_true", help="remove all insertions")
    parser.add_argument("--without-repairs", action="store_true",
                        help="leave out what improves the host itself and not its start: "
                        "keep_heading, and depths from all views")
    parser.add_argument("--host", "--flavour", metavar="NAME|FILE.json",
                        help="a name in hosts/ or a description of your own; default: recognised")
    options = parser.parse_args()
    try:
        if not os.path.isdir(options.checkout):
            raise Problem("%s: no such folder" % options.checkout)
        if options.diagnose:
            text, fits = diagnosis(options)
            print(text)
            return 0 if fits else 1
        print(run(options))
    except Problem as problem:
        print("apply.py: %s" % problem, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
