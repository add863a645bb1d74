#!/usr/bin/env python3
# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
"""Planted faults: check_style.py finds each, and nothing in a page that follows the rules."""
import sys
import unittest

import check_style
from scratch import Scratch, run_to_end

SHORT = "The node reads the file. If a key is unknown, it ends with a message.\n"
LONG = "This sentence " + "goes on and on " * 10 + "for no reason at all.\n"


def faults(text, page="docs/guide.md", budget=100):
    return check_style.check_page(page, text, {page: budget})


class Words(unittest.TestCase):
    def test_budget_has_two_sides(self):
        self.assertEqual(faults("word " * 9 + "word.", budget=10), [])
        found = faults("word " * 10 + "word.", budget=10)
        self.assertEqual(found, ["docs/guide.md: 11 words (budget 10)"])

    def test_a_page_without_a_budget_is_a_fault(self):
        self.assertEqual(len(check_style.check_page("docs/new.md", SHORT, {})), 1)

    def test_total_counts_every_page(self):
        texts = {"a.md": "one two", "b.md": "three"}
        self.assertEqual(check_style.check_total(texts, 3), [])
        self.assertEqual(check_style.check_total(texts, 2), ["all pages: 3 words (limit 2)"])


class Sentences(unittest.TestCase):
    def test_mean_has_two_sides(self):
        words = int(check_style.MEAN_SENTENCE)
        self.assertEqual(faults("Word " + "word " * (words - 2) + "word."), [])
        self.assertEqual(len(faults("Word " + "word " * (words - 1) + "word.")), 1)

    def test_long_sentences_are_found_however_they_are_wrapped(self):
        for text in (LONG, LONG.replace(" on and", " on\nand"), "# Title\n\n" + LONG,
                     LONG.replace(" on and", " on: and"), LONG.replace(" on and", " on; and"),
                     "- item\n\n" + LONG, "```\ncode\n```\n\n" + LONG):
            self.assertEqual(len(faults(text)), 1, text)

    def test_longest_sentence_of_a_guide_has_two_sides(self):
        short = "Word. " * 9
        longest = "Word " + "word " * (check_style.LONGEST_SENTENCE - 2) + "word."
        page = sorted(check_style.GUIDES)[0]
        self.assertEqual(faults(short + longest, page), [])
        found = faults(short + "Word " + longest, page)
        self.assertEqual(found, [page + ": 26 words (limit 25): Word Word word word word word..."])
        self.assertEqual(faults(short + "Word " + longest), [])

    def test_what_is_no_prose_is_not_measured(self):
        for text in ("```\n" + LONG + "```\n", "| " + LONG.strip() + " |\n", "# " + LONG,
                     "- " + LONG, "1. " + LONG, "    " + LONG, "<!-- " + LONG + "-->\n",
                     "$$\n" + LONG + "$$\n"):
            self.assertEqual(check_style.measure(SHORT + "\n" + text)["sentences"], 2, text)

    def test_ends_of_sentences(self):
        for text, lengths in (
                ("One two. Three four five.", [2, 3]), ("Is it so? `x` is.", [3, 2]),
                ("It is 0.5 m. 3 of 4 passed.", [4, 4]), ("As Burri et al. write, so.", [6]),
                ("See [the long page](docs/x.md). End.", [4, 1]),
                ("Here $a + b = c$ holds.", [3]), ("So it is. slim_init is a name.", [3, 4]), ("(One two.) Three.", [2, 1])):
            self.assertEqual([len(s) for s in check_style.sentences(text)], lengths, text)


class Style(unittest.TestCase):
    def test_plain_text_passes(self):
        for text in (SHORT, "The ground truth is recorded. At least four frames are needed.\n",
                     "A least squares fit of left-handed axes. The fraction of tracks. The status is `verdict`.\n",
                     "```\nthe verdict is wrong\n```\n", "| ground truth | 3 |\n|---|---|\n"):
            self.assertEqual(faults(text), [], text)

    def test_every_forbidden_word_is_found(self):
        for word in ("answer", "Answers", "answered", "question", "asked", "asks", "verdict",
                     "told", "handed", "the truth", "wrong", "wrongly", "rig that is off",
                     "rigs off", "sightings", "standing tracks", "carried", "joins", "young",
                     "growing windows", "second look", "left out", "share of", "instants",
                     "anew", "mends", "sane", "hopeless", "least time", "nobody", "whoever",
                     "goals missed", "on 2026-11-22"):
            for text in ("A %s here.\n", "| a %s |\n|---|\n", "- a %s\n", "# A %s\n"):
                self.assertEqual(len(faults(text % word)), 1, text % word)

    def test_phrases_over_two_lines_and_line_numbers(self):
        self.assertEqual(faults("Beside the ground\ntruth. Or\n\n- the ground\n  truth\n"), [])
        found = faults("# Title\n\nTracks that are\nleft\nout. Then `wrong`.\n\n- 2026-11-22\n")
        self.assertEqual([fault.split(": ")[0] for fault in found],
                         ["docs/guide.md:4", "docs/guide.md:7"])

    def test_a_changelog_may_have_dates(self):
        self.assertEqual(faults("Version of 2026-11-22.\n", "CHANGELOG.md"), [])

    def test_where_is_bounded(self):
        self.assertEqual(faults("The folder where it is.\n"), [])
        found = faults("Where it fails, stop. Where it runs, go.\n")
        self.assertEqual(len(found), 1)
        self.assertIn("2 times (limit 1)", found[0])


class Code(unittest.TestCase):
    def test_messages_headers_and_templates_with_a_forbidden_word_are_found(self):
        for path, text in (
                ("src/a.cc", 'fail("the answer is late");\n'),
                ("src/a.cc", 'fail("the answer "\n     "is late");\n'),
                ("src/a.cc", '// comment\nfail("not \\"told\\" so");\n'),
                ("src/a.cc", 'x = \'"\'; fail("an answer");\n'),
                ("src/a.h", '#include "a.h"\nfail("an answer");\n'),
                ("slim_init/include/slim_init/a.h", "/// The answer of a solver.\n"),
                ("slim_init/include/slim_init/a.h", "/// Points that are left\n/// out.\n"),
                ("slim_init/include/slim_init/a.h", "int a;  ///< as asked\n"),
                ("slim_init/include/slim_init/a.h", "/* The answer. */\n"),
                ("a/report.py", 'def f():\n    """The answer."""\n'),
                ("a/report.py", "print('an answer')\n"),
                ("launch/a.sh", 'say "no answer"\n'),
                ("report/a.j2", "{{ page.heading(x) }}\nthe answer\n"),
                ("launch/a.launch", '<arg name="a" doc="an answer"/>\n'),
                ("ros/msg/A.msg", "uint8 a  # an answer\n")):
            self.assertEqual(len(check_style.check_code(path, text)), 1, text)

    def test_names_and_private_comments_are_not_read(self):
        for path, text in (
                ("src/a.cc", "// The answer.\nint answer = 1;\n"),
                ("src/a.h", "/// The answer.\n"),
                ("src/a.cc", '#include "answer"\nkey("answer");\n'),
                ("src/a.cc", 'fail("ground "\n     "truth is missing");\n'),
                ("slim_init/include/slim_init/a.h", "/// `answer`, Host::verdict, truth(), the_answer.\n"),
                ("slim_init/include/slim_init/a.h", "/// The ground\n/// truth.\nAnswer answer;\n"),
                ("a/report.py", "answer = 'answer'  # the answer\n"),
                ("report/a.j2", "{# the answer #}{% set answer = 1 %}{{ answer }}\n"),
                ("ros/msg/A.msg", "InitStatus verdict  # its status\n"),
                ("a/notes.txt", "the answer\n")):
            self.assertEqual(check_style.check_code(path, text), [], text)


class Program(Scratch):
    def run_on(self, pages):
        return run_to_end(sys.executable, check_style.__file__, self.new_folder(pages))

    def test_exit_code_and_lines(self):
        pages = {page: SHORT for page in check_style.BUDGETS}
        run = self.run_on(pages)
        self.assertEqual(run.returncode, 0, run.stdout)
        self.assertTrue(run.stdout.endswith(" 0 faults\n"), run.stdout)
        run = self.run_on({**pages, "README.md": "\nA wrong word.\n"})
        self.assertEqual(run.returncode, 1)
        self.assertTrue(run.stdout.startswith("README.md:2: \"wrong\": write: "), run.stdout)
        run = self.run_on({**pages, "src/a.cc": 'fail("an answer");\n',
                           "tests/a.cc": 'fail("an answer");\n'})
        self.assertEqual(run.returncode, 1)
        self.assertTrue(run.stdout.startswith("src/a.cc:1: "), run.stdout)
        self.assertIn(" 1 faults", run.stdout)
        del pages["README.md"]
        run = self.run_on(pages)
        self.assertEqual(run.returncode, 1)
        self.assertIn("README.md: has a budget and does not exist", run.stdout)


if __name__ == "__main__":
    unittest.main()
