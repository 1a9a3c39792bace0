#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# Each way to get Tandem, from an empty folder and a package to a cube that falls and lies on the ground, and what it
# takes a user. The checks are those of the stages of .ci/run; what they need is built where it is missing.
#   tests/package/from_nothing.sh [WAY...]   libraries (find_package, pkg-config, FetchContent), deb, wheel, npm,
#                                            windows, room
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
build=$here/../../build
ways=("$@")
[[ $# -gt 0 ]] || ways=(libraries deb wheel npm windows room)
log=$(mktemp)
trap 'rm -f "$log"' EXIT
failed=0
for way in "${ways[@]}"; do
  case $way in
    libraries) command=("$here/run.sh") ;;
    deb | wheel | npm | windows) command=("$here/$way.sh") ;;
    room) command=("$here/room.sh" "$build/shared/bin/tandem-room" "$build"/web/tandem-room-page-*.tar.gz) ;;
    *) echo "from_nothing.sh: there is no way '$way'" >&2; exit 2 ;;
  esac
  status=0
  bash "${command[@]}" >"$log" 2>&1 || status=$?
  case $status in
    0) grep '^from nothing: ' "$log" ;;
    77) grep SKIPPED "$log" ;;
    *) cat "$log"; echo "from nothing: $way: FAILED"; failed=1 ;;
  esac
done
exit $failed
