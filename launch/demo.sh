#!/usr/bin/env bash
# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#
# Installs what is missing, builds, renders a walk along a corridor, writes it as a rosbag and compares
# `slim` with the initializers of VINS-Mono (`vins`) and OpenVINS (`openvins`) on the images of that bag.
#   ./launch/demo.sh [--quick] [--out DIR]
#     --quick    a shorter walk and fewer windows
#     --out DIR  where bag and report go (default: demo/ in the build folder)
# The variables that change the set-up are listed in launch/setup.sh.
set -euo pipefail
# shellcheck source=launch/setup.sh
source "$(dirname -- "${BASH_SOURCE[0]}")/setup.sh"

motion=corridor-walk
scene=corridor
seconds=10 # of motion; a window takes 2.25 s
stride=8   # images between the starts of two windows
out="${SLIM_INIT_BUILD_DIR}/demo"
while [[ $# -gt 0 ]]; do
  case "$1" in
    --quick)
      seconds=4
      stride=10
      ;;
    --out)
      [[ $# -ge 2 ]] || slim_init_die "--out needs a folder"
      out="$2"
      shift
      ;;
    -h | --help)
      sed -n '4,9s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"
      exit 0
      ;;
    *) slim_init_die "unknown option $1 (known: --quick, --out DIR, --help)" ;;
  esac
  shift
done

slim_init_set_up --target slim_init_tool
program="${SLIM_INIT_BUILD_DIR}/bin/slim_init"
[[ -x "${program}" ]] || slim_init_die "the build left no program ${program}"
command -v povray >/dev/null || slim_init_die "povray is missing, which draws the images"

# The rig of the EuRoC dataset, as a VINS-Mono user has it.
config="${SLIM_INIT_ROOT}/config/euroc.yaml"

render() {
  slim_init_say "Rendering ${seconds} s of images (${motion}, scene ${scene}) with POV-Ray"
  rm -rf "${out}"
  "${program}" simulate --builtin "${motion}" --scene "${scene}" --duration "${seconds}" --seed 1 \
    --config "${config}" --threads "${SLIM_INIT_JOBS}" --out "${out}/sequence" "$@" </dev/null ||
    slim_init_die "rendering failed; its message is above"
}

compare() {
  slim_init_say "A/B from the images of ${*: -1}: points and lines are tracked, with ground truth"
  "${program}" ab "$@" --methods slim,vins,openvins --gates own --stride "${stride}" \
    --out "${out}/report" </dev/null ||
    slim_init_die "the comparison failed; its message is above"
  [[ -f "${out}/report/report.html" ]] || slim_init_die "no ${out}/report/report.html was written"
}

if slim_init_is_left_out rosbag; then
  slim_init_say "This build cannot read bags (see the last lines): the same from an ASL folder"
  slim_init_timed rendering render
  slim_init_timed comparison compare --asl "${out}/sequence"
else
  slim_init_timed rendering render --bag "${out}/walk.bag"
  slim_init_timed comparison compare --config "${config}" --bag "${out}/walk.bag"
fi

slim_init_summary
slim_init_say "Report, with tables and pictures: ${out}/report/report.html"
