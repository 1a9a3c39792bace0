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

skip() {
  echo "tests/room: skipped: $1" >&2
  exit 77
}
command -v node > /dev/null || skip 'no Node.js (Debian: nodejs, at least 18)'
[[ $(node -p 'process.versions.node.split(".")[0]') -ge 18 ]] || skip 'Node.js is older than 18'
command -v npm > /dev/null || skip 'no npm (Debian: npm)'
if [[ -z ${CHROMIUM:-} ]]; then
  command -v chromium chromium-browser google-chrome > /dev/null || skip 'no Chromium (Debian: chromium)'
fi
[[ -x $TANDEM_BIN/tandem-room ]] || { echo "tests/room: $TANDEM_BIN/tandem-room is not there" >&2; exit 1; }
[[ -f $TANDEM_ROOM_PAGE/index.html.gz ]] || skip "no page in $TANDEM_ROOM_PAGE (preset web, tandem_room_page)"
# The browser's driver is that of the live view's tests.
[[ -d $here/../view/node_modules ]] || npm --prefix "$here/../view" ci --no-audit --no-fund > /dev/null ||
  skip 'npm ci failed in tests/view'
exec node --test --test-concurrency=1 "$@" "$here/qr_test.mjs" "$here/room_test.mjs"
