#!/usr/bin/env bash
# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#
# Installs what is missing, builds, and compares the methods on two simulated motions; with POV-Ray
# also from the pixels of a short rendered walk along a corridor.
#   ./launch/demo.sh [--quick] [--out DIR]
#     --quick    fewer windows and images: half a minute instead of some
#     --out DIR  where the reports go (default: demo/ in the build folder)
# The variables that change the set-up are listed in launch/setup.sh.
set -euo pipefail
# shellcheck source=launch/setup.sh
source "$(dirname -- "${BASH_SOURCE[0]}")/setup.sh"

stride=10 # frames between the starts of two windows, as in the paper's protocol
seconds=6 # of the rendered walk: some windows of 2.25 s
out="${SLIM_INIT_BUILD_DIR}/demo"
while [[ $# -gt 0 ]]; do
  case "$1" in
    --quick)
      stride=60
      seconds=3
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

slim_init_install_packages both
# A build folder that already has tests keeps them; a new one does without.
if [[ -f "${SLIM_INIT_BUILD_DIR}/CMakeCache.txt" ]]; then
  slim_init_build
else
  slim_init_build -DSLIM_INIT_BUILD_TESTS=OFF -DSLIM_INIT_BUILD_BENCHMARKS=OFF
fi

program="${SLIM_INIT_BUILD_DIR}/bin/slim_init"
[[ -x "${program}" ]] || slim_init_die "the build left no program ${program}"

# compare <motion> <world> <what it shows>
compare() {
  slim_init_say "A/B on \"$1\" in a $2: $3"
  "${program}" ab --builtin "$1" --world "$2" --methods slim,slim-paper,drt-l --stride "${stride}" \
    --seed 1 --out "${out}/$1" </dev/null ||
    slim_init_die "the comparison on \"$1\" failed; its message is above"
  [[ -f "${out}/$1/report.md" ]] || slim_init_die "the comparison left no ${out}/$1/report.md"
}

compare figure-eight room "rich motion, rich texture"
compare corridor-walk corridor "walking along a corridor, where scale is hard to see"

reports=("${out}/figure-eight/report.md" "${out}/corridor-walk/report.md")

# The same walk once more, from pixels.
if command -v povray >/dev/null; then
  slim_init_say "Rendering ${seconds} s of a walk along a corridor (POV-Ray)"
  rm -rf "${out}/corridor-images"
  "${program}" simulate --builtin corridor-walk --scene corridor --duration "${seconds}" --seed 1 \
    --threads "${SLIM_INIT_JOBS}" --out "${out}/corridor-images" </dev/null ||
    slim_init_die "rendering the corridor failed; its message is above"
  slim_init_say "A/B from these images: points and lines are tracked, not simulated"
  "${program}" ab --asl "${out}/corridor-images" --stride 5 \
    --out "${out}/corridor-pixels" </dev/null ||
    slim_init_die "the comparison on images failed; its message is above"
  reports+=("${out}/corridor-pixels/report.md")
else
  slim_init_say "POV-Ray is not installed: no images were rendered, the comparisons above are on" \
    "simulated features"
fi

slim_init_say "Reports:"
printf '    %s\n' "${reports[@]}"
