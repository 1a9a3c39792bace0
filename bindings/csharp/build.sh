#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# What the package for Unity has for one system, in build/csharp_SYSTEM, wanting no libraries of that system's but C's:
#   bindings/csharp/build.sh linux-x86_64|linux-arm64|windows-x86_64
# FCL, libccd and on the first libsodium are inside. The others are cross-built, without sessions and scene files.
# Needs what cmake/install-deps.sh --with-cross installs.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
system=${1-}

options=(
  -DTANDEM_BUILD_CSHARP=ON -DTANDEM_BUILD_TESTS=OFF -DTANDEM_BUILD_DEMOS=OFF -DTANDEM_BUILD_BENCHMARKS=OFF
  -DTANDEM_BUILD_OBJ=OFF -DCMAKE_POSITION_INDEPENDENT_CODE=ON
  -DCMAKE_MODULE_PATH="$PWD/bindings/web/cmake" -DTANDEM_WEB_SOURCES="$PWD/build/web_sources"
  -DCMAKE_SHARED_LINKER_FLAGS="-static-libstdc++ -static-libgcc"
)
cross=(-DEigen3_DIR=/usr/share/eigen3/cmake -DTANDEM_BUILD_NET=OFF -DTANDEM_BUILD_SCENE_FILES=OFF)
case $system in
  linux-x86_64) options+=(-Dpkgcfg_lib_SODIUM_sodium="$(gcc -print-file-name=libsodium.a)") ;;
  linux-arm64) options+=("${cross[@]}" -DCMAKE_TOOLCHAIN_FILE="$PWD/cmake/cross/aarch64-linux.cmake") ;;
  windows-x86_64) options+=("${cross[@]}" -DCMAKE_TOOLCHAIN_FILE="$PWD/cmake/cross/x86_64-windows.cmake") ;;
  *) echo "usage: build.sh linux-x86_64|linux-arm64|windows-x86_64" >&2; exit 2 ;;
esac

bash bindings/web/fetch-sources.sh build/web_sources >&2
cmake --preset release -B "build/csharp_$system" "${options[@]}" >/dev/null
cmake --build "build/csharp_$system" --target tandem_csharp
