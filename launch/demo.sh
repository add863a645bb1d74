#!/usr/bin/env bash
# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#
# Installs what is missing, builds, and compares the methods on two simulated motions.
#   ./launch/demo.sh [--quick] [--out DIR]
#     --quick    fewer windows: seconds instead of a minute
#     --out DIR  where the reports go (default: demo/ in the build folder)
# The variables that change the set-up are listed in launch/setup.sh.
set -euo pipefail
# shellcheck source=launch/setup.sh
source "$(dirname -- "${BASH_SOURCE[0]}")/setup.sh"

stride=10 # frames between the starts of two windows, as in the paper's protocol
out="${SLIM_INIT_BUILD_DIR}/demo"
while [[ $# -gt 0 ]]; do
  case "$1" in
    --quick) stride=60 ;;
    --out)
      [[ $# -ge 2 ]] || slim_init_die "--out needs a folder"
      out="$2"
      shift
      ;;
    -h | --help)
      sed -n '4,8s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"
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
  "${program}" ab --builtin "$1" --world "$2" --methods slim-paper,drt-l --stride "${stride}" \
    --seed 1 --out "${out}/$1" </dev/null ||
    slim_init_die "the comparison on \"$1\" failed; its message is above"
  [[ -f "${out}/$1/report.md" ]] || slim_init_die "the comparison left no ${out}/$1/report.md"
}

compare figure-eight room "rich motion, rich texture"
compare corridor-walk corridor "walking along a corridor, where scale is hard to see"

slim_init_say "Reports:"
printf '    %s\n' "${out}/figure-eight/report.md" "${out}/corridor-walk/report.md"
