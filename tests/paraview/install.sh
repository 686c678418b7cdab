#!/usr/bin/env bash
# Makes the ParaViews that tests/test_paraview.py runs in:
#   - the distribution's own, by apt (ParaView 5.11 on Debian 12);
#   - Debian forky's (ParaView 6.1), as a root file system of 2.7 GB in .cache/paraview/forky, or below
#     $VTK_MLS_PARAVIEW_CACHE.
# Does nothing for what is there already. What cannot be made is said loudly at the end, is not a failure
# here, and is skipped by the tests with a reason.
set -uo pipefail

here=$(realpath "$(dirname "$0")")
cache=${VTK_MLS_PARAVIEW_CACHE:-$here/../../.cache/paraview}
packages=(paraview python3-paraview python3-pyopencl pocl-opencl-icd)
suite=forky
ready=() left_out=()
log=$(mktemp)
trap 'rm -f "$log"' EXIT
export DEBIAN_FRONTEND=noninteractive

# Runs a command quietly; its last words are kept for the summary.
try() { "$@" >"$log" 2>&1; }
reason() { grep -v '^[[:space:]]*$' "$log" | tail -n 1; }

apt_install() {
  apt_updated=${apt_updated:-$(try apt-get -qq update && echo yes)}
  try apt-get -qq -o DPkg::Lock::Timeout=300 install -y "$@"
}

can_install() { # says why not
  if ! command -v apt-get >/dev/null; then echo "this machine has no apt-get"; return 1; fi
  if [ "$(id -u)" != 0 ]; then echo "installing needs root"; return 1; fi
}

has_all() { command -v pvpython >/dev/null && command -v Xvfb >/dev/null && dpkg -s "${packages[@]}" >/dev/null 2>&1; }

system_paraview() {
  if ! has_all && why=$(can_install); then
    echo "installing this system's ParaView with apt ..."
    apt_install "${packages[@]}" xvfb xauth || why=$(reason)
  fi
  if command -v pvpython >/dev/null; then
    ready+=("$(pvpython --version 2>/dev/null | head -n 1) from this system")
    command -v Xvfb >/dev/null ||
      left_out+=("rendering in this system's ParaView: there is no Xvfb (${why:-package xvfb})")
  else
    left_out+=("this system's ParaView: ${why:-apt installed no pvpython}.
      As root: apt-get install ${packages[*]} xvfb xauth")
  fi
}

debian_mirror() {
  cat /etc/apt/sources.list.d/*.sources /etc/apt/sources.list 2>/dev/null |
    grep -oE '^(URIs:|deb) .*' | grep -oE 'https?://[^ ]+/debian/?( |$)' | head -n 1 | tr -d ' '
}

newer_paraview() {
  local root=$cache/$suite mirror
  if ! [ -x "$root/usr/bin/pvpython" ]; then
    why=$(can_install) || { left_out+=("ParaView of Debian $suite: $why"); return; }
    mirror=$(debian_mirror)
    echo "making a Debian $suite with ParaView in $root (2.7 GB, some minutes) ..."
    command -v mmdebstrap >/dev/null || apt_install mmdebstrap ||
      { left_out+=("ParaView of Debian $suite: no mmdebstrap ($(reason))"); return; }
    mkdir -p "$cache"
    echo "*" >"$cache/.gitignore"
    rm -rf --one-file-system "$root.part"
    # a frozen mirror's testing suite may be past its date of validity
    try mmdebstrap --variant=minbase --aptopt='Acquire::Check-Valid-Until "false"' \
      --include="$(IFS=,; echo "${packages[*]}")" "$suite" "$root.part" \
      "${mirror:-http://deb.debian.org/debian}" ||
      { left_out+=("ParaView of Debian $suite: $(reason)"); rm -rf --one-file-system "$root.part"; return; }
    mv "$root.part" "$root"
  fi
  if try "$here/in_root.sh" "$root" pvpython --version; then
    ready+=("$(grep version "$log" | head -n 1) in $root")
  else
    left_out+=("ParaView in $root, which cannot be entered: $(reason)")
  fi
}

system_paraview
newer_paraview

for line in "${ready[@]}"; do echo "ParaView tests: ready: $line"; done
if [ ${#left_out[@]} -gt 0 ]; then
  echo
  echo "****** PARAVIEW TESTS LEFT OUT ******"
  for line in "${left_out[@]}"; do echo "  *** $line"; done
  echo "*************************************"
fi
