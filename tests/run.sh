#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# Sets everything up, builds Release and runs the tests. Further arguments go to ctest.
#   tests/run.sh                             all tests, here
#   tests/run.sh -R pbd                      those whose names match
#   tests/run.sh --platform windows|arm64    all tests that run on an emulator (docs/platforms.md)
#   tests/run.sh --platform libcxx           all tests here, by clang with libc++
#   tests/run.sh --platform arm64 --quick    half of the platform's test programs, those that take least to build and to
#                                            run, and a session of all platforms
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

platform=native
if [[ ${1-} == --platform ]]; then
  platform=${2-}
  shift 2 || true
fi
# More than half of a platform's programs: what is the systems' own (threads, sockets, files, numbers as text, bytes from
# others, C). The rest take most of the time to build, or minutes to run on qemu (docs/platforms.md).
half=(
  pbd_threads_test pbd_allocation_test collision_threads_test scene_files_test obj_test net_test
  c_test c_session_test c_files_test room_test
  mutate_{clock_exchange,channels_read,decode_channels,decode_handshake,decode_packet,membership,node_sequence}
  mutate_{tcp_frames,trace_read}
)
quick=()
case $platform in
  native) preset=release target='' ;;
  windows) preset=windows target=x86_64-windows ;;
  arm64) preset=arm64 target=aarch64-linux ;;
  libcxx) preset=libcxx target=libcxx ;;
  *) echo "run.sh: --platform windows, arm64 or libcxx, not '$platform'" >&2; exit 2 ;;
esac
if [[ -n $target && ${1-} == --quick ]]; then
  shift
  quick=("${half[@]}")
  names=$(IFS='|' && echo "${quick[*]}")
  set -- -R "^($names|cross_session)$" "$@"
  [[ $platform == libcxx ]] || quick+=(cubes tandem-key tandem-replay tandem-room-peer)
fi

if [[ -z $target ]]; then
  bash cmake/install-deps.sh
else
  bash cmake/install-deps.sh --with-cross
  bash cmake/cross/sysroot.sh "$target"
fi
cmake --preset "$preset"
if [[ ${#quick[@]} -gt 0 ]]; then
  cmake --build --preset "$preset" --target "${quick[@]}"
else
  cmake --build --preset "$preset"
fi
if [[ $platform == windows ]]; then
  # Programs that are the first in a new prefix at once get in each other's way: one server is there before them all.
  export WINEPREFIX=$PWD/build/wine WINEDEBUG=-all
  mkdir -p "$WINEPREFIX"
  wineserver -p60 </dev/null >/dev/null 2>&1  # ends by itself where this is killed
  trap 'wineserver -k || true' EXIT
  wine wineboot --init </dev/null >build/wine.log 2>&1
fi
# Tests in wall time fail if the machine stalls: they get a second try, which shows in what ctest
# prints, and for nothing else.
status=0
ctest --preset "$preset" -LE wall_time "$@" || status=1
ctest --preset "$preset" -L wall_time --repeat until-pass:2 "$@" || status=1
exit $status
