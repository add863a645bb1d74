#!/usr/bin/env bash
# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#
# Names of the tests that files of CMake declare, those of foreach loops included, one a line.
#   tests/declared_tests.sh CMakeLists.txt...
set -euo pipefail
for file in "$@"; do
  tr '\n' ' ' <"${file}" |
    { grep -oE '(foreach|slim_init_add(_backend)?_test|add_test) *\([^)]*' || true; }
done | tr '(' ' ' | awk '
  $1 == "foreach" { count = split($0, loop); next }
  { name = $2 == "NAME" ? $3 : $2 }
  name ~ /^[a-z0-9_]+$/ { print name; next }
  count > 2 && index(name, "${" loop[2] "}") {
    for (i = 3; i <= count; ++i) {
      one = name
      sub(/\$\{[^}]*\}/, loop[i], one)
      print one
    }
  }' | sort -u
