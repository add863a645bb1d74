#!/usr/bin/env python3
# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
"""Planted faults: check_documents.py finds each, and nothing in a document that is right."""
import unittest

import check_documents
from scratch import Scratch

FILES = {
    "docs/guide.md": "# Guide\n\n## Two parts, `one` page\n",
    "slim_init/src/slim.cc": "void solveAll() {}\n",
    "slim_init/include/slim_init/types.h": "struct Types { int width; };\n",
    "slim_init/tools/ab.cc": 'add("stride", "help");\n',
    "slim_init/ros/msg/InitStatus.msg": "int32 code\n",
    "tests/core/core_test.cc": "TEST(Core, Solves) {}\n",
}


class CheckDocuments(Scratch):
    def faults(self, text):
        root = self.new_folder({**FILES, "README.md": text})
        return check_documents.check_document(check_documents.Repository(root), "README.md")

    def test_right_names_pass(self):
        for text in ("[a](docs/guide.md)", "[a](docs/guide.md#two-parts-one-page)",
                     "[a](https://example.org/x)", "`slim_init/src/slim.cc`", "`slim.cc`",
                     "`slim_init/types.h`", "`slim_init/src`", "`slim_init/InitStatus`",
                     "`solveAll()`", "`Types::width`", "`Core.Solves`", "`Core.*`",
                     "`slim_init ab --stride 5`", "```\nslim_init ab --stride 5\n```",
                     "`slim_init.width`", "```\n[a](nowhere.md)\n```", "`report.md`"):
            self.assertEqual(self.faults(text), [], text)

    def test_wrong_names_are_found(self):
        for text in ("[a](docs/gone.md)", "[a](docs/guide.md#three-parts)", "[a](../outside.md)",
                     "`slim_init/src/gone.cc`", "`gone.cc`", "`slim_init/gone.h`",
                     "`slim_init/gone`", "`slim_init/GoneStatus`", "`goneAll()`", "`Types::gone`",
                     "`Core.Gone`", "`Gone.*`", "`slim_init ab --gone 5`",
                     "```\nslim_init ab \\\n  --gone 5\n```", "`slim_init.gone`"):
            self.assertEqual(len(self.faults(text)), 1, text)


if __name__ == "__main__":
    unittest.main()
