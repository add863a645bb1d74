#!/usr/bin/env bash
# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#
# The hosts of the VINS family were written for OpenCV 3 and C++11. This makes a checkout of one
# build with OpenCV 4 (Ubuntu 20.04, Debian 11 and 12) and, with --cxx17, with Ceres 2.1, whose
# headers need C++17 (Debian 12). It replaces the constants and headers of the C interface that
# OpenCV 4 has no longer by those of the same meaning, and -std=c++11 by -std=c++17. Nothing else;
# run again it changes nothing. To undo it: git -C CHECKOUT checkout .
#   for_opencv4.sh CHECKOUT [--cxx17]
set -euo pipefail

if [[ $# -lt 1 || $# -gt 2 || ! -d "$1" || "${2:---cxx17}" != --cxx17 ]]; then
  sed -n '9s/^# */usage: /p' "${BASH_SOURCE[0]}" >&2
  exit 2
fi

rules='
s/\bCV_(GRAY2RGB|GRAY2BGR|BGR2GRAY|RGB2GRAY)\b/cv::COLOR_\1/g
s/\bCV_(FONT_HERSHEY_SIMPLEX|WINDOW_NORMAL|RETR_CCOMP|CHAIN_APPROX_SIMPLE)\b/cv::\1/g
s/\bCV_(THRESH_BINARY|THRESH_BINARY_INV|ADAPTIVE_THRESH_MEAN_C)\b/cv::\1/g
s/\bCV_(CALIB_CB_(ADAPTIVE_THRESH|NORMALIZE_IMAGE|FILTER_QUADS|FAST_CHECK))\b/cv::\1/g
s/\bCV_LOAD_IMAGE_(GRAYSCALE|COLOR|UNCHANGED)\b/cv::IMREAD_\1/g
s/\bCV_SHAPE_(RECT|CROSS)\b/cv::MORPH_\1/g
s/\bCV_TERMCRIT_EPS\b/cv::TermCriteria::EPS/g
s/\bCV_TERMCRIT_ITER\b/cv::TermCriteria::MAX_ITER/g
s/\bCV_AA\b/cv::LINE_AA/g
s/\bcv::cv::/cv::/g
s|^([[:space:]]*#[[:space:]]*include[[:space:]]*)[<"]opencv/[a-z]+\.h(pp)?[>"]|\1<opencv2/opencv.hpp>|'

changed=0
# change <rules> <file>...: in place, only where something changes
change() {
  local rules="$1" file
  shift
  for file in "$@"; do
    if ! sed -E "${rules}" "${file}" | cmp -s - "${file}"; then
      sed -E -i "${rules}" "${file}"
      changed=$((changed + 1))
      printf '%s\n' "${file}"
    fi
  done
}

mapfile -d '' -t sources < <(find "$1" -name .git -prune -o -type f \
  \( -name '*.cpp' -o -name '*.cc' -o -name '*.h' -o -name '*.hpp' \) -print0 | sort -z)
change "${rules}" "${sources[@]}"
if [[ "${2:-}" == --cxx17 ]]; then
  mapfile -d '' -t lists < <(find "$1" -name .git -prune -o -type f -name CMakeLists.txt -print0 |
    sort -z)
  change 's/-std=c\+\+(11|14)/-std=c++17/g' "${lists[@]}"
fi
echo "${changed} files changed"
