#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# All fuzz targets on libFuzzer, with the address and undefined behaviour sanitizers, from the kept
# corpus on:
#   tests/fuzz/nightly.sh [SECONDS [--keep [TARGET...]]]
# SECONDS for each target, 1200 where nothing is said; all targets where none is.
# What reaches code that the corpus does not is left, minimised, in build/fuzz/corpus; `--keep` as a
# second argument replaces tests/fuzz/corpus by it, of each target the smallest 32 inputs of at most
# 1 KiB. Exits with 1 where any target found a fault; its input is then in build/fuzz/faults.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
seconds=${1:-1200}
keep=${2:-}
build=$root/build/fuzz
targets=(clock_exchange channels_read decode_channels decode_handshake decode_packet membership
         node_sequence tcp_frames trace_read)
[[ $# -lt 3 ]] || targets=("${@:3}")

# Without the collision module there are no demos, and trace_read is theirs.
cmake -S "$root" -B "$build" -G Ninja -DCMAKE_CXX_COMPILER=clang++ -DCMAKE_BUILD_TYPE=Release \
  -DTANDEM_FUZZ=ON -DTANDEM_BUILD_BENCHMARKS=OFF -DTANDEM_CHECK_HEADERS=OFF \
  -DCMAKE_UNITY_BUILD=ON "-DTANDEM_SANITIZE=address;undefined;fuzzer-no-link" \
  ${TANDEM_FUZZ_FLAGS:-}
mkdir -p "$build/faults"
failed=()
for target in "${targets[@]}"; do
  if ! cmake --build "$build" --target "mutate_$target" "fuzz_$target"; then
    failed+=("$target (does not build)")
    continue
  fi
  found=$build/corpus/$target
  small=$build/small/$target
  rm -rf "$small"
  mkdir -p "$found" "$small"
  "$build/bin/mutate_$target" --write-seeds="$found"
  kept=$root/tests/fuzz/corpus/$target
  [[ ! -d $kept ]] || cp "$kept"/* "$found/"
  "$build/bin/fuzz_$target" -max_total_time="$seconds" -max_len=4096 -timeout=20 \
    -artifact_prefix="$build/faults/$target-" -print_final_stats=1 "$found" || failed+=("$target")
  "$build/bin/fuzz_$target" -merge=1 -max_len=1024 "$small" "$found" || failed+=("$target")
  if [[ $keep == --keep ]]; then
    rm -rf "$kept"
    mkdir -p "$kept"
    (cd "$small" && find . -type f -printf '%s %f\n' | sort -n | head -32 | cut -d' ' -f2 |
      xargs -r cp -t "$kept")
  fi
done
if [[ ${#failed[@]} -gt 0 ]]; then
  printf 'FAILED: %s\n' "${failed[@]}"
  exit 1
fi
echo "no faults"
