#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# tandem-room serves a page: it prints a link whose token lets in, and what it then sends is the page and its module.
#   tests/package/room.sh TANDEM_ROOM [ARCHIVE]   the page that is installed with it, or that of a release's archive, which
#                                                 is put where an installed one would be
set -euo pipefail
program=$1
scratch=$(mktemp -d)
source "$(dirname "${BASH_SOURCE[0]}")/timing.sh"
server=
trap '[[ -z $server ]] || kill "$server"; rm -rf "$scratch"' EXIT

fail() {
  echo "room: $*" >&2
  exit 1
}

begin
if [[ $# -gt 1 ]]; then
  page=$scratch/share/tandem/room
  mkdir -p "$page" "$scratch/bin"
  tar -C "$page" --strip-components 1 -xzf "$2"
  [[ -s $page/LICENSE && -s $page/NOTICES.txt ]] || fail "there are no licences in $2"
  cp "$program" "$scratch/bin"
  program=$scratch/bin/$(basename "$program")
fi
"$program" >"$scratch/link" 2>"$scratch/log" </dev/null &
server=$!
for _ in {1..100}; do
  [[ ! -s $scratch/link ]] || break
  kill -0 "$server" 2>/dev/null || { server=; cat "$scratch/log" >&2; fail "the server has ended"; }
  sleep 0.1
done
link=$(<"$scratch/link")
address=${link%%\?*}
python3 - "$address" <<'PYTHON' || fail "the page is not served at $address"
import gzip, sys, urllib.error, urllib.request

def get(url):
    with urllib.request.urlopen(urllib.request.Request(url, headers={"Accept-Encoding": "gzip"})) as answer:
        body = answer.read()
        return gzip.decompress(body) if answer.headers.get("Content-Encoding") == "gzip" else body

address = sys.argv[1]
assert b"<html" in get(address).lower()
assert get(address + "tandem.wasm")[:4] == b"\0asm"
try:
    get(address.rsplit("/", 2)[0] + "/" + "0" * 32 + "/")
    sys.exit("who has not the token gets in")
except urllib.error.HTTPError as error:
    assert error.code == 404, error
PYTHON
took "room, from start to page"
