#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# One session of processes of different systems on this machine: the demo `cubes` over UDP, encrypted, with user A at
# the first and user B at the second. What one lifts is lifted at all, at rest 19 of 20 samples of all are within 1 mm, and what the
# second went through runs again at the first, bit for bit.
#   tests/cross/session.sh FOLDER..    of programs: build/release/bin, build/windows/bin, build/arm64/bin
# Folders that are not there are left out; one alone is taken twice. They are not built here: old ones may not agree. Exits with 77 where nothing is there.
set -euo pipefail
# Names of files with letters of all kinds must do on all systems.
export LC_ALL=C.UTF-8
# Not in the home folder.
export WINEPREFIX=${WINEPREFIX:-$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)/build/wine} WINEDEBUG=-all

folder=$(mktemp -d)
trap 'kill $(jobs -p) 2>/dev/null || true; rm -rf "$folder"' EXIT

# Sets `run` to the command that runs a program of a folder.
runner() {
  if [[ -f $1/$2.exe ]]; then
    run=(wine "$1/$2.exe")
  elif [[ $(od -An -tx1 -j18 -N2 "$1/$2") == ' b7 00' ]]; then  # the machine of an ELF file: AArch64
    run=(qemu-aarch64 -L /usr/aarch64-linux-gnu "$1/$2")
  else
    run=("$1/$2")
  fi
}

bins=()
for bin in "$@"; do
  [[ ! -f $bin/cubes && ! -f $bin/cubes.exe ]] || bins+=("$bin")
done
if [[ ${#bins[@]} -eq 0 ]]; then
  echo "session.sh: no cubes in $*" >&2
  exit 77
fi
[[ ${#bins[@]} -gt 1 ]] || bins+=("${bins[0]}")

runner "${bins[0]}" tandem-key
(umask 077 && "${run[@]}" | tr -d '\r' >"$folder/key")
port=$((20000 + $$ % 10000))
common=(--key "$folder/key" --seconds 14 --wait 60 --print nothing)
peer=0
for bin in "${bins[@]}"; do
  peer=$((peer + 1))
  way=(--connect "127.0.0.1:$port")
  [[ $peer -ne 1 ]] || way=(--listen "$port")
  [[ $peer -ne 2 ]] || way+=(--trace "$folder/trace")
  runner "$bin" cubes
  "${run[@]}" "${way[@]}" --peer-id "$peer" "${common[@]}" --json "$folder/größe_$peer.json" &
done

status=0
for job in $(jobs -p); do
  wait "$job" || { status=1; echo "session.sh: a process ended with an error" >&2; }
done
python3 - "$folder" "${bins[@]}" <<'PYTHON' || status=1
import json, sys

folder, bins = sys.argv[1], sys.argv[2:]
wrong = False
for peer, where in enumerate(bins, 1):
    result = json.load(open(f"{folder}/größe_{peer}.json"))
    resting, moving = result["divergence_resting_m"], result["divergence_moving_m"]
    lifted = result["outcome"][f"peer_{peer}"]["plate_lifted_m"]
    print(f"{where}: apart at rest {1e3 * resting['p50']:.4f} mm (p95 {1e3 * resting['p95']:.3f}), "
          f"moving {1e3 * moving['p50']:.2f} mm ({moving['count']} samples), lifted {lifted:.2f} m")
    # An emulated process makes as many steps as the machine has time for: a share of its samples, not a number.
    wrong |= resting["p95"] > 1e-3 or moving["count"] < 0.03 * (moving["count"] + resting["count"]) or lifted < 0.15
sys.exit(wrong)
PYTHON
runner "${bins[0]}" tandem-replay
"${run[@]}" "$folder/trace" || status=1
exit $status
