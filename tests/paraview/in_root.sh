#!/usr/bin/env bash
# Runs a command in a root file system that holds a ParaView; this project appears there as /project,
# which is also the folder the command starts in.
#
#   in_root.sh DIR COMMAND...
#
# Needs root. Everything is mounted in a mount namespace of the command's own and goes away with it, so
# several can run at once and nothing is left mounted.
set -euo pipefail
[ $# -ge 2 ] || { sed -n '2,8s/^# \{0,1\}//p' "$0" >&2; exit 2; }
root=$1 project=$(realpath "$(dirname "$0")/../..")
shift
[ -x "$root/usr/bin/pvpython" ] || { echo "in_root.sh: no ParaView in $root" >&2; exit 1; }
[ "$(id -u)" = 0 ] || { echo "in_root.sh: entering $root needs root" >&2; exit 1; }
mkdir -p "$root/project"
exec unshare --mount --propagation private bash -euc '
  root=$1 project=$2; shift 2
  mount -t proc proc "$root/proc"
  mount --rbind /sys "$root/sys"
  mount --rbind /dev "$root/dev"
  mount --bind "$project" "$root/project"
  mount -t tmpfs -o mode=700 runtime "$root/run"
  exec chroot "$root" env -C /project HOME=/root XDG_RUNTIME_DIR=/run "$@"' \
  in_root "$root" "$project" "$@"
