#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# DLLs for Windows: they export the reviewed public names, the same as on Linux, and nothing else; they
# need no DLL but their own, the compiler's and Windows'; projects that mingw builds use them on wine, by
# find_package and pkg-config, and types and exceptions go through their walls.
#   tests/package/windows_shared.sh [BUILD]   default build/windows_shared; configured and built where missing
# Needs what cmake/install-deps.sh --with-cross installs and cmake/cross/sysroot.sh x86_64-windows.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/common.sh" windows_shared windows_shared "$@"
export WINEPREFIX=${WINEPREFIX:-$root/build/wine} WINEDEBUG=-all

modules=(pbd collision scene scene_files obj consensus virtual_network net session c c_session c_files)
cmake --build "$build" --target "${modules[@]/#/tandem_}"
prefix=$scratch/prefix
cmake --install "$build" --prefix "$prefix" --component runtime >/dev/null
[[ -z $(find "$prefix" -name '*.a' -o -name '*.h') ]] || fail "what runs programs has files to build them"
cmake --install "$build" --prefix "$prefix" --component dev >/dev/null
libraries=()
for module in "${modules[@]}"; do
  libraries+=("$prefix/bin/libtandem_$module.dll")
  [[ -f $prefix/lib/libtandem_$module.dll.a ]] || fail "$module has no import library"
done
extra=$(find "$prefix" -name '*.a' ! -name 'libtandem_*.dll.a')
[[ -z $extra ]] || fail "static libraries are installed with DLLs:"$'\n'"$extra"

python3 "$here/exports.py" "$prefix/include" --list "$here/public_symbols.txt" "${libraries[@]}" ||
  fail "what DLLs export is not what was reviewed"
# The check of the check: it sees what is not ours and what no header has.
cat >"$scratch/probe.cpp" <<'END'
namespace tandem::pbd {
struct Probe { void seen(); };
void Probe::seen() {}
}
void seen() {}
END
x86_64-w64-mingw32-g++-posix -shared "$scratch/probe.cpp" -o "$scratch/probe.dll"
python3 "$here/exports.py" "$prefix/include" "$scratch/probe.dll" >"$scratch/log" && fail "blind"
[[ $(grep -c 'seen()' "$scratch/log") -eq 2 ]] || fail_with_log "the check of names is broken"

for library in "${libraries[@]}"; do
  for needed in $(objdump -p "$library" | sed -n 's/^\tDLL Name: \(lib.*\)/\1/p'); do
    [[ -f $prefix/bin/$needed ]] || fail "$(basename "$library") needs $needed, which is not installed"
  done
done

wine cmd /c exit >"$scratch/said" 2>&1 </dev/null || fail "wine does not run"
# Windows finds DLLs in the folders of PATH; drive Z is the root of this system.
export WINEPATH="Z:${prefix//\//\\}\\bin"
options=(-DCMAKE_TOOLCHAIN_FILE="$root/cmake/cross/x86_64-windows.cmake" -DBUILD_SHARED_LIBS=ON)
runner=(wine)
for component in pbd obj scene_files session c_session c_files; do
  consumer "$component" "$prefix" fcl ccd tinyobjloader nlohmann_json PkgConfig Eigen3
done

# The flags are words.
# shellcheck disable=SC2046
x86_64-w64-mingw32-g++-posix -std=c++20 -O1 "$here/shared.cpp" -o "$scratch/shared.exe" -I"$root/tests" \
  $(PKG_CONFIG_LIBDIR=$prefix/lib/pkgconfig pkg-config --cflags --libs tandem-net tandem-virtual_network \
    tandem-obj) || fail "a program does not build by pkg-config"
wine "$scratch/shared.exe" >"$scratch/log" 2>&1 </dev/null ||
  fail_with_log "types or exceptions do not get through"
tr -d '\r' <"$scratch/log"
echo "windows_shared: DLLs show what is public, and can be used"
