# shellcheck shell=bash
# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#
# Set-up shared by launch/demo.sh and tests/run.sh: distribution packages, configure, build.
# Sourced, never run. Set before sourcing, all optional:
#   SLIM_INIT_SKIP_PACKAGES=1  neither look for nor install distribution packages
#   SLIM_INIT_BUILD_DIR=DIR    build folder (default: build/ in the repository)
#   SLIM_INIT_JOBS=N           parallel compile jobs (default: one per processor)
#   CI=true                    compiler warnings are errors, as in the CMake preset "ci"

SLIM_INIT_ROOT="$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")/.." && pwd -P)"
SLIM_INIT_BUILD_DIR="${SLIM_INIT_BUILD_DIR:-${SLIM_INIT_ROOT}/build}"
SLIM_INIT_JOBS="${SLIM_INIT_JOBS:-$(nproc)}"

# What a bare system needs, one line a package; the names are the same on Debian 11, Debian 12 and
# Ubuntu 20.04. "both" is needed by the demo and the tests, "tests" only by the tests; "extra" comes
# with the tests where the system's sources have it, and everything works without.
# OpenCV: the module packages are enough (slim_init/cmake/FindSlimInitOpenCV.cmake), the far larger
# libopencv-dev is not needed. The column of Ubuntu 20.04 is as published for it, not tried yet.
# package | needed by | Debian 12 | Ubuntu 20.04 | what it is for
SLIM_INIT_PACKAGES='
g++                 | both  | 12.2   | 9.3    | C++17 compiler
make                | both  | 4.3    | 4.2    | build tool that CMake drives
cmake               | both  | 3.25.1 | 3.16.3 | build description, CTest
git                 | both  | 2.39   | 2.25   | source control
libeigen3-dev       | both  | 3.4.0  | 3.3.7  | linear algebra
libopencv-core-dev  | both  | 4.6.0  | 4.2.0  | configuration files, images (line front end only)
libopencv-imgproc-dev | both | 4.6.0 | 4.2.0  | image processing (line front end only)
libopencv-calib3d-dev | both | 4.6.0 | 4.2.0  | lens undistortion (line front end only)
libopencv-imgcodecs-dev | both | 4.6.0 | 4.2.0 | images of recordings (line front end only)
libopencv-video-dev | both  | 4.6.0  | 4.2.0  | point tracking (line front end only)
libopencv-contrib-dev | both | 4.6.0 | 4.2.0 | line detection, module ximgproc (line front end only)
nlohmann-json3-dev  | both  | 3.11.2 | 3.7.3  | summary.json of the evaluation
libboost-program-options-dev | both | 1.74.0 | 1.71.0 | command line of the program slim_init
povray              | both  | 3.7.0  | 3.7.0  | rendered sequences (slim_init simulate)
libceres-dev        | tests | 2.1.0  | 1.14.0 | methods vins, openvins; ab --downstream; reference of tests
libgtest-dev        | tests | 1.12.1 | 1.10.0 | test framework
libgmock-dev        | tests | 1.12.1 | 1.10.0 | asked for by the package file of GoogleTest 1.10
librosbag-storage-dev | extra | 1.15.15 | 1.14.3 | bags of ROS 1: slim_init ab --bag
libsensor-msgs-dev  | extra | 1.13.1 | 1.12.7 | the messages in those bags
libroscpp-dev       | extra | 1.15.15 | 1.14.3 | the nodes of ROS 1
ros-message-generation | extra | 0.4.1 | 0.4.0  | the messages of the nodes
libnav-msgs-dev     | extra | 1.13.1 | 1.12.7  | the nodes of ROS 1
libdiagnostic-msgs-dev | extra | 1.13.1 | 1.12.7 | the nodes of ROS 1
libvisualization-msgs-dev | extra | 1.13.1 | 1.12.7 | the nodes of ROS 1
libtf2-msgs-dev     | extra | 0.7.6  | 0.6.5   | the nodes of ROS 1
libstd-srvs-dev     | extra | 1.11.3 | 1.11.2  | the nodes of ROS 1
python3-rostest     | extra | 1.15.15 | 1.14.3 | tests of the nodes under a roscore
python3-rosbag      | extra | 1.15.15 | 1.14.3 | rosbag play, in the tests of the nodes
catkin              | extra | 0.8.10 | 0.7.20  | test of the catkin package
python3-matplotlib  | extra | 3.6.3  | 3.1.2  | pictures in the report of slim_init ab
libbenchmark-dev    | tests | 1.7.1  | 1.5.0  | slim_init_bench
'

slim_init_say() { printf '\n==> %s\n' "$*"; }
slim_init_die() {
  printf '\nerror: %s\n' "$*" >&2
  exit 1
}

# Prints the names in the table above that "$1" needs (both|tests|extra).
slim_init_packages() {
  awk -F'|' -v group="$1" 'NF == 5 { gsub(/ /, "", $1); gsub(/ /, "", $2);
    if ($2 == group || (group == "tests" && $2 == "both")) print $1 }' <<<"${SLIM_INIT_PACKAGES}"
}
slim_init_purpose() {
  awk -F'|' -v name="$1" 'NF == 5 { gsub(/ /, "", $1); sub(/^ */, "", $5);
    if ($1 == name) print $5 }' <<<"${SLIM_INIT_PACKAGES}"
}

slim_init_installed() {
  [[ "$(dpkg-query -W -f='${db:Status-Status}' "$1" 2>/dev/null)" == installed ]]
}
slim_init_available() {
  # Not piped into grep -q: it stops reading early, and under pipefail that is a failure of apt-cache.
  local policy
  policy="$(LC_ALL=C apt-cache policy "$1" 2>/dev/null)" || return 1
  [[ "${policy}" == *"Candidate: "[!\(]* ]]
}

# apt-get as root, without questions and without reading our standard input. Its output is for a
# person who waits; in a log it appears only when it failed.
slim_init_apt_get() {
  local -a as_root=()
  if [[ ${EUID} -ne 0 ]]; then
    command -v sudo >/dev/null ||
      slim_init_die "installing packages needs root: run as root, install sudo, or install the" \
        "packages named above by hand"
    as_root=(sudo)
  fi
  local -a command=("${as_root[@]}" env DEBIAN_FRONTEND=noninteractive
    apt-get -y -qq -o Dpkg::Use-Pty=0 "$@")
  if [[ -t 1 ]]; then
    "${command[@]}" </dev/null
    return
  fi
  local output status=0
  output="$("${command[@]}" </dev/null 2>&1)" || status=$?
  [[ ${status} -eq 0 ]] || printf '%s\n' "${output}" >&2
  return "${status}"
}

# Installs what is missing for "$1" (both|tests). Touches neither network nor root when nothing is.
slim_init_install_packages() {
  if [[ -n "${SLIM_INIT_SKIP_PACKAGES:-}" ]]; then
    slim_init_say "Packages: not checked (SLIM_INIT_SKIP_PACKAGES is set)"
    return
  fi
  if ! command -v apt-get >/dev/null || ! command -v dpkg-query >/dev/null; then
    slim_init_say "Packages: this is not a Debian or Ubuntu system, going on with what is there"
    return
  fi

  local -a wanted extra=() missing=() missing_extra=() unavailable=()
  local package
  mapfile -t wanted < <(slim_init_packages "$1")
  for package in "${wanted[@]}"; do
    slim_init_installed "${package}" || missing+=("${package}")
  done
  if [[ "$1" == tests ]]; then
    mapfile -t extra < <(slim_init_packages extra)
    for package in "${extra[@]}"; do
      slim_init_installed "${package}" || missing_extra+=("${package}")
    done
  fi
  if [[ ${#missing[@]} -eq 0 && ${#missing_extra[@]} -eq 0 ]]; then
    slim_init_say "Packages: all $((${#wanted[@]} + ${#extra[@]})) are installed"
    return
  fi

  slim_init_say "Packages: ${#missing[@]} of ${#wanted[@]} are missing: ${missing[*]:-none}"
  local updated=0
  for package in "${missing[@]}"; do
    if ! slim_init_available "${package}"; then
      echo "    reading the package lists (apt-get update)"
      # One broken source among several must not stop us; what counts is checked below.
      slim_init_apt_get update || echo "    apt-get update reported an error" >&2
      updated=1
      break
    fi
  done
  for package in "${missing[@]}"; do
    slim_init_available "${package}" || unavailable+=("${package}")
  done
  # What only adds something must not stop us.
  for package in "${missing_extra[@]}"; do
    if slim_init_available "${package}"; then
      missing+=("${package}")
    else
      echo "    going on without ${package}, which the package sources do not have; it is for:" \
        "$(slim_init_purpose "${package}")"
    fi
  done
  if [[ ${#unavailable[@]} -gt 0 ]]; then
    printf '\n' >&2
    for package in "${unavailable[@]}"; do
      printf 'error: package %s cannot be had from the package sources of this system; it is for: %s\n' \
        "${package}" "$(slim_init_purpose "${package}")" >&2
    done
    slim_init_die "check the network and /etc/apt/sources.list (Ubuntu needs \"universe\")," \
      "or install by hand and set SLIM_INIT_SKIP_PACKAGES=1"
  fi

  [[ ${#missing[@]} -gt 0 ]] || return 0
  echo "    installing ${missing[*]}"
  if ! slim_init_apt_get install --no-install-recommends "${missing[@]}"; then
    # Old lists name files that the archive no longer has.
    [[ ${updated} -eq 0 ]] ||
      slim_init_die "apt-get could not install: ${missing[*]} (its messages are above)"
    echo "    trying again with fresh package lists (apt-get update)"
    slim_init_apt_get update || echo "    apt-get update reported an error" >&2
    slim_init_apt_get install --no-install-recommends "${missing[@]}" ||
      slim_init_die "apt-get could not install: ${missing[*]} (its messages are above)"
  fi
}

# slim_init_build [cmake option]...: configures Release and builds everything.
slim_init_build() {
  local -a options=(-DCMAKE_BUILD_TYPE=Release "$@")
  # Only said where it is meant, so that a user's own choice in the build folder stays.
  if [[ "${CI:-}" == true || "${CI:-}" == 1 ]]; then
    options+=(-DSLIM_INIT_WERROR=ON)
  fi
  slim_init_say "Configuring ${SLIM_INIT_BUILD_DIR} (Release)"
  cmake -S "${SLIM_INIT_ROOT}" -B "${SLIM_INIT_BUILD_DIR}" "${options[@]}" ||
    slim_init_die "configuring failed; CMake's message above names what is missing"
  slim_init_say "Building with ${SLIM_INIT_JOBS} job(s)"
  cmake --build "${SLIM_INIT_BUILD_DIR}" --parallel "${SLIM_INIT_JOBS}" ||
    slim_init_die "the build failed; the compiler's message is above"
}
