#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# The Unity package's library for one system, in build/csharp_SYSTEM. It needs only that system's C
# library:
#   bindings/csharp/build.sh linux-x86_64|linux-arm64|windows-x86_64
# FCL, libccd and libsodium are inside. Needs what cmake/install-deps.sh --with-cross installs.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
system=${1-}

options=(
  -DTANDEM_BUILD_CSHARP=ON -DTANDEM_BUILD_TESTS=OFF -DTANDEM_BUILD_DEMOS=OFF -DTANDEM_BUILD_BENCHMARKS=OFF
  -DTANDEM_BUILD_ROOM=OFF -DTANDEM_BUILD_OBJ=OFF -DCMAKE_POSITION_INDEPENDENT_CODE=ON
  -DCMAKE_SHARED_LINKER_FLAGS="-static-libstdc++ -static-libgcc"
)
case $system in
  linux-x86_64)
    preset=release
    bash bindings/web/fetch-sources.sh build/web_sources >&2
    options+=(-DCMAKE_MODULE_PATH="$PWD/bindings/web/cmake" -DTANDEM_WEB_SOURCES="$PWD/build/web_sources"
      -Dpkgcfg_lib_SODIUM_sodium="$(gcc -print-file-name=libsodium.a)")
    ;;
  linux-arm64)
    preset=arm64
    bash cmake/cross/sysroot.sh aarch64-linux
    ;;
  windows-x86_64)
    preset=windows
    bash cmake/cross/sysroot.sh x86_64-windows
    ;;
  *) echo "usage: build.sh linux-x86_64|linux-arm64|windows-x86_64" >&2; exit 2 ;;
esac

cmake --preset "$preset" -B "build/csharp_$system" "${options[@]}" >/dev/null
cmake --build "build/csharp_$system" --target tandem_csharp
