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
# What the package needs, and nothing else.
(cd "$root" && cmake --preset shared -B "$build" -DTANDEM_BUILD_PYTHON=ON -DTANDEM_BUILD_C=OFF \
  -DTANDEM_BUILD_OBJ=OFF -DTANDEM_BUILD_SCENE_FILES=OFF -DTANDEM_BUILD_DEMOS=OFF -DTANDEM_BUILD_TESTS=OFF >/dev/null)
cmake --build "$build"
(cd "$build" && cpack -G DEB -B "$scratch/packages" -D "CPACK_COMPONENTS_ALL=runtime;python") \
  >"$scratch/log" 2>&1 || fail_with_log "cpack fails"
for package in "$scratch"/packages/*.deb; do
  echo "python: $(dpkg-deb -f "$package" Package): $(dpkg-deb -f "$package" Depends)"
  dpkg-deb -x "$package" "$scratch/unpacked"
done
! grep -rlF -e "$build" -e "$root" "$scratch/unpacked" || fail "the files above know where they were built"

program='
import tandem
scene = tandem.Scene()
scene.add(tandem.HalfSpace(), type="static")
ball = scene.add(tandem.Sphere(0.1), position=(0, 0, 1))
scene.step(1 / 60, steps=120)
assert abs(scene.state[ball.index, 2] - 0.1) < 1e-3, scene.state
with tandem.view(scene, open_browser=False) as page:
    page.show()
print("python:", tandem.__file__)'
PYTHONPATH=$scratch/unpacked/usr/lib/python3/dist-packages /usr/bin/python3 -c "$program" ||
  fail "the package does not run"
echo "python: the package can be used"
