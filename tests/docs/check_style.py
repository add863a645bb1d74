#!/usr/bin/env python3
# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
"""Checks that the documents are short, and that documents, messages and public headers are plain.

    check_style.py [REPOSITORY]

Of every Markdown file of the repository:
  - words: at most the budget of the page (BUDGETS; a page without a row is a fault), and at most
    TOTAL_WORDS in all pages that a reader is sent to. A word is what `wc -w` counts, if it has a
    letter or a digit: bars of tables, list marks and rules do not count, code does.
  - mean length of a sentence: at most MEAN_SENTENCE words. Only paragraphs of prose are measured:
    fenced and indented code, tables, headings, list items, HTML comments and displayed formulas are
    excluded, because they hold fragments. A code span, a link target and a formula
    in a line are one word. A sentence ends with . ! or ?, not with a colon or a semicolon.
  - length of each sentence of a GUIDE: at most LONGEST_SENTENCE words.
  - words and dates that the style rules replace (FORBIDDEN), in all prose, tables and lists, not
    in code. A changelog may have dates.
  - the same words in messages (string literals with a space) of C++ and Python, in shell strings,
    templates of reports, launch and message files, and in the comments of public headers. Tests may
    use them, and so may identifiers: text in backticks and words with ( ) :: _ are not read.
  - "where": at most one, and one more per WORDS_PER_WHERE words. It is a good word for a place and
    a bad one for a condition ("if", "when"); no pattern tells them apart, so its density is bounded.

Prints one line per fault and ends with 1 if there is any. Needs python3's standard library only.
"""
import bisect
import io
import os
import re
import sys
import tokenize

from check_documents import files_of, read, without_fences

TOTAL_WORDS = 27800
MEAN_SENTENCE = 18.0
LONGEST_SENTENCE = 25
WORDS_PER_WHERE = 400
# Pages for users; the others hold definitions and lists that are one sentence.
GUIDES = {"README.md", "config/README.md", "docs/README.md", "docs/calibration.md",
          "docs/does_not_initialize.md", "docs/hosts.md", "docs/openvins.md", "docs/own_rig.md",
          "docs/port_to_your_fork.md", "docs/recovery.md", "docs/ros.md", "docs/vins_mono.md"}

BUDGETS = {
    "README.md": 700,
    "CHANGELOG.md": 1500,
    "CONTRIBUTING.md": 1000,
    "SECURITY.md": 350,
    "config/README.md": 500,
    "vins_estimator_patch/README.md": 500,
    "docs/README.md": 250,
    "docs/another_estimator.md": 350,
    "docs/architecture.md": 1100,
    "docs/backend.md": 700,
    "docs/baselines.md": 2000,
    "docs/benchmark.md": 3000,
    "docs/calibration.md": 1100,
    "docs/derivation.md": 7000,
    "docs/doctor.md": 1000,
    "docs/does_not_initialize.md": 800,
    "docs/evaluation.md": 3000,
    "docs/hosts.md": 600,
    "docs/img/README.md": 150,
    "docs/notation.md": 600,
    "docs/openvins.md": 600,
    "docs/own_rig.md": 1200,
    "docs/port_to_your_fork.md": 900,
    "docs/recovery.md": 1200,
    "docs/reliability.md": 1200,
    "docs/ros.md": 1100,
    "docs/simulation.md": 1000,
    "docs/vins_mono.md": 1500,
}

# Pattern (case does not count) and what to write instead. Only words that are never the better
# choice here; "right", "way", "look" or "join threads" have honest uses and are for the reviewer.
FORBIDDEN = [
    (r"answer(s|ed)?", "estimate, solution, result"),
    (r"questions?|asks|asked", "solve, solved"),
    (r"verdicts?", "status"),
    (r"told|(?<!-)handed", "given, passed"),
    (r"(?<!ground )(?<!ground-)truth", "ground truth"),
    (r"wrong(ly)?", "incorrect"),
    (r"(that|which) (is|are) off|rigs? off", "miscalibrated"),
    (r"sightings?", "observation"),
    (r"standing tracks?", "static tracks"),
    (r"carried", "propagated"),
    (r"joins|joined", "continues the odometry frame"),
    (r"young|growing windows?", "short, expanding window"),
    (r"second look", "consistency check"),
    (r"left out|silently dropped|dropped silently", "discarded, counted"),
    (r"shares? of", "fraction of"),
    (r"instants?", "timestamp"),
    (r"anew|afresh", "restarted, again"),
    (r"mend(s|ed|ing)?", "repair"),
    (r"(in)?sane", "healthy"),
    (r"hopeless|levelled", "the name of the quantity"),
    (r"(?<!at )least(?! squares)", "minimum"),
    (r"nobody|whoever", "a subject"),
    (r"tried without gain|goals? missed", "nothing: docs say what is true"),
]
DATE = r"\b20\d\d-\d\d-\d\d\b"


def words_of(text):
    return [word for word in text.split() if re.search(r"\w", word)]


def prose_of(text):
    """Text without fenced code, HTML comments and displayed formulas."""
    text = re.sub(r"<!--.*?-->", "", without_fences(text)[0], flags=re.DOTALL)
    return re.sub(r"\$\$.*?\$\$", "", text, flags=re.DOTALL)


def paragraphs(text):
    """Paragraphs of prose, each one line: no indented code, tables, headings, list items."""
    found, current = [], []
    for line in prose_of(text).split("\n") + [""]:
        if not line.strip():
            found += [" ".join(current)] if current else []
            current = []
        elif not re.match(r"[#|>\s]|[-*+]\s|\d+\.\s|!\[", line):
            current.append(line.strip())
    return found


def plain(text):
    """One line with code spans, formulas and link targets reduced to one word or none."""
    text = re.sub(r"`[^`]*`", "CODE", text)
    text = re.sub(r"\$[^$]+\$", "FORMULA", text)
    text = re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", text)
    return re.sub(r"\b(e\.g|i\.e|et al|cf|vs|Fig|Eq|eq|Sec|No)\.", r"\1", text)


def sentences(paragraph):
    parts = re.split(r"(?<=[.!?])[)\"*]*\s+(?=[\"(*]*(?:[A-Z0-9]|slim_init\b))", plain(paragraph))
    return [words_of(part) for part in parts if words_of(part)]


def measure(text):
    """Words, sentences and their mean length, and the count of `where`."""
    lengths = [len(s) for paragraph in paragraphs(text) for s in sentences(paragraph)]
    prose = "\n".join(plain(line) for line in prose_of(text).split("\n"))
    return {"words": len(words_of(text)),
            "sentences": len(lengths),
            "mean": sum(lengths) / len(lengths) if lengths else 0.0,
            "where": len(re.findall(r"\bwhere\b", prose, re.IGNORECASE))}


def hits_of(text, patterns):
    """(line, words found, advice) in text; a phrase may be broken over two lines."""
    lines = [plain(line).strip() for line in text.split("\n")]
    joined = " ".join(lines)
    starts = [0]
    for line in lines:
        starts.append(starts[-1] + len(line) + 1)
    return sorted((bisect.bisect_right(starts, hit.start()), hit.group(0), advice)
                  for pattern, advice in patterns
                  for hit in re.finditer(pattern, joined, re.IGNORECASE))


def forbidden_patterns():
    return [(r"\b(?:%s)\b" % words, "write: " + instead) for words, instead in FORBIDDEN]


def check_words(page, text):
    """Faults of words and dates, with their lines."""
    patterns = forbidden_patterns()
    if page != "CHANGELOG.md":
        patterns.append((DATE, "dates are for the changelog"))
    return ["%s:%d: \"%s\": %s" % ((page,) + hit)
            for hit in hits_of(without_fences(text)[0], patterns)]


CPP_TOKEN = re.compile(r"//[^\n]*|/\*.*?\*/|\"(?:\\.|[^\"\\\n])*\"|'(?:\\.|[^'\\\n])*'", re.DOTALL)


def cpp_texts(text, comments):
    """(line, text) of adjacent string literals that hold a space, and of blocks of comments."""
    found, end, last = [], 0, ""
    for token in CPP_TOKEN.finditer(text):
        kind, body = token.group(0)[0], token.group(0)
        line = text.count("\n", 0, token.start()) + 1
        if kind == '"' or (kind == "/" and comments):
            body = body[1:-1] if kind == '"' else re.sub(r"^/[/*]+!?<?|\*/$", "", body)
            joins = last == kind and not text[end:token.start()].strip()
            if joins:
                body = found[-1][1] + ("" if kind == '"' else "\n") + body
                line = found.pop()[0]
            found.append((line, body))
        end, last = token.end(), kind
    return [(line, body) for line, body in found if re.search(r"\s", body.strip())]


def code_texts(path, text):
    """What a user or host author reads of a file of code: (line, text)."""
    if path.endswith((".cc", ".h", ".cpp")):
        public = path.endswith(".h") and "/include/" in path
        return [(line, re.sub(r"[\w.]*(?:\(\)|::|_)[\w.:]*", "CODE", body))
                for line, body in cpp_texts(text, public)]
    if path.endswith(".py"):
        tokens = tokenize.generate_tokens(io.StringIO(text).readline)
        return [(token.start[0], token.string) for token in tokens
                if token.type == tokenize.STRING and " " in token.string]
    if path.endswith(".sh"):
        return [(text.count("\n", 0, hit.start()) + 1, hit.group(0))
                for hit in re.finditer(r'"[^"\n]* [^"\n]*"', text)]
    if path.endswith(".j2"):
        return [(1, re.sub(r"\{[{%#].*?[}%#]\}", lambda hit: "\n" * hit.group(0).count("\n"), text,
                           flags=re.DOTALL))]
    if path.endswith(".launch"):
        return [(1, text)]
    if path.endswith(".msg"):
        return [(1, "\n".join(line.partition("#")[2] for line in text.split("\n")))]
    return []


def check_code(path, text):
    """Forbidden words in messages, templates and public headers."""
    return ["%s:%d: \"%s\": %s" % (path, line + number - 1, words, advice)
            for line, body in code_texts(path, text)
            for number, words, advice in hits_of(body, forbidden_patterns())]


def check_page(page, text, budgets=None):
    """Faults of one page."""
    budgets = BUDGETS if budgets is None else budgets
    if page not in budgets:
        return ["%s: no budget of words; add a row to BUDGETS" % page]
    figures, faults = measure(text), []
    if figures["words"] > budgets[page]:
        faults.append("%s: %d words (budget %d)" % (page, figures["words"], budgets[page]))
    if figures["mean"] > MEAN_SENTENCE:
        faults.append("%s: sentences of %.1f words in the mean (limit %g)"
                      % (page, figures["mean"], MEAN_SENTENCE))
    if page in GUIDES:
        faults += ["%s: %d words (limit %d): %s..." % (page, len(s), LONGEST_SENTENCE, " ".join(s[:6]))
                   for paragraph in paragraphs(text) for s in sentences(paragraph)
                   if len(s) > LONGEST_SENTENCE]
    allowed = 1 + figures["words"] // WORDS_PER_WHERE
    if figures["where"] > allowed:
        faults.append("%s: \"where\" %d times (limit %d); a condition begins with if or when"
                      % (page, figures["where"], allowed))
    return faults + check_words(page, text)


def check_total(texts, limit=TOTAL_WORDS):
    total = sum(len(words_of(text)) for text in texts.values())
    return ["all pages: %d words (limit %d)" % (total, limit)] if total > limit else []


def main(arguments):
    root = os.path.abspath(arguments[0] if arguments
                           else os.path.join(os.path.dirname(__file__), "..", ".."))
    files = files_of(root)
    texts = {page: read(os.path.join(root, page)) for page in files if page.endswith(".md")}
    codes = [path for path in files if not path.startswith("tests/")]
    faults = [fault for page, text in sorted(texts.items()) for fault in check_page(page, text)]
    faults += ["%s: has a budget and does not exist" % page
               for page in sorted(set(BUDGETS) - set(texts))]
    faults += check_total(texts)
    faults += [fault for path in codes
               for fault in check_code(path, read(os.path.join(root, path)))]
    total = sum(len(words_of(t)) for t in texts.values())
    print("\n".join(faults + ["%d documents, %d words, %d faults" % (len(texts), total, len(faults))]))
    return 1 if faults or not texts else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
