#!/usr/bin/env bash
# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#
# Core and front end for 64-bit ARM, built and run on this machine: a folder of arm64 packages, the
# cross compiler of Debian, the tests under QEMU's user mode, answers compared with a build for this
# machine, and the instructions of a solve and of an image.
#   ./tests/cross_aarch64.sh [--dir DIR] [--tests REGEX] [--bench DIR] [--asl DIR] [--no-tests] [--no-counts]
#     --dir DIR      packages and build (default: build-aarch64 in the repository); 1.3 GB
#     --tests REGEX  tests to run, as of ctest -R (default: those of core and front end)
#     --bench DIR    build for this machine to compare with (default: build)
#     --asl DIR      images for the front end, an ASL folder; without it only solves are counted
#     --no-tests     do not build and run the tests
#     --no-counts    do not compare answers nor count instructions
# Packages are downloaded by an apt of its own in DIR and unpacked there: nothing of them is installed
# on this machine, which needs g++-aarch64-linux-gnu, gcc, cmake, python3, qemu-user and, to count its
# own instructions, valgrind. DIR is used again where it is there; remove it for newer packages.
# SLIM_INIT_JOBS is the number of compilers (default: one per processor); BOUND the largest relative
# difference of an answer (default: 1e-4).
set -euo pipefail

die() {
  printf 'error: %s\n' "$*" >&2
  exit 1
}
say() { printf '\n==> %s\n' "$*"; }

root="$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")/.." && pwd -P)"
here="${root}/tests/cross_aarch64"
dir="${root}/build-aarch64"
bench="${root}/build"
asl=
tests=
with_tests=1
with_counts=1
while [[ $# -gt 0 ]]; do
  case "$1" in
    --dir | --tests | --bench | --asl)
      [[ $# -ge 2 ]] || die "$1 needs a value"
      printf -v "${1#--}" '%s' "$2"
      shift
      ;;
    --no-tests) with_tests= ;;
    --no-counts) with_counts= ;;
    -h | --help)
      sed -n '4,19s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"
      exit 0
      ;;
    *) die "unknown option $1 (known: --dir, --tests, --bench, --asl, --no-tests, --no-counts, --help)" ;;
  esac
  shift
done
jobs="${SLIM_INIT_JOBS:-$(nproc)}"
for program in aarch64-linux-gnu-g++ qemu-aarch64 apt-get dpkg-deb cmake ctest gcc python3; do
  command -v "${program}" >/dev/null ||
    die "${program} is missing: apt-get install g++-aarch64-linux-gnu qemu-user cmake gcc python3"
done
mkdir -p "${dir}"
dir="$(cd -- "${dir}" && pwd -P)"
sysroot="${dir}/sysroot"
build="${dir}/build"

# What is built against, and what of it (tests of the core's modules and of the front end).
packages=(libc6-dev libstdc++-12-dev libeigen3-dev nlohmann-json3-dev libgtest-dev
  libboost-program-options-dev libceres-dev libopencv-core-dev libopencv-imgproc-dev
  libopencv-calib3d-dev libopencv-imgcodecs-dev libopencv-video-dev)
folders=(config data derivation estimation feature_tracker_lines geometry imu lines methods rotation
  scale shape verdict)

# apt_here <argument>...: apt of a machine of that architecture on which nothing is installed. The
# sources are those of this machine.
apt_here() {
  apt-get -qq -o APT::Architecture=arm64 -o APT::Architectures=arm64 -o Dir::State="${dir}/apt/state" \
    -o Dir::State::status="${dir}/apt/status" -o Dir::Cache="${dir}/apt/cache" \
    -o APT::Install-Recommends=0 -o Debug::NoLocking=1 -o APT::Sandbox::User="$(id -un)" "$@"
}

make_sysroot() {
  mkdir -p "${dir}"/apt/state/lists/partial "${dir}"/apt/cache/archives/partial
  : >"${dir}/apt/status"
  apt_here update
  apt_here install --download-only -y "${packages[@]}" >"${dir}/packages.log" ||
    die "the arm64 packages could not be downloaded: $(tail -n 3 "${dir}/packages.log")"
  rm -rf "${sysroot}.new"
  mkdir "${sysroot}.new"
  local file name lib="${sysroot}.new/usr/lib/aarch64-linux-gnu"
  for file in "${dir}"/apt/cache/archives/*.deb; do
    dpkg-deb -x "${file}" "${sysroot}.new"
  done
  # What the packages do when they are installed: the choice between several BLAS.
  for name in blas lapack; do
    ln -sf "${name}/lib${name}.so.3" "${lib}/lib${name}.so.3"
    ln -sf "lib${name}.so.3" "${lib}/lib${name}.so"
  done
  # The package file of Ceres has absolute paths.
  sed -i "s#;/usr/lib/#;${sysroot}/usr/lib/#g" "${lib}/cmake/Ceres/CeresTargets.cmake"
  mv "${sysroot}.new" "${sysroot}"
  rm -rf "${dir}/apt"
}
if [[ -d "${sysroot}" ]]; then
  say "arm64 packages: those in ${sysroot}"
else
  say "arm64 packages in ${sysroot}"
  make_sysroot
  echo "    $(du -sh "${sysroot}" | cut -f1)"
fi

say "Build in ${build}"
# This compiler alone takes a loop within Eigen's destructor of an array for a use after free.
cmake -S "${root}" -B "${build}" -DCMAKE_TOOLCHAIN_FILE="${here}/toolchain.cmake" \
  -DSLIM_INIT_SYSROOT="${sysroot}" -DCMAKE_BUILD_TYPE=Release -DSLIM_INIT_BUILD_TESTS=ON \
  -DSLIM_INIT_BUILD_ROS=OFF -DSLIM_INIT_WERROR=ON \
  -DCMAKE_CXX_FLAGS=-Wno-error=use-after-free >"${dir}/configure.log" ||
  die "configuring failed: $(tail -n 20 "${dir}/configure.log")"
targets=()
if [[ -n "${with_tests}" ]]; then
  lists=("${folders[@]/%//CMakeLists.txt}")
  mapfile -t names < <("${root}/tests/declared_tests.sh" "${lists[@]/#/${root}/tests/}")
  [[ ${#names[@]} -gt 0 ]] || die "no test was found in ${root}/tests"
  [[ -n "${tests}" ]] || tests="^($(IFS='|' && echo "${names[*]}"))\$"
  for name in "${names[@]}"; do
    if [[ "${name}" =~ ${tests} ]]; then targets+=("${name}"); fi
  done
  [[ ${#targets[@]} -gt 0 ]] || die "no test of core and front end is called like \"${tests}\""
fi
if [[ -n "${with_counts}" ]]; then
  targets+=(slim_init_bench)
fi
[[ ${#targets[@]} -gt 0 ]] || die "--no-tests and --no-counts together leave nothing to do"
cmake --build "${build}" --parallel "${jobs}" --target "${targets[@]}" >"${dir}/build.log" ||
  die "the build failed (${dir}/build.log): $(grep -m 3 -E 'error|FAILED' "${dir}/build.log")"

failed=0
if [[ -n "${with_tests}" ]]; then
  say "Tests under QEMU"
  # Emulated instructions take ten times their time and more.
  ctest --test-dir "${build}" --output-on-failure -R "${tests}" --timeout 3600 || failed=1
fi

# of_aarch64 <function> <program>...: runs it and prints "CALLS INSTRUCTIONS" of the function.
of_aarch64() {
  local function="$1"
  shift
  qemu-aarch64 -L "${sysroot}" -d plugin -D "${dir}/count.log" \
    -plugin "${dir}/libcount.so,function=${function}" "$@" >"${dir}/count.out" 2>&1 ||
    die "$* failed: $(tail -n 3 "${dir}/count.out")"
  sed -n 's/.*: \([0-9]*\) calls, \([0-9]*\) instructions,.*/\1 \2/p' "${dir}/count.log"
}
# of_this_machine <function> <program>...: instructions of the function.
of_this_machine() {
  local function="$1"
  shift
  valgrind --tool=callgrind --demangle=no --callgrind-out-file=/dev/null --collect-atstart=no \
    "--toggle-collect=*${function}*" "$@" >"${dir}/count.log" 2>&1 ||
    die "$* failed under valgrind: $(tail -n 3 "${dir}/count.log")"
  sed -n 's/.*Collected : \([0-9]*\).*/\1/p' "${dir}/count.log"
}
# row <what> <divided by> <function> <program> <argument>...: of both machines, in millions.
row() {
  local what="$1" by="$2" function="$3" program="$4" there here=
  shift 4
  there="$(of_aarch64 "${function}" "${build}/bin/${program}" "$@")"
  [[ "${there% *}" -gt 0 ]] || die "${program} never calls ${function}"
  if [[ -x "${bench}/bin/${program}" ]] && command -v valgrind >/dev/null; then
    here="$(of_this_machine "${function}" "${bench}/bin/${program}" "$@")"
  fi
  awk -v what="${what}" -v there="${there#* }" -v calls="${there% *}" -v here="${here}" -v by="${by}" '
    BEGIN { if (by == 0) by = calls
            printf "%-28s %10.2f", what, there / by / 1e6
            if (here != "") printf " %10.2f %8.2f", here / by / 1e6, there / here
            printf "\n" }'
}

if [[ -n "${with_counts}" ]]; then
  methods=slim,slim-paper,drt-l,drt-t,drt-vi-ba
  windows=(--duration 12 --windows 8)
  if [[ -x "${bench}/bin/slim_init_bench" ]]; then
    say "Answers, against those of ${bench}"
    rm -f "${dir}"/answers.*.csv
    "${bench}/bin/slim_init_bench" count --methods "${methods}" --drift 0.04 "${windows[@]}" \
      --answers "${dir}/answers.here.csv"
    qemu-aarch64 -L "${sysroot}" "${build}/bin/slim_init_bench" count --methods "${methods}" --drift 0.04 \
      "${windows[@]}" --answers "${dir}/answers.aarch64.csv"
    # ARM multiplies and adds in one rounding, so that the answers are not equal; where `slim` ends its
    # iterations a rounding becomes 2e-5 of an accelerometer bias (docs/reliability.md).
    python3 "${root}/tests/compare_answers.py" --bound "${BOUND:-1e-4}" "${dir}/answers.here.csv" \
      "${dir}/answers.aarch64.csv" || failed=1
  else
    echo "    note: no ${bench}/bin/slim_init_bench, answers are not compared"
  fi
  say "Instructions"
  gcc -shared -fPIC -O2 -Wall -Wextra -Werror -o "${dir}/libcount.so" "${here}/count_instructions.c"
  printf '%-28s %10s %10s %8s\n' million "aarch64" "$(uname -m)" ratio
  for method in slim drt-l; do
    row "a solve of ${method}" 8 countedSolves slim_init_bench count --methods "${method}" "${windows[@]}"
  done
  if [[ -n "${asl}" ]]; then
    row "an image of the front end" 0 ImageFrontEnd8addImage slim_init ab --asl "${asl}" --methods drt-l \
      --limit 1 --report off --quiet --out "${dir}/ab"
  fi
fi
exit "${failed}"
