#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# A wheel that wants no libraries of the system's but C's; prints its path:
#   bindings/python/build_wheel.sh FOLDER [CMAKE_OPTION...]
# FCL, libccd, libsodium and nlohmann_json are inside, with their licences. For the interpreter that CMake finds, and the C library
# that is here or newer. Needs what cmake/install-deps.sh --with-python installs, and dpkg-dev.
set -euo pipefail
[[ $# -ge 1 ]] || { echo "usage: build_wheel.sh FOLDER [CMAKE_OPTION...]" >&2; exit 2; }
folder=$(realpath -m "$1")
shift
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
build=build/python_wheel

bash bindings/web/fetch-sources.sh build/web_sources >&2
cmake --preset release -B "$build" -DTANDEM_BUILD_PYTHON=ON -DTANDEM_BUILD_C=OFF -DTANDEM_BUILD_OBJ=OFF \
  -DTANDEM_BUILD_DEMOS=OFF -DTANDEM_BUILD_BENCHMARKS=OFF -DTANDEM_BUILD_TESTS=OFF \
  -DCMAKE_POSITION_INDEPENDENT_CODE=ON -DCMAKE_MODULE_LINKER_FLAGS="-static-libstdc++ -static-libgcc -s" \
  -DCMAKE_MODULE_PATH="$PWD/bindings/web/cmake" -DTANDEM_WEB_SOURCES="$PWD/build/web_sources" \
  -Dpkgcfg_lib_SODIUM_sodium="$(gcc -print-file-name=libsodium.a)" "$@" >&2
cmake --build "$build" --target tandem_python >&2

# cached NAME: what CMake has in its cache under that name.
cached() {
  sed -n "s/^$1:[A-Z]*=//p" "$build/CMakeCache.txt"
}
licenses=$build/licenses
rm -rf "$licenses"
mkdir "$licenses"
cp LICENSE "$licenses"
for package in fcl ccd sodium eigen3 xsimd asio; do
  cp "/usr/share/doc/lib$package-dev/copyright" "$licenses/$package"
done
cp /usr/share/doc/pybind11-dev/copyright "$licenses/pybind11"
cp /usr/share/doc/nlohmann-json3-dev/copyright "$licenses/nlohmann_json"
"$(cached Python_EXECUTABLE)" bindings/python/make_wheel.py "$build/python/tandem" "$(cached CMAKE_PROJECT_VERSION)" \
  "$folder" "$licenses"
