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

# What a bare system gets, one line a package; the names are the same on Debian 11, Debian 12 and
# Ubuntu 20.04. Those "for tests" are for tests and ROS nodes; the demo, which builds the program
# alone, does without. Without a "needed" package nothing is built. An "optional" one is installed if
# the system's sources have it, and so is a "ros" one unless ROS itself is there (/opt/ros), with
# whose packages they must not be mixed; the last lines of the run name what was left out.
# OpenCV: the module packages are enough (slim_init/cmake/FindSlimInitOpenCV.cmake), the far larger
# libopencv-dev is not needed. The column of Ubuntu 20.04 is as published for it, not tried yet.
# package | group | Debian 12 | Ubuntu 20.04 | what it is for
SLIM_INIT_PACKAGES='
g++                 | needed | 12.2   | 9.3    | C++17 compiler
make                | needed | 4.3    | 4.2    | build tool that CMake drives
cmake               | needed | 3.25.1 | 3.16.3 | build description, CTest
git                 | needed | 2.39   | 2.25   | source control
libeigen3-dev       | needed | 3.4.0  | 3.3.7  | linear algebra
libopencv-core-dev  | needed | 4.6.0  | 4.2.0  | configuration files, images (line front end only)
libopencv-imgproc-dev | needed | 4.6.0 | 4.2.0 | image processing (line front end only)
libopencv-calib3d-dev | needed | 4.6.0 | 4.2.0 | lens undistortion (line front end only)
libopencv-imgcodecs-dev | needed | 4.6.0 | 4.2.0 | images of recordings (line front end only)
libopencv-video-dev | needed | 4.6.0  | 4.2.0  | point tracking (line front end only)
nlohmann-json3-dev  | needed | 3.11.2 | 3.7.3  | summary.json of the evaluation
libboost-program-options-dev | needed | 1.74.0 | 1.71.0 | command line of the program slim_init
libceres-dev        | needed | 2.1.0  | 1.14.0 | methods vins, openvins; ab --downstream; tests
povray              | needed | 3.7.0  | 3.7.0  | rendered sequences (slim_init simulate)
libgtest-dev        | needed for tests | 1.12.1 | 1.10.0 | test framework
libgmock-dev        | needed for tests | 1.12.1 | 1.10.0 | asked for by the package file of GoogleTest 1.10
python3-pandas      | needed | 1.5.3  | 0.25.3 | report of slim_init ab
python3-jinja2      | needed | 3.1.2  | 2.10.1 | report of slim_init ab
python3-matplotlib  | needed | 3.6.3  | 3.1.2  | pictures in the report of slim_init ab
snakemake           | optional for tests | 7.21.0 | 5.10.0 | suites of runs (slim_init/evaluation/suite)
ninja-build         | optional | 1.11.1 | 1.10.0 | faster builds (a new build folder uses it)
ccache              | optional | 4.7.5  | 3.7.7  | faster builds the second time
dpkg-dev            | optional for tests | 1.21   | 1.19   | Debian packages (cpack) and their test
valgrind            | optional for tests | 3.19.0 | 3.15.0 | test of the number of instructions of a solve
doxygen             | optional for tests | 1.9.4  | 1.8.17 | reference of the public headers, test of their comments
clang-format        | optional for tests | 14.0   | 10.0   | test of the source format (needs version 14)
librosbag-storage-dev | ros | 1.15.15 | 1.14.3 | bags of ROS 1: slim_init ab --bag
libsensor-msgs-dev  | ros | 1.13.1 | 1.12.7 | the messages in those bags
libroscpp-dev       | ros for tests | 1.15.15 | 1.14.3 | the ROS 1 nodes
ros-message-generation | ros for tests | 0.4.1 | 0.4.0 | the messages of the ROS 1 nodes
libstd-msgs-dev     | ros for tests | 0.5.13 | 0.5.12 | the ROS 1 nodes
ros-std-msgs        | ros for tests | 0.5.13 | 0.5.12 | message definitions that ours contain
ros-geometry-msgs   | ros for tests | 1.13.1 | 1.12.7 | message definitions that ours contain
libgeometry-msgs-dev | ros for tests | 1.13.1 | 1.12.7 | the ROS 1 nodes
libnav-msgs-dev     | ros for tests | 1.13.1 | 1.12.7 | the ROS 1 nodes
libdiagnostic-msgs-dev | ros for tests | 1.13.1 | 1.12.7 | the ROS 1 nodes
libvisualization-msgs-dev | ros for tests | 1.13.1 | 1.12.7 | the ROS 1 nodes
libtf2-msgs-dev     | ros for tests | 0.7.6  | 0.6.5  | the ROS 1 nodes
libstd-srvs-dev     | ros for tests | 1.11.3 | 1.11.2 | the ROS 1 nodes
python3-rostest     | ros for tests | 1.15.15 | 1.14.3 | tests of the ROS 1 nodes under a roscore
python3-rosbag      | ros for tests | 1.15.15 | 1.14.3 | rosbag play, in the tests of the ROS 1 nodes
catkin              | ros for tests | 0.8.10 | 0.7.20 | test of the catkin package
rosbash             | ros for tests | 1.15.8 | 1.14.7 | rosrun, in the test of the catkin package
python3-rosmsg      | ros for tests | 1.15.15 | 1.14.3 | rosmsg, in the test of the catkin package
'

# What the run says at its end (slim_init_summary): optional packages that could not be installed,
# notes, and how long each part took.
SLIM_INIT_MISSING=()
SLIM_INIT_NOTES=()
SLIM_INIT_TIMES=()

slim_init_say() { printf '\n==> %s\n' "$*"; }
slim_init_die() {
  printf '\nerror: %s\n' "$*" >&2
  exit 1
}

# Seconds as minutes and seconds.
slim_init_duration() { printf '%d:%02d min' "$(($1 / 60))" "$(($1 % 60))"; }

# slim_init_timed <name> <command>...: runs the command and notes its time for the summary.
slim_init_timed() {
  local name="$1" begin=${SECONDS}
  shift
  "$@"
  SLIM_INIT_TIMES+=("${name} $(slim_init_duration $((SECONDS - begin)))")
}

# Prints the names in the table above of group "$1" (needed|optional|ros), with those for tests unless
# the program alone is wanted.
slim_init_packages() {
  awk -F'|' -v group="$1" -v program="${SLIM_INIT_PROGRAM_ONLY:-}" 'NF == 5 { gsub(/ /, "", $1);
    split($2, words, " "); if (words[1] == group && !(program && words[2])) print $1
    }' <<<"${SLIM_INIT_PACKAGES}"
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
  local -a command=(env DEBIAN_FRONTEND=noninteractive
    apt-get -y -qq -o Dpkg::Use-Pty=0 -o DPkg::Lock::Timeout=300 "$@")
  [[ ${EUID} -eq 0 ]] || command=(sudo "${command[@]}")
  if [[ -t 1 ]]; then
    "${command[@]}" </dev/null
    return
  fi
  local output status=0
  output="$("${command[@]}" </dev/null 2>&1)" || status=$?
  [[ ${status} -eq 0 ]] || printf '%s\n' "${output}" >&2
  return "${status}"
}
# Removes nothing: apt-get refuses rather than give up a package of the user's that conflicts.
slim_init_install() {
  echo "    installing $*"
  slim_init_apt_get install --no-install-recommends --no-remove "$@"
}

# Installs "$@", or stops: names what the package sources do not have.
slim_init_install_needed() {
  local package unavailable=
  [[ $# -gt 0 ]] || return 0
  for package in "$@"; do
    slim_init_available "${package}" && continue
    printf '\nerror: package %s is not in the package sources of this system; it is for: %s' \
      "${package}" "$(slim_init_purpose "${package}")" >&2
    unavailable=1
  done
  [[ -z "${unavailable}" ]] ||
    slim_init_die "check the network and /etc/apt/sources.list (Ubuntu needs \"universe\")," \
      "or install by hand and set SLIM_INIT_SKIP_PACKAGES=1"
  slim_init_install "$@" ||
    slim_init_die "apt-get could not install: $* (its messages are above)"
}

# Installs those of "$@" that can be had; the others are noted for the summary.
slim_init_install_optional() {
  local -a available=()
  local package
  for package in "$@"; do
    if slim_init_available "${package}"; then
      available+=("${package}")
    else
      SLIM_INIT_MISSING+=("${package}")
    fi
  done
  if [[ ${#available[@]} -gt 0 ]] && ! slim_init_install "${available[@]}"; then
    echo "    going on without: apt-get could not install them (its messages are above)" >&2
    SLIM_INIT_MISSING+=("${available[@]}")
  fi
}

# Installs what is missing of the table. Touches neither network nor root when nothing is.
slim_init_install_packages() {
  if [[ -n "${SLIM_INIT_SKIP_PACKAGES:-}" ]]; then
    slim_init_say "Packages: not checked (SLIM_INIT_SKIP_PACKAGES is set)"
    return
  fi
  if ! command -v apt-get >/dev/null || ! command -v dpkg-query >/dev/null; then
    slim_init_say "Packages: this is not a Debian or Ubuntu system, going on with what is there"
    return
  fi

  local -a needed optional missing=() missing_optional=()
  local package
  mapfile -t needed < <(slim_init_packages needed)
  mapfile -t optional < <(slim_init_packages optional)
  if ! compgen -G '/opt/ros/*/setup.sh' >/dev/null; then
    mapfile -t -O "${#optional[@]}" optional < <(slim_init_packages ros)
  elif [[ -z "${ROS_DISTRO:-}" ]]; then
    SLIM_INIT_NOTES+=("ROS in /opt/ros was not used: source its setup.bash before this command")
  fi
  for package in "${needed[@]}"; do
    slim_init_installed "${package}" || missing+=("${package}")
  done
  for package in "${optional[@]}"; do
    slim_init_installed "${package}" || missing_optional+=("${package}")
  done
  if [[ ${#missing[@]} -eq 0 && ${#missing_optional[@]} -eq 0 ]]; then
    slim_init_say "Packages: all $((${#needed[@]} + ${#optional[@]})) are installed"
    return
  fi

  slim_init_say "Packages: missing are ${#missing[@]} of ${#needed[@]} needed and" \
    "${#missing_optional[@]} of ${#optional[@]} optional ones"
  # What no source has, as ROS on some systems, is not asked for again: that takes root and network.
  local available=""
  for package in "${missing_optional[@]}"; do
    if slim_init_available "${package}"; then available=yes; fi
  done
  if [[ ${#missing[@]} -eq 0 && -z "${available}" ]] &&
    compgen -G '/var/lib/apt/lists/*_Packages*' >/dev/null; then
    SLIM_INIT_MISSING+=("${missing_optional[@]}")
    return
  fi
  if [[ ${EUID} -ne 0 ]] && ! command -v sudo >/dev/null; then
    [[ ${#missing[@]} -eq 0 ]] ||
      slim_init_die "installing packages needs root: run as root, install sudo, or install by hand:" \
        "${missing[*]}"
    echo "    going on without ${missing_optional[*]}: installing packages needs root or sudo"
    SLIM_INIT_MISSING+=("${missing_optional[@]}")
    return
  fi
  echo "    reading the package lists (apt-get update)"
  # One broken source among several must not stop us; what counts is checked below.
  slim_init_apt_get update || echo "    apt-get update reported an error" >&2
  slim_init_install_needed "${missing[@]}"
  slim_init_install_optional "${missing_optional[@]}"
}

# Configures Release with tests; without, if the program alone is wanted and the build
# folder is new.
slim_init_configure() {
  local -a options=(-DCMAKE_BUILD_TYPE=Release)
  local tests=ON
  [[ -z "${SLIM_INIT_PROGRAM_ONLY:-}" ]] || tests=OFF
  if [[ "${tests}" == ON || ! -f "${SLIM_INIT_BUILD_DIR}/CMakeCache.txt" ]]; then
    options+=("-DSLIM_INIT_BUILD_TESTS=${tests}")
  fi
  # Only said where it is meant, so that a user's own choice in the build folder stays.
  if [[ "${CI:-}" == true || "${CI:-}" == 1 ]]; then
    options+=(-DSLIM_INIT_WERROR=ON)
  fi
  if [[ ! -f "${SLIM_INIT_BUILD_DIR}/CMakeCache.txt" ]] && command -v ninja >/dev/null; then
    options+=(-G Ninja)
  fi
  slim_init_say "Configuring ${SLIM_INIT_BUILD_DIR} (Release)"
  cmake -S "${SLIM_INIT_ROOT}" -B "${SLIM_INIT_BUILD_DIR}" "${options[@]}" ||
    slim_init_die "configuring failed; CMake's message above names what is missing"
}

# slim_init_build [--target NAME]...: builds everything, or the targets named.
slim_init_build() {
  slim_init_say "Building with ${SLIM_INIT_JOBS} job(s)"
  cmake --build "${SLIM_INIT_BUILD_DIR}" --parallel "${SLIM_INIT_JOBS}" "$@" ||
    slim_init_die "the build failed; the compiler's message is above"
}

# Packages, configuration, build: what both commands begin with. Arguments as slim_init_build. With
# SLIM_INIT_PROGRAM_ONLY=1 for the program alone.
slim_init_set_up() {
  slim_init_timed packages slim_init_install_packages
  slim_init_timed configuration slim_init_configure
  slim_init_timed build slim_init_build "$@"
}

# The last lines of a run: times, and what this machine did not build or test.
slim_init_summary() {
  local package times
  printf -v times '%s, ' "${SLIM_INIT_TIMES[@]}"
  slim_init_say "Times: ${times%, }"
  if [[ ${#SLIM_INIT_MISSING[@]} -gt 0 ]]; then
    slim_init_say "Optional packages that could not be had on this system:"
    for package in "${SLIM_INIT_MISSING[@]}"; do
      printf '    %s (%s)\n' "${package}" "$(slim_init_purpose "${package}")"
    done
  fi
  [[ ${#SLIM_INIT_NOTES[@]} -eq 0 ]] || printf '\n==> %s\n' "${SLIM_INIT_NOTES[@]}"
  if [[ -s "${SLIM_INIT_BUILD_DIR}/left_out.txt" ]]; then
    slim_init_say "Not part of this build:"
    sed 's/^/    /' "${SLIM_INIT_BUILD_DIR}/left_out.txt"
  else
    slim_init_say "This build is complete."
  fi
}
