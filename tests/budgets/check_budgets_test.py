#!/usr/bin/env python3
# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
"""Tests of check_budgets.py with planted code."""
import sys
import unittest

import check_budgets
from scratch import Scratch

LONG = "int longOne(int a) {\n" + "  ++a;\n" * 59 + "  return a;\n}\n"
SOURCE = """// Copyright
namespace n {
constexpr double kOne = 1.0;
struct Data {
  int a = 3;
  int inside(const std::map<int, double>& b, int c = std::max(1, 2)) {
    return b.size() + c;
  }
};
int declared(int a, int b, int c, int d, int e, int f, int g);
int wide(int a, int b, int c,
         int d, int e, const std::pair<int, int>& f,
         int g) {
  return a;
}
void none() { }
void empty() {
}
""" + LONG + "}  // namespace n\n"


class Functions(unittest.TestCase):
    def test_length_and_parameters(self):
        found = list(check_budgets.functions_in(SOURCE.splitlines()))
        self.assertEqual([(lines, parameters) for _, lines, parameters in found],
                         [(3, 2), (5, 7), (2, 0), (62, 1)])
        self.assertEqual(found[1][0], 11)

    def test_commas_inside_types_and_defaults(self):
        self.assertEqual(check_budgets.parameters_of("f(std::map<int, int> a, int b = g(1, 2))"), 2)
        self.assertEqual(check_budgets.parameters_of("f()"), 0)


class Budgets(Scratch):
    def setUp(self):
        super().setUp()
        self.sizes = dict.fromkeys(check_budgets.SIZES, ("size", 100, 50))
        self.figures = dict.fromkeys(check_budgets.SIZES, 100)

    def test_both_sides(self):
        self.assertEqual(check_budgets.faults_of(self.figures, self.sizes), [])
        self.figures["core_lines"] = 101
        self.assertIn("101 (limit 100)", check_budgets.faults_of(self.figures, self.sizes)[0])
        self.figures["core_lines"] = 96
        self.assertIn("lower it", check_budgets.faults_of(self.figures, self.sizes)[0])

    def test_counts_of_a_planted_tree(self):
        figures, beyond = check_budgets.figures_of(self.new_folder({
            "slim_init/src/a.cc": SOURCE,
            "slim_init/src/module/b.cc": "int f() {\n}\n",
            "slim_init/tools/main.cc": "int main() {\n}\n",
            "tests/t.py": "pass\n",
            "slim_init/include/slim_init/options.h": "struct O {\n  int a = 1;  ///< x\n};\n",
            "slim_init/include/slim_init/initializer.h":
                "class IInitializer {\n  virtual ~IInitializer();\n  virtual int a() = 0;\n};\n"
                "class Other {\n  virtual int b();\n};\n"}))
        self.assertEqual(figures["core_numbers"], 2)
        self.assertEqual(figures["core_top_files"], 1)
        self.assertEqual(figures["core_long_functions"], 1)
        self.assertEqual(figures["core_wide_functions"], 1)
        self.assertEqual(figures["virtual_calls"], 1)
        self.assertEqual(figures["surrounding_lines"], 2)
        self.assertEqual(figures["test_lines"], 1)
        self.assertEqual(len(beyond), 2)


if __name__ == "__main__":
    sys.dont_write_bytecode = True
    unittest.main()
