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
  aarch64-linux) preset=arm64 emulator=(qemu-aarch64 -L /usr/aarch64-linux-gnu) suffix='' ;;
  x86_64-windows) preset=windows emulator=(wine) suffix=.exe ;;
  *) echo "cross.sh: aarch64-linux or x86_64-windows, not '$target'" >&2; exit 2 ;;
esac
# Wine's files lie here and not in the home folder; of the 32 bit half that it misses it says nothing.
export WINEPREFIX=$root/build/wine WINEDEBUG=-all

bash cmake/cross/sysroot.sh "$target"
cmake --preset "$preset" >/dev/null
cmake --build --preset "$preset" --target determinism >/dev/null
"${emulator[@]}" "build/$preset/bin/determinism$suffix" "$@" | tr -d '\r'
