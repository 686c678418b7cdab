#!/usr/bin/env bash
# Installs the browser that tests/web drives, by apt. What cannot be installed is said, is no failure
# here, and is skipped by the tests with a reason.
set -uo pipefail
command -v chromium >/dev/null && exit 0
if command -v apt-get >/dev/null && [ "$(id -u)" = 0 ]; then
  echo "installing chromium with apt ..."
  export DEBIAN_FRONTEND=noninteractive
  apt-get -qq update && apt-get -qq -o DPkg::Lock::Timeout=300 install -y chromium >/dev/null 2>&1
fi
command -v chromium >/dev/null || echo "****** LEFT OUT: the page's tests; as root: apt-get install chromium ******"
