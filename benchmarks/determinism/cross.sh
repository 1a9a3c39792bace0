#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# Builds pbd, collision and the program `determinism` for other processors and systems and runs them on an emulator;
# compares their hashes with those of g++ here.
#   benchmarks/determinism/cross.sh aarch64-linux|x86_64-windows [what determinism takes: scenes, --steps N]
# Needs g++-aarch64-linux-gnu and qemu-user, or g++-mingw-w64-x86-64-posix and wine64.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
root=$PWD
target=$1
shift

case $target in
  aarch64-linux) emulator=(qemu-aarch64 -L /usr/aarch64-linux-gnu) suffix='' ;;
  x86_64-windows) emulator=(wine64) suffix=.exe ;;
  *) echo "cross.sh: aarch64-linux or x86_64-windows, not '$target'" >&2; exit 2 ;;
esac

bash bindings/web/fetch-sources.sh build/web_sources
cmake --preset release -B build/native >/dev/null
cmake --build build/native --target determinism >/dev/null
cmake --preset release -B "build/cross/$target" -DCMAKE_TOOLCHAIN_FILE="$root/cmake/cross/$target.cmake" \
  -DCMAKE_MODULE_PATH="$root/bindings/web/cmake" -DTANDEM_WEB_SOURCES="$root/build/web_sources" \
  -DEigen3_DIR=/usr/share/eigen3/cmake -DTANDEM_BUILD_OBJ=OFF -DTANDEM_BUILD_SCENE_FILES=OFF \
  -DTANDEM_BUILD_NET=OFF -DTANDEM_BUILD_C=OFF -DTANDEM_BUILD_TESTS=OFF >/dev/null
cmake --build "build/cross/$target" --target determinism

diff <(build/native/bin/determinism "$@") \
  <("${emulator[@]}" "build/cross/$target/bin/determinism$suffix" "$@" | tr -d '\r')
echo "$target: the same hashes"
