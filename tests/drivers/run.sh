#!/usr/bin/env bash
# Runs the kernels, built as for GPUs, under two OpenCL implementations that need no GPU and find
# other faults than CPU drivers do:
#   - Oclgrind, a simulator that reports accesses out of bounds and races, and whose compiler has
#     generic address spaces;
#   - rusticl, Mesa's compiler for GPUs, without float64 (as root on Debian, by apt).
# A missing implementation is reported, and is no failure. With the argument "all" both run more
# kernels.
set -euo pipefail
cd "$(dirname "$0")/../.."
cache=$PWD/.cache/drivers
mkdir -p "$cache/none" "$cache/rusticl"
export XDG_CACHE_HOME=$cache PYTHONPATH=$PWD
check=tests/drivers/check_kernels.py
python=.venv-oclgrind/bin/python  # `make drivers` has made it

check_by_oclgrind() {
  rm -f "$cache/oclgrind.log"
  OCL_ICD_VENDORS=$cache/none OCLGRIND_DATA_RACES=1 OCLGRIND_LOG=$cache/oclgrind.log \
    $python $check Oclgrind ${1:+"$1"}
}

driver() { find /usr/lib /usr/lib64 -name 'libRusticlOpenCL.so.1' 2>/dev/null | head -n 1; }

install_rusticl() {
  if [ -z "$(driver)" ] && [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null; then
    export DEBIAN_FRONTEND=noninteractive
    { apt-get -qq update && apt-get -qq -o DPkg::Lock::Timeout=300 install -y mesa-opencl-icd; } \
      >"$cache/apt.log" 2>&1 || tail -n 2 "$cache/apt.log"
    # other programs on this machine must not load it
    rm -f /etc/OpenCL/vendors/mesa.icd /etc/OpenCL/vendors/rusticl.icd
  fi
}

check_by_rusticl() {
  install_rusticl
  if [ -z "$(driver)" ]; then
    echo "****** LEFT OUT: rusticl, for there is no libRusticlOpenCL.so.1 (Debian: mesa-opencl-icd) ******"
    return
  fi
  driver >"$cache/rusticl/rusticl.icd"
  # a few steps only: it builds the larger kernels in minutes, and one in eight
  local steps=("polynomial, no cut: points" "images, linear")
  [ "$1" != all ] || steps+=("affine, between nodes" "affine, curves: points"
    "affine, half-plane: points" "rigid, no cut: points" "affine, regions and limits: points"
    "affine, half-plane: grid" "rigid, half-plane: inverse" "slopes on a grid")
  RUSTICL_ENABLE=llvmpipe OCL_ICD_VENDORS=$cache/rusticl $python $check rusticl "${steps[@]}"
}

check_by_rusticl "${1:-}" >"$cache/rusticl.log" 2>&1 & rusticl=$!
status=0
check_by_oclgrind "${1:-}" || status=1
wait $rusticl || status=1
cat "$cache/rusticl.log"
exit $status
