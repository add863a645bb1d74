#!/usr/bin/env bash
# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#
# Checks the formatting of every C++ file with clang-format 14 (other versions format differently).
#   ./tests/format.sh          checks; ends with 1 on a difference, 77 without clang-format 14
#   ./tests/format.sh --fix    formats in place
set -euo pipefail
cd "$(dirname -- "${BASH_SOURCE[0]}")/.."

formatter=""
for candidate in clang-format-14 clang-format; do
  if [[ "$("${candidate}" --version 2>/dev/null || true)" == *"version 14."* ]]; then
    formatter="${candidate}"
    break
  fi
done
if [[ -z "${formatter}" ]]; then
  echo "skipped: clang-format 14 is not installed"
  exit 77
fi

mapfile -d '' -t files < <(find slim_init feature_tracker_lines vins_estimator_patch tests \
  \( -name '*.h' -o -name '*.cc' \) -print0 | sort -z)
if [[ "${1:-}" == --fix ]]; then
  "${formatter}" -i "${files[@]}"
else
  "${formatter}" --dry-run -Werror "${files[@]}" ||
    { echo "to format in place: ./tests/format.sh --fix" && exit 1; }
fi
echo "${#files[@]} files are in order"
