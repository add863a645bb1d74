#!/usr/bin/env bash
# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#
# Runs the two commands of the README on a bare Debian: a minimal system made by debootstrap in a
# folder, a clean clone of this repository's last commit in it, and nothing else. Then installs the
# Debian package of that build in another one, and runs its demo. Reports the times and what was left
# out, and fails if a command fails or a test is missing without being named.
# Needs root, debootstrap (installed if it is missing), network, and about 5 GB.
#   sudo ./tests/bare_machine.sh [--suite NAME] [--mirror URL] [--dir DIR] [--keep] [--package DEB]
#     --package DEB  only installs this package and runs its demo
#     --suite NAME  release of Debian (default: bookworm, which is Debian 12)
#     --mirror URL  where packages come from (default: where this machine has that release from)
#     --dir DIR     folder for system and logs (default: a new one in TMPDIR); must not exist
#     --keep        keep the system; the logs are kept anyway
set -euo pipefail

die() {
  printf 'error: %s\n' "$*" >&2
  exit 1
}
say() { printf '\n==> %s\n' "$*"; }
duration() { printf '%d:%02d min' "$(($1 / 60))" "$(($1 % 60))"; }

# Inside: a mount and process namespace of its own, so that the mounts end with it however it ends.
# run_in_chroot <system> <command>
run_in_chroot() {
  mount --rbind /dev "$1/dev"
  mount -t proc proc "$1/proc"
  local -a proxy=()
  local name
  for name in http_proxy https_proxy no_proxy; do
    [[ -z "${!name:-}" ]] || proxy+=("${name}=${!name}")
  done
  exec chroot "$1" /usr/bin/env -i HOME=/root PATH=/usr/sbin:/usr/bin:/sbin:/bin \
    DEBIAN_FRONTEND=noninteractive "${proxy[@]}" /bin/bash -c "cd /slim_init && $2" </dev/null
}
if [[ "${1:-}" == --in-namespace ]]; then
  run_in_chroot "$2" "$3"
fi

root="$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")/.." && pwd -P)"
suite=bookworm
mirror=
dir=
keep=
package=
while [[ $# -gt 0 ]]; do
  case "$1" in
    --suite | --mirror | --dir | --package)
      [[ $# -ge 2 ]] || die "$1 needs a value"
      printf -v "${1#--}" '%s' "$2"
      shift
      ;;
    --keep) keep=1 ;;
    -h | --help)
      sed -n '4,14s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"
      exit 0
      ;;
    *) die "unknown option $1 (known: --suite, --mirror, --dir, --keep, --package, --help)" ;;
  esac
  shift
done

[[ ${EUID} -eq 0 ]] || die "this makes a system in a folder and mounts into it, which needs root"
if ! command -v debootstrap >/dev/null; then
  command -v apt-get >/dev/null || die "debootstrap is missing, and there is no apt-get to install it"
  say "Installing debootstrap"
  apt-get -y -qq -o DPkg::Lock::Timeout=300 install --no-install-recommends debootstrap >/dev/null ||
    die "debootstrap is missing and could not be installed"
fi
command -v git >/dev/null || die "git is missing"

# The README's commands, as they stand there.
mapfile -t commands < <(grep -E '^\./(launch/demo|tests/run)\.sh' "${root}/README.md" |
  sed 's/ *#.*//')
[[ ${#commands[@]} -eq 2 ]] || die "README.md has ${#commands[@]} commands of set-up, not two"

# This machine's own sources of that release: "<release> <address> <component> <key file>" a line.
# shellcheck disable=SC2016  # apt-get fills these in
sources="$(apt-get indextargets --format '$(RELEASE) $(REPO_URI) $(COMPONENT) $(SIGNED_BY)' \
  'Created-By: Packages' 2>/dev/null | sort -u)" || sources=
if [[ -z "${mirror}" ]]; then
  mirror="$(awk -v suite="${suite}" '$1 == suite && $3 == "main" { print $2; exit }' \
    <<<"${sources}")"
  [[ -n "${mirror}" ]] || die "the package sources of this machine do not have ${suite}: --mirror URL"
fi
keyring=/usr/share/keyrings/debian-archive-keyring.gpg
[[ -f "${keyring}" ]] || die "${keyring} is missing: install debian-archive-keyring"

if [[ -z "${dir}" ]]; then
  dir="$(mktemp -d -t slim_init_bare.XXXXXX)"
else
  [[ ! -e "${dir}" ]] || die "${dir} exists"
  mkdir -p "${dir}"
fi
dir="$(cd -- "${dir}" && pwd -P)"
system="${dir}/system"

clean_up() {
  # Nothing is mounted below in this namespace; --one-file-system would keep out of it if there were.
  [[ -n "${keep}" ]] || rm -rf --one-file-system "${system}" "${dir}/package_system"
}
trap clean_up EXIT
trap 'exit 130' INT TERM

# make_system <folder>
make_system() {
  say "A bare ${suite} in ${1}"
  local begin=${SECONDS} file
  local -a include=()
  [[ "${mirror}" != https:* ]] || include=(--include=ca-certificates)
  debootstrap --variant=minbase --keyring="${keyring}" "${include[@]}" "${suite}" "${1}" \
    "${mirror}" >"${dir}/debootstrap.log" 2>&1 ||
    die "debootstrap failed: $(tail -n 3 "${dir}/debootstrap.log")"
  echo "    $(duration $((SECONDS - begin)))"

  # What decides whether the network is reached from here: proxies, name resolution, and updates of the
  # same release; no credentials.
  apt-config dump | grep -E '^Acquire::((http|https|ftp)::|Check-|ForceIPv)' \
    >"${1}/etc/apt/apt.conf.d/90host" || true
  awk -v suite="${suite}" '($1 == suite || index($1, suite "-") == 1) && $3 == "main" {
      print "deb", $2, $1, $3 }' <<<"${sources}" >"${dir}/sources.list"
  [[ ! -s "${dir}/sources.list" ]] || cp "${dir}/sources.list" "${1}/etc/apt/sources.list"
  rm -f "${dir}/sources.list"
  for file in /etc/resolv.conf /etc/hosts; do
    [[ ! -f "${file}" ]] || cp -L "${file}" "${1}${file}"
  done
}

# run_in <system> <command> <log>: notes the time, and the command if it fails.
failed=()
times=()
run_in() {
  local begin=${SECONDS} status=0
  say "$2 (log: $3)"
  unshare --mount --pid --fork --kill-child --propagation private \
    "${BASH_SOURCE[0]}" --in-namespace "$1" "$2" >"$3" 2>&1 || status=$?
  times+=("$2: $(duration $((SECONDS - begin)))")
  [[ ${status} -ne 0 ]] || return 0
  failed+=("$2 (exit ${status})")
  tail -n 40 "$3"
  return 1
}

# What a user of the package does, on a system without anything of ours.
try_package() {
  local begin
  make_system "${dir}/package_system"
  mkdir "${dir}/package_system/slim_init"
  cp "$1" "${dir}/package_system/slim_init/slim-init.deb"
  run_in "${dir}/package_system" "apt-get -q update && apt-get -qy install --no-install-recommends ./slim-init.deb" \
    "${dir}/install.log" || return 0
  begin=${SECONDS}
  run_in "${dir}/package_system" "slim_init demo" "${dir}/demo.log" || return 0
  [[ $((SECONDS - begin)) -le 90 ]] || failed+=("slim_init demo: above 90 s")
  [[ -f "${dir}/package_system/slim_init/slim_init_demo/report.html" ]] ||
    failed+=("slim_init demo wrote no page")
}

finish() {
  say "Bare ${suite}: $(printf '%s; ' "${times[@]}")logs in ${dir}"
  [[ ${#failed[@]} -eq 0 ]] || {
    printf 'failed: %s\n' "${failed[@]}" >&2
    exit 1
  }
}

if [[ -n "${package}" ]]; then
  try_package "${package}"
  finish
  exit 0
fi
make_system "${system}"

# A clone of the last commit, by way of a bundle: the repository may belong to another user than root,
# from whom git takes nothing unless it is asked to.
git_here=(git -c safe.directory="${root}" -C "${root}")
[[ -z "$("${git_here[@]}" status --porcelain)" ]] ||
  echo "    note: changes that are not committed are not in it"
"${git_here[@]}" bundle create -q "${dir}/repository.bundle" HEAD
git -c advice.detachedHead=false clone -q "${dir}/repository.bundle" "${system}/slim_init" ||
  die "the repository could not be cloned"
rm "${dir}/repository.bundle"

for index in "${!commands[@]}"; do
  log="${dir}/command_$((index + 1)).log"
  run_in "${system}" "${commands[index]}" "${log}" || break
  sed -n '/^==> Times: /,$p' "${log}"
done

# Every test that the sources declare by name was run, or is named in the last lines.
if [[ ${#failed[@]} -eq 0 ]]; then
  last_lines="$(sed -n '/^==> Times: /,$p' "${log}")"
  "${root}/tests/declared_tests.sh" "${root}"/tests/*/CMakeLists.txt >"${dir}/declared_tests"
  while read -r name; do
    grep -qE " ${name} \.\.\." "${log}" || grep -qw "${name}" <<<"${last_lines}" ||
      failed+=("test ${name} was not run and is not named in the last lines")
  done <"${dir}/declared_tests"
fi

if [[ ${#failed[@]} -eq 0 ]] && run_in "${system}" "cd build && cpack" "${dir}/cpack.log"; then
  try_package "${system}"/slim_init/build/slim-init_*.deb
fi
finish
echo "    all succeeded; $(grep -E 'tests passed' "${log}" | tail -n 1)"
