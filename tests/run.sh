#!/usr/bin/env bash
# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#
# Installs what is missing, builds and runs all tests.
#   ./tests/run.sh [ctest option]...      for example: ./tests/run.sh -R camera
# The variables that change it are listed in launch/setup.sh.
set -euo pipefail
# shellcheck source=launch/setup.sh
source "$(dirname -- "${BASH_SOURCE[0]}")/../launch/setup.sh"

case "${1:-}" in
  -h | --help)
    sed -n '4,6s/^# *//p' "${BASH_SOURCE[0]}"
    exit 0
    ;;
esac

slim_init_install_packages tests
slim_init_build -DSLIM_INIT_BUILD_TESTS=ON
slim_init_say "Running the tests"
cd "${SLIM_INIT_BUILD_DIR}"
# --no-tests=error: a filter that matches nothing, or a build without tests, is not a success.
ctest --output-on-failure --no-tests=error --parallel "${SLIM_INIT_JOBS}" "$@" </dev/null ||
  slim_init_die "tests failed; the list is above, details are in" \
    "${SLIM_INIT_BUILD_DIR}/Testing/Temporary/LastTest.log"
