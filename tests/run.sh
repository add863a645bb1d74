#!/usr/bin/env bash
# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#
# Installs what is missing, builds and runs all tests.
#   ./tests/run.sh [ctest option]...      for example: ./tests/run.sh -R camera
#   ./tests/run.sh -L unit                without the slow tests
# The variables that change it are listed in launch/setup.sh.
set -euo pipefail
# shellcheck source=launch/setup.sh
source "$(dirname -- "${BASH_SOURCE[0]}")/../launch/setup.sh"

case "${1:-}" in
  -h | --help)
    sed -n '4,7s/^# *//p' "${BASH_SOURCE[0]}"
    exit 0
    ;;
esac

run_tests() {
  slim_init_say "Running the tests"
  # --no-tests=error: a filter that matches nothing, or a build without tests, is not a success.
  ctest --output-on-failure --no-tests=error --parallel "${SLIM_INIT_JOBS}" \
    --output-log Testing/Temporary/run.log "$@" </dev/null ||
    slim_init_die "tests failed; the list is above, details are in" \
      "${SLIM_INIT_BUILD_DIR}/Testing/Temporary/LastTest.log"
}

# Tests, and cases of GoogleTest with their reason, that could not run on this machine.
skipped_tests() {
  sed -nE 's/^ *[0-9]+\/[0-9]+ Test +#[0-9]+: ([^ ]+) .*\*\*\*(Skipped|Not Run).*/    \1/p' \
    Testing/Temporary/run.log
  awk '/^[0-9]+\/[0-9]+ Test: / { test = $3 }
    /^Command: / { output = 0 }
    /^Output:$/ { output = 1 }
    /^\[ RUN      \]/ { reason = "no reason given" }
    /: Skipped$/ { getline reason }
    output && /^\[  SKIPPED \] .*\(/ { printf "    %s: %s (%s)\n", test, $4, reason }' \
    Testing/Temporary/LastTest.log
}

# shellcheck disable=SC2119  # no arguments: all targets
slim_init_set_up
cd "${SLIM_INIT_BUILD_DIR}"
slim_init_timed tests run_tests "$@"
slim_init_summary
skipped="$(skipped_tests)"
if [[ -n "${skipped}" ]]; then
  slim_init_say "Tests that were skipped on this machine:"
  printf '%s\n' "${skipped}"
fi
