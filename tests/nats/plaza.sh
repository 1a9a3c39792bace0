#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# People on a square, over a server that is killed among them: nothing is lost, and they agree.
#   tests/nats/plaza.sh BIN
# Ends with 77 where nats-server is not installed.
set -euo pipefail
bin=$1
PATH=$PATH:/usr/sbin
if ! command -v nats-server >/dev/null; then
  echo "SKIPPED: nats-server is not installed (cmake/install-deps.sh --with-cluster)"
  exit 77
fi
folder=$(mktemp -d)
server=
trap 'kill -9 $server 2>/dev/null || true; rm -rf "$folder"' EXIT

start() {
  nats-server -a 127.0.0.1 -p "$1" -js -sd "$folder/store" --ports_file_dir "$folder" 2>>"$folder/log" &
  server=$!
}

start -1
address=
for _ in {1..100}; do
  address=$(sed -n 's/.*"nats": *\["nats:..\([^"]*\)".*/\1/p' "$folder"/*.ports 2>/dev/null || true)
  [[ -z $address ]] || break
  sleep 0.1
done
[[ -n $address ]] || { cat "$folder/log"; exit 1; }

"$bin/plaza" --server "$address" --people 16 --density 16 --seconds 9 --json "$folder/out" 2>"$folder/said" &
plaza=$!
sleep 6
kill -9 "$server"
sleep 2
start "${address##*:}"
wait "$plaza" || { cat "$folder/said"; echo "bodies were lost or found twice"; exit 1; }
cat "$folder/said" "$folder/out"
grep -q ALONE "$folder/said" || { echo "the server was not missed"; exit 1; }
# The last line: everybody has met again.
tail -1 "$folder/said" | grep -q ' served ' || { echo "not served at the end"; exit 1; }
python3 - "$folder/out" <<'END'
import json, sys
run = json.load(open(sys.argv[1]))
assert run["connected"] > 0.5, run["connected"]
assert run["taken"] > 3, run["taken"]
assert run["moving_mm"]["p50"] < 20.0, run["moving_mm"]
END
