#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# Brings the libraries that Tandem needs for another processor, system or standard library: libsodium built from
# Debian's source, and links to the headers that are the same everywhere. FCL and libccd are built with Tandem, from
# their sources. For libc++ libsodium is the machine's own, which is in C.
#   cmake/cross/sysroot.sh aarch64-linux|x86_64-windows|libcxx
# They go to build/sysroot/TARGET, the sources to build/web_sources. Needs what cmake/install-deps.sh --with-cross
# installs; what is there stays.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
target=${1-}
case $target in
  aarch64-linux) host=aarch64-linux-gnu ;;
  x86_64-windows) host=x86_64-w64-mingw32 ;;
  libcxx) ;;
  *) echo "sysroot.sh: aarch64-linux, x86_64-windows or libcxx, not '$target'" >&2; exit 2 ;;
esac

bash bindings/web/fetch-sources.sh build/web_sources >&2
sysroot=$PWD/build/sysroot/$target
if [[ $sysroot == *[[:space:]]* ]]; then
  echo "sysroot.sh: libsodium cannot be built below a folder with white space in its name: $sysroot" >&2
  exit 1
fi
mkdir -p "$sysroot/include" "$sysroot/lib/pkgconfig"
# Compilers for other systems must not see the C library's headers, which lie beside these.
for header in asio asio.hpp boost catch2 nlohmann tiny_gltf.h \
  tiny_obj_loader.h toml++ xsimd; do
  [[ ! -e /usr/include/$header ]] || ln -sfn "/usr/include/$header" "$sysroot/include/$header"
done
cat >"$sysroot/lib/pkgconfig/tomlplusplus.pc" <<PC
Name: tomlplusplus
Description: TOML for C++
Version: $(pkg-config --modversion tomlplusplus)
Cflags: -I$sysroot/include
PC

if [[ $target == libcxx ]]; then
  ln -sfn /usr/include/sodium{,.h} "$sysroot/include"
  ln -sfn "$(pkg-config --variable=libdir libsodium)/libsodium.a" "$sysroot/lib"
  sed "s|^prefix=.*|prefix=$sysroot|; s|^libdir=.*|libdir=$sysroot/lib|; s|^includedir=.*|includedir=$sysroot/include|" \
    "$(pkg-config --variable=pcfiledir libsodium)/libsodium.pc" >"$sysroot/lib/pkgconfig/libsodium.pc"
  exit
fi
# Its last file, with the folder in it.
! grep -qsxF "prefix=$sysroot" "$sysroot/lib/pkgconfig/libsodium.pc" || exit 0
build=$(mktemp -d)
trap 'rm -rf "$build"' EXIT
# The thread model of the compiler that has std::thread.
compiler=$host-gcc
[[ $target != x86_64-windows ]] || compiler=$host-gcc-posix
cp -r build/web_sources/libsodium "$build/source"
cd "$build/source"
{
  autoreconf -if &&
  ./configure --host="$host" CC="$compiler" --prefix="$sysroot" --disable-shared --enable-static --with-pic &&
  make -j"${CMAKE_BUILD_PARALLEL_LEVEL:-2}" -C src &&
  make -C src install &&
  make install-pkgconfigDATA
} >"$build/log" 2>&1 </dev/null || { tail -30 "$build/log" >&2; exit 1; }
