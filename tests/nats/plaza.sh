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

# One square all over the server, another on which the near speak by UDP.
declare -A plaza
for direct in 0 16; do
  "$bin/plaza" --server "$address" --people 16 --density 16 --seconds 13 --seed "$((1 + direct))" \
    --direct "$direct" --json "$folder/out$direct" 2>"$folder/said$direct" &
  plaza[$direct]=$!
done
sleep 6
kill -9 "$server"
sleep 2
start "${address##*:}"
for direct in 0 16; do
  wait "${plaza[$direct]}" || { cat "$folder/said$direct"; echo "bodies were lost or found twice"; exit 1; }
  cat "$folder/said$direct" "$folder/out$direct"
  grep -q ALONE "$folder/said$direct" || { echo "the server was not missed"; exit 1; }
  # The last line: everybody has met again.
  tail -1 "$folder/said$direct" | grep -q ' served ' || { echo "not served at the end"; exit 1; }
done
# Within 5 s of the server's return copies are as near as before: by the medians of whole seconds, of which
# the first and the last without a server say which those are. Over UDP they do not come apart meanwhile.
python3 - "$folder" <<'END'
import json, re, statistics, sys
line = re.compile(r" *(-?[0-9.]+) s +(served|ALONE).*moving mm p50 [0-9.]+ p95 ([0-9.]+)")
for direct in 0, 16:
    run = json.load(open(f"{sys.argv[1]}/out{direct}"))
    assert run["connected"] > 0.5, run["connected"]
    assert run["taken"] > 3, run["taken"]
    said = open(f"{sys.argv[1]}/said{direct}")
    seconds = [(float(m[1]), m[2], float(m[3])) for m in map(line.match, said) if m]
    alone = [end for end, state, _ in seconds if state == "ALONE"]
    before = [p95 for end, _, p95 in seconds if end < alone[0]]
    apart = [p95 for end, _, p95 in seconds if alone[0] <= end <= alone[-1] + 1.0]
    after = [p95 for end, _, p95 in seconds if end >= alone[-1] + 6.0]
    print(f"direct {direct}: p95 mm: before {before}, without a server {apart}, after {after}")
    if direct:
        assert run["direct"] > 0.7 * run["connected"], run["direct"]
        assert max(apart) < 100.0, "the near lost sight of each other"
    else:
        assert max(apart) > 100.0, "nobody lost sight of anybody"
    assert len(after) >= 3, "too short"
    assert statistics.median(after) < max(25.0, 2.0 * statistics.median(before))
END
