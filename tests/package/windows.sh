#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# The zip for Windows: made, unpacked, and used by a project that mingw builds, on wine.
#   tests/package/windows.sh [BUILD]   default build/windows; the preset's libraries, and programs as far as they are built
# Needs what cmake/install-deps.sh --with-cross installs and cmake/cross/sysroot.sh x86_64-windows.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/common.sh" windows windows "$@"
export WINEPREFIX=${WINEPREFIX:-$root/build/wine} WINEDEBUG=-all

packed=(tandem_scene)
known=$(cmake --build "$build" --target help)
for target in tandem_{session,obj,scene_files,c_session,c_files} cubes tandem-key; do
  if grep -qE "^$target:" <<<"$known"; then packed+=("$target"); fi
done
cmake --build "$build" --target "${packed[@]}"
(cd "$build" && cpack -G ZIP -B "$scratch/packages") >"$scratch/log" 2>&1 || fail_with_log "cpack fails"
zip=$(echo "$scratch"/packages/*.zip)
[[ -f $zip ]] || fail "there is no zip"
echo "windows: $(basename "$zip"), $(stat -c %s "$zip") bytes"

# Wine's own folder, where it is new, is no part of what the zip takes.
wine cmd /c exit >"$scratch/said" 2>&1 </dev/null || fail "wine does not run"
begin
(cd "$scratch" && cmake -E tar xf "$zip")
prefix=$scratch/$(basename "$zip" .zip)
# Our toolchain's compiler, and nothing else that is found here.
options=(-DCMAKE_TOOLCHAIN_FILE="$root/cmake/cross/x86_64-windows.cmake")
runner=(wine)
consumer scene "$prefix" fcl ccd tinyobjloader PkgConfig Eigen3
took "the zip for Windows, find_package"
for component in session obj c_files; do
  [[ " ${packed[*]} " == *" tandem_$component "* ]] || { echo "windows: SKIPPED: $component, as it is not built"; continue; }
  consumer "$component" "$prefix" fcl ccd tinyobjloader nlohmann_json PkgConfig Eigen3
done
begin
# The flags are words.
# shellcheck disable=SC2046
x86_64-w64-mingw32-g++-posix -std=c++20 -O2 -static "$here/scene.cpp" -o "$scratch/plain.exe" \
  $(PKG_CONFIG_LIBDIR=$prefix/lib/pkgconfig pkg-config --cflags --libs tandem-scene) ||
  fail "a program does not build by pkg-config"
wine "$scratch/plain.exe" >"$scratch/said" 2>&1 </dev/null || { cat "$scratch/said" >&2; fail "it does not run"; }
took "the zip for Windows, pkg-config"

licenses=$prefix/share/doc/tandem
for name in LICENSE licenses/{libfcl,libccd,libsodium,libeigen3,libasio,libtinyobjloader}-dev.txt \
  licenses/g++-mingw-w64-x86-64-posix.txt; do
  [[ -s $licenses/$name ]] || fail "the licence $name is not in it"
done
! grep -rlF -e "$build" -e "$root" "$prefix" || fail "the files above know where they were built"
[[ ${packed[*]} == *cubes* ]] || { echo "windows: SKIPPED: the programs, as the build has none"; exit; }
wine "$prefix/bin/tandem-key.exe" >"$scratch/said" 2>&1 </dev/null || fail "tandem-key does not run"
wine "$prefix/demos/cubes.exe" --seconds 1 --print nothing >"$scratch/said" 2>&1 </dev/null || {
  cat "$scratch/said" >&2
  fail "a demo does not run"
}
echo "windows: the zip can be used"
