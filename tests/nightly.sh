#!/usr/bin/env bash
# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#
# What takes a night, beside .ci/run: the whole suite under sanitizers, every fuzz target, builds
# compared with each other, a day of simulated time, the nodes for an hour.
#   ./tests/nightly.sh                                        all of it
#   ./tests/nightly.sh asan|tsan|fuzz|compare|soak|nodes      one part
#   ./tests/nightly.sh quick                                  what .ci/run has of it
# FUZZ_SECONDS (600) is the time of each fuzz target, SOAK_HOURS (24) the simulated time,
# NODE_ROUNDS (1000) the rounds of the nodes, SLIM_INIT_JOBS the number of processes.
# Packages are those of tests/run.sh, and clang with libclang-rt-dev for asan, tsan, fuzz and compare.
set -euo pipefail
cd "$(dirname -- "${BASH_SOURCE[0]}")/.."
# shellcheck source=launch/setup.sh
source launch/setup.sh

case "${1:-all}" in
  all | quick | asan | tsan | fuzz | compare | soak | nodes) part="${1:-all}" ;;
  *)
    sed -n '4,13s/^# *//p' "${BASH_SOURCE[0]}"
    exit 2
    ;;
esac
jobs="${SLIM_INIT_JOBS}"

# What a sanitizer finds ends the program; rosbag and OpenCV keep some memory to their end.
export ASAN_OPTIONS=detect_leaks=0:abort_on_error=1 UBSAN_OPTIONS=print_stacktrace=1
export TSAN_OPTIONS="halt_on_error=1:second_deadlock_stack=1:suppressions=${PWD}/tests/tsan.supp"

# configure <preset>: Ninja where there is one, for a new folder.
configure() {
  command -v clang++ >/dev/null || slim_init_die "no clang++" "apt-get install clang libclang-rt-dev"
  local -a generator=()
  ! command -v ninja >/dev/null || generator=(-G Ninja)
  cmake --preset "$1" "${generator[@]}"
}

# All tests but those that run nothing of this build. Sanitizers make a test three to fifteen times
# slower.
asan() {
  slim_init_say "Address and undefined-behaviour sanitizers: the whole suite"
  configure debug-asan-ubsan
  cmake --build --preset debug-asan-ubsan --parallel "${jobs}"
  ctest --preset debug-asan-ubsan --parallel "${jobs}" --timeout 3600 -LE scripts
}

# The tests that start threads: no other can have a race.
tsan() {
  slim_init_say "Thread sanitizer: the tests with more than one thread"
  configure tsan
  cmake --build --preset tsan --parallel "${jobs}" --target slim_init_threads_tests
  ctest --preset tsan --parallel "${jobs}" --timeout 3600 -L threads
}

fuzz() {
  configure debug-asan-ubsan
  local target name
  local -a targets
  mapfile -t targets < <(sed -nE 's/^slim_init_add_fuzz_target\(([a-z]+) .*/fuzz_\1/p' \
    tests/fuzz/CMakeLists.txt)
  cmake --build --preset debug-asan-ubsan --parallel "${jobs}" --target "${targets[@]}"
  # Most targets write their input to a file: in memory they run ten times as often as on a disk.
  [[ ! -w /dev/shm ]] || export TMPDIR=/dev/shm
  for name in "${targets[@]}"; do
    target="build-asan/tests/fuzz/${name}"
    mkdir -p "build-asan/corpus/${name}"
    slim_init_say "${name}: ${FUZZ_SECONDS:-600} s"
    # shellcheck disable=SC2046  # a folder or nothing
    "./${target}" -max_total_time="${FUZZ_SECONDS:-600}" -timeout=60 -rss_limit_mb=4096 \
      -malloc_limit_mb=1200 -len_control=0 \
      -artifact_prefix="build-asan/${name}." -print_final_stats=1 \
      "build-asan/corpus/${name}" $(seeds "${name#fuzz_}")
  done
}

# Folder of seeds of a target, where it has one; others make theirs.
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

nodes() {
  slim_init_configure
  slim_init_build
  slim_init_say "The nodes, ${NODE_ROUNDS:-1000} rounds"
  (cd "${SLIM_INIT_BUILD_DIR}" &&
    SLIM_INIT_NODE_ROUNDS="${NODE_ROUNDS:-1000}" ctest --verbose -R '^ros_(sequence|loop)$')
}

# The core, the adapter and the front end under Valgrind, with bytes of every kind, in the Release
# build that .ci/run has made: to build even these few with sanitizers takes longer than to run them.
quick() {
  if ! command -v valgrind >/dev/null; then
    slim_init_say "Memory and threads: skipped, there is no valgrind"
    return
  fi
  slim_init_say "Memory and threads under Valgrind"
  export tests="${SLIM_INIT_BUILD_DIR}/tests" seeds="${PWD}/tests/fuzz/seeds" config="${PWD}/config"
  local status=0
  # One command a line, those that take longest first. Memcheck, but where DRD is named.
  # shellcheck disable=SC2016  # the shell that xargs starts fills in the variables
  xargs -d '\n' -P "${jobs}" -I{} bash -c 'output="$(valgrind -q --error-exitcode=9 {} 2>&1 </dev/null)" &&
    [[ "${output}" != *"Running 0 tests"* ]] || {
      printf "failed: %s\n%s\n" '"'{}'"' "$(tail -n 60 <<<"${output}")"
      exit 1
    }
    echo "    no findings: "'"'{}'" <<'END' || status=$?
"$tests"/fuzz/fuzz_adapter_test "$seeds"/adapter 1
"$tests"/fuzz/fuzz_window_test "$seeds"/window 20
"$tests"/fuzz/fuzz_config_test "$config" 1
"$tests"/fuzz/fuzz_images_test "$seeds"/images 10
"$tests"/fuzz/fuzz_recording_test "$seeds"/recording 20
"$tests"/fuzz/fuzz_messages_test "$seeds"/messages 200
"$tests"/data/init_window_test
"$tests"/data/keyframe_window_test
"$tests"/data/stream_check_test
"$tests"/geometry/dense_test
"$tests"/vins_adapter/feature_message_test
--tool=drd --suppressions=tests/drd.supp "$tests"/vins_adapter/host_adapter_test --gtest_filter=*AnotherThread
END
  [[ ${status} -eq 0 ]] || slim_init_die "Valgrind found the above, or a test failed under it"
}

[[ "${part}" == quick ]] && quick
[[ "${part}" == all || "${part}" == asan ]] && asan
[[ "${part}" == all || "${part}" == tsan ]] && tsan
[[ "${part}" == all || "${part}" == fuzz ]] && fuzz
[[ "${part}" == all || "${part}" == compare ]] && ./tests/compare_builds.sh
[[ "${part}" == all || "${part}" == soak ]] && soak
[[ "${part}" == all || "${part}" == nodes ]] && nodes
exit 0
