#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# Builds pbd, collision and the program `determinism` for another processor or system, runs it on an emulator and
# prints its lines: table.sh --cross compares them with those of the compilers here.
#   benchmarks/determinism/cross.sh aarch64-linux|x86_64-windows [what determinism takes: scenes, --steps N]
# Needs what cmake/install-deps.sh --with-cross installs.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
root=$PWD
target=$1
shift

case $target in
  aarch64-linux) emulator=(qemu-aarch64 -L /usr/aarch64-linux-gnu) suffix='' ;;
  x86_64-windows) emulator=(wine) suffix=.exe ;;
  *) echo "cross.sh: aarch64-linux or x86_64-windows, not '$target'" >&2; exit 2 ;;
esac
# Wine's files lie here and not in the home folder; of the 32 bit half that it misses it says nothing.
export WINEPREFIX=$root/build/cross/wine WINEDEBUG=-all

bash bindings/web/fetch-sources.sh build/web_sources >&2
cmake --preset release -B "build/cross/$target" -DCMAKE_TOOLCHAIN_FILE="$root/cmake/cross/$target.cmake" \
  -DCMAKE_MODULE_PATH="$root/bindings/web/cmake" -DTANDEM_WEB_SOURCES="$root/build/web_sources" \
  -DEigen3_DIR=/usr/share/eigen3/cmake -DTANDEM_BUILD_OBJ=OFF -DTANDEM_BUILD_SCENE_FILES=OFF \
  -DTANDEM_BUILD_NET=OFF -DTANDEM_BUILD_C=OFF -DTANDEM_BUILD_TESTS=OFF >/dev/null
cmake --build "build/cross/$target" --target determinism >/dev/null
"${emulator[@]}" "build/cross/$target/bin/determinism$suffix" "$@" | tr -d '\r'
