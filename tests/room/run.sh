#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# Drives rooms with a headless Chromium: pages, native peers and servers. Ends with 77 (skipped) where it lacks
# what it needs.
#   tests/room/run.sh [--bin build/room/bin] [--page build/web/room]
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
export TANDEM_BIN=$here/../../build/room/bin TANDEM_ROOM_PAGE=$here/../../build/web/room
while [[ $# -ge 2 ]]; do
  case $1 in
    --bin) TANDEM_BIN=$(cd "$2" && pwd) ;;
    --page) TANDEM_ROOM_PAGE=$(cd "$2" && pwd) ;;
    *) break ;;
  esac
  shift 2
done

name=tests/room
source "$here/../view/needs.sh"
[[ -x $TANDEM_BIN/tandem-room ]] || { echo "tests/room: $TANDEM_BIN/tandem-room is not there" >&2; exit 1; }
[[ -f $TANDEM_ROOM_PAGE/index.html.gz ]] || skip "no page in $TANDEM_ROOM_PAGE (preset web, tandem_room_page)"
# The browser's driver is that of the live view's tests.
npm_modules "$here/../view"
# Browsers and peers in wall time: where the machine stalls there is a second try for a file.
status=0
for name in qr parts recorder room xr systems; do
  for try in 1 2; do
    node --test --test-concurrency=1 "$@" "$here/${name}_test.mjs" && break
    [[ $try -eq 1 ]] || status=1
  done
done
exit $status
