#!/usr/bin/env bash
# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#
# Runs `slim` on the windows that a change of the method is judged by, with PROGRAM (a built
# slim_init) into DIR: tests/compare_answers.py compares two such folders. Expanding windows on
# recorded and built-in motions and on real images, right and miscalibrated rigs; some 600 windows,
# six minutes of one core. DATA: folder with euroc/, tumvi_room5/ and euroc_mh01_snippet/.
#
#   tests/freeze_answers.sh PROGRAM DATA DIR
set -euo pipefail
if [[ $# -ne 3 ]]; then
  sed -n '4,9s/^# *//p' "${BASH_SOURCE[0]}"
  exit 2
fi

program=$1
data=$2
out=$3

run() {  # run NAME ARGUMENT...
  local name=$1
  shift
  echo "${name}"
  "${program}" ab --methods slim --report off --quiet --out "${out}/${name}" "$@" > /dev/null
}
wrong=(--td-error 0.05 --extrinsic-error 10 --random-rig)
tracks=(--outliers 0.03 --drift 0.05)
for sequence in MH_03 MH_04 V1_01 V1_02 V2_01; do
  run "${sequence}" --recorded "${data}/euroc/${sequence}" --stride 70 "${tracks[@]}"
  run "${sequence}_wrong" --recorded "${data}/euroc/${sequence}" --stride 150 "${tracks[@]}" "${wrong[@]}"
done
run room5 --recorded "${data}/tumvi_room5" --world room --stride 60 "${tracks[@]}"
run room5_wrong --recorded "${data}/tumvi_room5" --world room --stride 120 "${tracks[@]}" "${wrong[@]}"
# One solve of ten keyframes, as in the papers: turns leave few tracks that link such a window.
run room5_ten --recorded "${data}/tumvi_room5" --world room --stride 40 --keyframes 10 --gates on "${tracks[@]}"
run V1_02_ten --recorded "${data}/euroc/V1_02" --stride 60 --keyframes 10 --gates on "${tracks[@]}"
for motion in figure-eight corridor-walk constant-velocity circle; do
  run "${motion}" --builtin "${motion}" --stride 30 "${tracks[@]}"
done
run images --asl "${data}/euroc_mh01_snippet" --stride 5
run images_wrong --asl "${data}/euroc_mh01_snippet" --stride 5 "${wrong[@]}"
