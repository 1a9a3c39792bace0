#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# The Python package as one for Debian, with shared libraries: made, unpacked into a folder, used there.
#   tests/package/python.sh [BUILD]   default build/python_shared; always configured
# Exits with 77 where there is no dpkg-deb, and says so.
set -euo pipefail
command -v dpkg-deb >/dev/null || {
  echo "SKIPPED: there is no dpkg-deb"
  exit 77
}

source "$(dirname "${BASH_SOURCE[0]}")/common.sh" python shared "${1:-build/python_shared}"
# The package's dependencies, and nothing else.
(cd "$root" && cmake --preset shared -B "$build" -DTANDEM_BUILD_PYTHON=ON -DTANDEM_BUILD_C=OFF \
  -DTANDEM_BUILD_OBJ=OFF -DTANDEM_BUILD_DEMOS=OFF -DTANDEM_BUILD_TESTS=OFF >/dev/null)
cmake --build "$build"
(cd "$build" && cpack -G DEB -B "$scratch/packages" -D "CPACK_COMPONENTS_ALL=runtime;python") \
  >"$scratch/log" 2>&1 || fail_with_log "cpack fails"
for package in "$scratch"/packages/*.deb; do
  echo "python: $(dpkg-deb -f "$package" Package): $(dpkg-deb -f "$package" Depends)"
  dpkg-deb -x "$package" "$scratch/unpacked"
done
! grep -rlF -e "$build" -e "$root" "$scratch/unpacked" || fail "the files above know where they were built"

PYTHONPATH=$scratch/unpacked/usr/lib/python3/dist-packages /usr/bin/python3 "$here/fall.py" ||
  fail "the package does not run"
echo "python: the package can be used"
