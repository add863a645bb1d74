#!/usr/bin/env bash
# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#
# Installs what is missing, builds the program, renders a walk and compares `slim` with the initializers
# of VINS-Mono (`vins`) and OpenVINS (`openvins`) on its images: as recorded, and as a home-made rig has
# them. A second run renders nothing.
#   ./launch/demo.sh [--quick] [--out DIR]
#     --quick    a shorter walk and fewer starts
#     --out DIR  where walk and page go (default: demo/ in the build folder)
# The variables that change the set-up are listed in launch/setup.sh.
set -euo pipefail
# shellcheck source=launch/setup.sh
source "$(dirname -- "${BASH_SOURCE[0]}")/setup.sh"

seconds=6 # of motion; a window takes 2 s
stride=4  # images between the starts of two windows
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
      sed -n '4,10s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"
      exit 0
      ;;
    *) slim_init_die "unknown option $1 (known: --quick, --out DIR, --help)" ;;
  esac
  shift
done

SLIM_INIT_PROGRAM_ONLY=1
slim_init_set_up --target slim_init_tool
program="${SLIM_INIT_BUILD_DIR}/bin/slim_init"
[[ -x "${program}" ]] || slim_init_die "the build left no program ${program}"
command -v povray >/dev/null || slim_init_die "povray is missing, which draws the images"

walk="${out}/walk_${seconds}s"
render() {
  if [[ -f "${walk}/complete" ]]; then
    slim_init_say "The walk is there: ${walk}"
    return
  fi
  slim_init_say "Rendering ${seconds} s of images with POV-Ray"
  rm -rf "${walk}"
  # The rig of the EuRoC dataset, as a VINS-Mono user has it.
  "${program}" simulate --builtin corridor-walk --scene corridor --duration "${seconds}" --seed 1 \
    --config "${SLIM_INIT_ROOT}/config/euroc.yaml" --threads "${SLIM_INIT_JOBS}" --out "${walk}" \
    </dev/null || slim_init_die "rendering failed; its message is above"
  touch "${walk}/complete"
}

compare() {
  slim_init_say "slim, vins and openvins on the images, with both calibrations"
  "${program}" demo --asl "${walk}" --stride "${stride}" --out "${out}" </dev/null ||
    slim_init_die "the comparison failed; its message is above"
  [[ -f "${out}/report.html" ]] || slim_init_die "no ${out}/report.html was written"
}

slim_init_timed rendering render
slim_init_timed comparison compare
slim_init_summary
slim_init_say "Page, with the picture: ${out}/report.html"
