#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# tandem-cluster: tests/mpi/program.sh BIN. Equal runs, a rank by itself, a rank that dies and what
# goes on after it. Exits with 77 where there is no mpirun.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/skip.sh"
bin=$1

# hash NAME FILE: a field of what rank 0 has told.
hash() { sed -nE "s/.*\"$1\": \"([0-9]+)\".*/\1/p" "$2" | tail -1; }
fail() {
  echo "$*" >&2
  exit 1
}
common=(cliff --size 300 --sample-every 0)

run 3 "$bin/tandem-cluster" "${common[@]}" --seconds 2 >"$folder/a"
run 3 "$bin/tandem-cluster" "${common[@]}" --seconds 2 --record "$folder/tape" >"$folder/b"
[[ $(hash last_hash "$folder/a") == "$(hash last_hash "$folder/b")" ]] || fail "equal runs differ"
for rank in 0 1 2; do
  "$bin/tandem-cluster" "${common[@]}" --seconds 2 --replay "$folder/tape.$rank" >"$folder/c"
  [[ $(hash last_hash "$folder/c") == "$(hash last_hash "$folder/a")" ]] ||
    fail "rank $rank by itself comes to other bits"
done
echo "three ranks, twice and each by itself: $(hash last_hash "$folder/a")"

# A rank dies in the middle: the run ends, with a word, and the last checkpoint is whole.
if run 3 "$bin/tandem-cluster" "${common[@]}" --seconds 3 --checkpoint "$folder/save" \
  --checkpoint-every 60 --die 1:100 >"$folder/d" 2>"$folder/why"; then
  fail "a run without one of its ranks has gone on"
fi
grep -q "save has step 60" "$folder/why" || fail "no checkpoint: $(cat "$folder/why")"
grep -qE "rank +1|\[1\]|exit code|non-zero" "$folder/why" || fail "no word: $(cat "$folder/why")"
grep -E "Exit code|Process name|exited" "$folder/why" || true
run 3 "$bin/tandem-cluster" "${common[@]}" --seconds 1 >"$folder/e"
for ranks in 1 2 4; do
  run "$ranks" "$bin/tandem-cluster" "${common[@]}" --seconds 3 --resume "$folder/save" >"$folder/f"
  [[ $(hash first_hash "$folder/f") == "$(hash last_hash "$folder/e")" ]] ||
    fail "$ranks ranks do not go on from where step 60 was"
  echo "gone on from step 60 on $ranks ranks: $(hash last_hash "$folder/f")"
done
