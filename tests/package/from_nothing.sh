#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# Each way to get Tandem, from an empty folder and a package to a cube that falls and lies on the ground, and what it
# takes a user. The checks are those of the stages of .ci/run; the packages are made first where they are missing.
#   tests/package/from_nothing.sh [WAY...]   libraries (find_package, pkg-config, FetchContent), deb, wheel, npm,
#                                            windows, room
# From a clean clone all of them take two cores half an hour, most of it to make the packages. Says "SKIPPED" of a way
# for which something is missing here, and why; exits with 1 where one fails.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
root=$(cd "$here/../.." && pwd)
cd "$root"
ways=("$@")
[[ $# -gt 0 ]] || ways=(libraries deb wheel npm windows room)
log=$(mktemp)
trap 'rm -f "$log"' EXIT

# web TARGET: by preset web. Emscripten does not go through ccache.
web() {
  bash cmake/install-deps.sh --with-web --with-view
  NODE_PATH=/usr/share/nodejs env -u CMAKE_CXX_COMPILER_LAUNCHER cmake --preset web
  cmake --build --preset web --target "$1"
}
# Builds for another system, or into a package, need sources that cannot be fetched everywhere.
sources() {
  bash cmake/install-deps.sh --with-cross
  bash bindings/web/fetch-sources.sh build/web_sources || {
    echo "SKIPPED: the sources of FCL, libccd and libsodium cannot be fetched here"
    return 77
  }
}

way_libraries() {
  local build=build/release
  bash cmake/install-deps.sh --with-checks
  if [[ ! -f $build/CMakeCache.txt ]]; then
    # Without what is not installed.
    build=build/libraries
    cmake --preset release -B "$build" -DTANDEM_BUILD_TESTS=OFF -DTANDEM_BUILD_BENCHMARKS=OFF
  fi
  bash "$here/run.sh" "$build"
}
way_deb() {
  bash cmake/install-deps.sh
  bash "$here/deb.sh"
}
way_wheel() {
  bash cmake/install-deps.sh --with-python --with-web
  bash "$here/wheel.sh"
}
way_npm() {
  sources
  web tandem_web_package
  bash "$here/npm.sh"
}
way_windows() {
  sources
  bash cmake/cross/sysroot.sh x86_64-windows
  bash "$here/windows.sh"
}
way_room() {
  sources
  web tandem_room_page
  bash cmake/install-deps.sh
  [[ -f build/shared/CMakeCache.txt ]] || cmake --preset shared
  cmake --build --preset shared --target tandem-room
  bash "$here/room.sh" build/shared/bin/tandem-room build/web/tandem-room-page-*.tar.gz
}

for way in "${ways[@]}"; do
  [[ $(type -t "way_$way") == function ]] || {
    echo "from_nothing.sh: there is no way '$way'" >&2
    exit 2
  }
done
failed=0
for way in "${ways[@]}"; do
  status=0
  # In a shell of its own: what is called in a condition goes on after a failure.
  set +e
  (set -e && "way_$way") >"$log" 2>&1
  status=$?
  set -e
  case $status in
    0) grep '^from nothing: ' "$log" ;;
    77) echo "$way: $(grep SKIPPED "$log")" ;;
    *) cat "$log"; echo "from nothing: $way: FAILED"; failed=1 ;;
  esac
done
exit $failed
