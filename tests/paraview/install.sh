#!/usr/bin/env bash
# Installs the ParaViews of tests/paraview:
#   - the distribution's own, by apt (ParaView 5.11 on Debian 12);
#   - those of the named Debian suites, trixie (5.13) and forky (6.1), each as a root file system of
#     2.7 GB in .cache/paraview, or in $VTK_MLS_PARAVIEW_CACHE;
# and for tests of their GUIs a display, xdotool and ImageMagick, and Qt for Python.
# Existing ones are completed. A missing ParaView is reported at the end and is no failure here: its
# tests are skipped.
set -uo pipefail

here=$(realpath "$(dirname "$0")")
cache=${VTK_MLS_PARAVIEW_CACHE:-$here/../../.cache/paraview}
packages=(paraview python3-paraview python3-pyopencl python3-nibabel pocl-opencl-icd openmpi-bin)
gui_packages=(xvfb xauth xdotool imagemagick python3-pyqt5)
root_packages=("${packages[@]}" python3-pyqt6)
suites=("$@")
ready=() left_out=()
log=$(mktemp)
trap 'rm -f "$log"' EXIT
export DEBIAN_FRONTEND=noninteractive

# Runs a command quietly; the log is for the summary.
try() { "$@" >"$log" 2>&1; }
reason() { grep -v '^[[:space:]]*$' "$log" | tail -n 1; }

apt_install() {
  apt_updated=${apt_updated:-$(try apt-get -qq update && echo yes)}
  try apt-get -qq -o DPkg::Lock::Timeout=300 install -y "$@"
}

can_install() { # prints the reason if not
  if ! command -v apt-get >/dev/null; then echo "this machine has no apt-get"; return 1; fi
  if [ "$(id -u)" != 0 ]; then echo "installing needs root"; return 1; fi
}

has_all() { dpkg -s "${packages[@]}" "${gui_packages[@]}" >/dev/null 2>&1; }

system_paraview() {
  if ! has_all && why=$(can_install); then
    echo "installing this system's ParaView with apt ..."
    apt_install "${packages[@]}" "${gui_packages[@]}" || why=$(reason)
  fi
  if command -v pvpython >/dev/null; then
    ready+=("$(pvpython --version 2>/dev/null | head -n 1) from this system")
    for tool in Xvfb xdotool import; do
      command -v "$tool" >/dev/null ||
        left_out+=("the GUIs, and what has to be drawn: there is no $tool (${why:-apt did not install it})")
    done
  else
    left_out+=("this system's ParaView: ${why:-apt installed no pvpython}.
      As root: apt-get install ${packages[*]} ${gui_packages[*]}")
  fi
}

debian_mirror() {
  cat /etc/apt/sources.list.d/*.sources /etc/apt/sources.list 2>/dev/null |
    grep -oE '^(URIs:|deb) .*' | grep -oE 'https?://[^ ]+/debian/?( |$)' | head -n 1 | tr -d ' '
}

# A frozen mirror's testing suite may be past its date of validity.
past_date=Acquire::Check-Valid-Until

make_root() { # SUITE DIR
  echo "making a Debian $1 with ParaView in $2 (2.7 GB, some minutes) ..."
  command -v mmdebstrap >/dev/null || apt_install mmdebstrap || return
  mkdir -p "$cache"
  echo "*" >"$cache/.gitignore"
  rm -rf --one-file-system "$2.part"
  mirror=$(debian_mirror)
  if try mmdebstrap --variant=minbase --aptopt="$past_date \"false\"" --include="$(IFS=,; echo "${root_packages[*]}")" \
    "$1" "$2.part" "${mirror:-http://deb.debian.org/debian}"; then
    mv "$2.part" "$2"
  else
    rm -rf --one-file-system "$2.part"
    return 1
  fi
}

complete_root() { # DIR
  try dpkg --root="$1" -s "${root_packages[@]}" && return
  echo "adding what is missing in $1 ..."
  try "$here/in_root.sh" "$1" bash -c 'apt-get -qq -o "$0=false" update && apt-get -qq install -y "$@"' \
    "$past_date" "${root_packages[@]}"
}

newer_paraview() { # SUITE
  local root=$cache/$1
  if ! [ -x "$root/usr/bin/pvpython" ]; then
    why=$(can_install) || { left_out+=("ParaView of Debian $1: $why"); return; }
    make_root "$1" "$root" || { left_out+=("ParaView of Debian $1: $(reason)"); return; }
  fi
  if ! try "$here/in_root.sh" "$root" pvpython --version; then
    left_out+=("ParaView in $root, which cannot be entered: $(reason)")
    return
  fi
  ready+=("$(grep version "$log" | head -n 1) in $root")
  complete_root "$root" || left_out+=("packages in $root: $(reason)")
}

system_paraview
for suite in "${suites[@]}"; do newer_paraview "$suite"; done

for line in "${ready[@]}"; do echo "ParaView tests: ready: $line"; done
if [ ${#left_out[@]} -gt 0 ]; then
  echo
  echo "****** PARAVIEW TESTS LEFT OUT ******"
  for line in "${left_out[@]}"; do echo "  *** $line"; done
  echo "*************************************"
fi
