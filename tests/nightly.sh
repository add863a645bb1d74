#!/usr/bin/env bash
# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#
# What takes a night, beside .ci/run: the whole suite under sanitizers, every fuzz target, builds
# compared with each other, a day of simulated time.
#   ./tests/nightly.sh                                all of it
#   ./tests/nightly.sh asan|tsan|fuzz|compare|soak    one part
# FUZZ_SECONDS (600) is the time of each fuzz target, SOAK_HOURS (24) the simulated time,
# SLIM_INIT_JOBS the number of processes.
# Packages are those of tests/run.sh, and clang for fuzz and compare.
set -euo pipefail
cd "$(dirname -- "${BASH_SOURCE[0]}")/.."
# shellcheck source=launch/setup.sh
source launch/setup.sh

case "${1:-all}" in
  all | asan | tsan | fuzz | compare | soak) part="${1:-all}" ;;
  *)
    sed -n '4,11s/^# *//p' "${BASH_SOURCE[0]}"
    exit 2
    ;;
esac
jobs="${SLIM_INIT_JOBS:-2}"

# What a sanitizer finds ends the program; rosbag and OpenCV keep some memory to their end.
export ASAN_OPTIONS=detect_leaks=0:abort_on_error=1 UBSAN_OPTIONS=print_stacktrace=1
export TSAN_OPTIONS=halt_on_error=1:second_deadlock_stack=1

suite() {
  slim_init_say "$1: the whole suite"
  cmake --preset "$1"
  cmake --build --preset "$1" --parallel "${jobs}"
  # Sanitizers make a test three to fifteen times slower.
  ctest --preset "$1" --parallel "${jobs}" --timeout 3600
}

fuzz() {
  command -v clang++ >/dev/null || slim_init_die "no clang++" "apt-get install clang"
  cmake --preset fuzz
  cmake --build --preset fuzz --parallel "${jobs}"
  local target name
  for target in build-fuzz/tests/fuzz/fuzz_*; do
    name="$(basename "${target}")"
    [[ -x "${target}" && ! -d "${target}" && "${name}" != *_test ]] || continue
    mkdir -p "build-fuzz/corpus/${name}"
    slim_init_say "${name}: ${FUZZ_SECONDS:-600} s"
    "./${target}" -max_total_time="${FUZZ_SECONDS:-600}" -timeout=60 -rss_limit_mb=4096 \
      -artifact_prefix="build-fuzz/${name}." -print_final_stats=1 \
      "build-fuzz/corpus/${name}" $(seeds "${name#fuzz_}")
  done
}

# Folders of seeds of a target.
seeds() {
  if [[ "$1" == config ]]; then
    echo config
  elif [[ -d "tests/fuzz/seeds/$1" ]]; then
    echo "tests/fuzz/seeds/$1"
  fi
}

soak() {
  slim_init_configure
  slim_init_build --target slim_init_bench
  slim_init_say "${SOAK_HOURS:-24} hours of simulated time"
  "${SLIM_INIT_BUILD_DIR}/bin/slim_init_bench" soak --hours "${SOAK_HOURS:-24}"
}

[[ "${part}" == all || "${part}" == asan ]] && suite debug-asan-ubsan
[[ "${part}" == all || "${part}" == tsan ]] && suite tsan
[[ "${part}" == all || "${part}" == fuzz ]] && fuzz
[[ "${part}" == all || "${part}" == compare ]] && ./tests/compare_builds.sh
[[ "${part}" == all || "${part}" == soak ]] && soak
exit 0
