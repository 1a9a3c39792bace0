#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# Builds pbd, collision and `determinism` for another processor, system or standard library, runs it, on an emulator if
# necessary, and prints its lines for table.sh --cross.
#   benchmarks/determinism/cross.sh aarch64-linux|x86_64-windows|libcxx [arguments of determinism]
# Needs the packages of cmake/install-deps.sh --with-cross.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
root=$PWD
target=$1
shift

case $target in
  aarch64-linux) preset=arm64 emulator=(qemu-aarch64 -L /usr/aarch64-linux-gnu) suffix='' ;;
  x86_64-windows) preset=windows emulator=(wine) suffix=.exe ;;
  libcxx) preset=libcxx emulator=() suffix='' ;;
  *) echo "cross.sh: aarch64-linux, x86_64-windows or libcxx, not '$target'" >&2; exit 2 ;;
esac
# Wine's files go here instead of the home folder; silence about its missing 32 bit half.
export WINEPREFIX=$root/build/wine WINEDEBUG=-all
mkdir -p "$WINEPREFIX"

bash cmake/cross/sysroot.sh "$target"
cmake --preset "$preset" >/dev/null
cmake --build --preset "$preset" --target determinism >/dev/null
said=$(mktemp)
trap 'rm -f "$said"' EXIT
# Not by a pipe, which wine's services would keep open.
"${emulator[@]}" "build/$preset/bin/determinism$suffix" "$@" >"$said" </dev/null
tr -d '\r' <"$said"
