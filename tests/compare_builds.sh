#!/usr/bin/env bash
# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#
# Whether builds give the same answers: GCC in Release against GCC in Debug and Clang in Release.
#   ./tests/compare_builds.sh [FOLDER]...   recordings without pixels, besides the built-in motions
# Solves the same windows by every method of ours with each and compares scale, standard deviation,
# biases, gravity and velocity (tests/compare_answers.py). Builds are in build-compare; BOUND (1e-9) is the
# largest relative difference, SLIM_INIT_JOBS the number of processes.
# Packages are those of tests/run.sh, and clang.
set -euo pipefail
cd "$(dirname -- "${BASH_SOURCE[0]}")/.."
# shellcheck source=launch/setup.sh
source launch/setup.sh

if [[ "${1:-}" == -* ]]; then
  sed -n '4,9s/^# *//p' "${BASH_SOURCE[0]}"
  exit 2
fi
command -v clang++ >/dev/null || slim_init_die "no clang++" "apt-get install clang"
# Those that need neither Ceres nor OpenCV, which come compiled.
methods=slim,slim-paper,drt-l,drt-t,drt-vi-ba
sources=()
for motion in circle figure-eight corridor-walk hover; do
  sources+=("--builtin ${motion}")
done
for folder in "$@"; do
  sources+=("--recorded $(realpath -- "${folder}")")
done

# answers <name> <CMake option>...: builds and solves.
answers() {
  local build="build-compare/$1" name="$1" source
  shift
  slim_init_say "${name}"
  cmake -S . -B "${build}" -DSLIM_INIT_BUILD_ROS=OFF \
    -DSLIM_INIT_WERROR=ON "$@" >/dev/null
  cmake --build "${build}" --parallel "${SLIM_INIT_JOBS}" --target slim_init_bench
  rm -f "build-compare/${name}.csv"
  for source in "${sources[@]}"; do
    # shellcheck disable=SC2086  # an option and its value
    "${build}/bin/slim_init_bench" count --methods "${methods}" ${source} --drift 0.04 \
      --answers "build-compare/${name}.csv"
  done
}

answers gcc-release -DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_COMPILER=g++
# Each source includes what it uses, the precompiled header apart.
answers gcc-debug -DCMAKE_BUILD_TYPE=Debug -DCMAKE_CXX_COMPILER=g++ \
  -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON
answers clang-release -DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_COMPILER=clang++
failed=0
for other in gcc-debug clang-release; do
  slim_init_say "gcc-release against ${other}"
  python3 tests/compare_answers.py --bound "${BOUND:-1e-9}" build-compare/gcc-release.csv \
    "build-compare/${other}.csv" || failed=1
done
exit "${failed}"
