#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# Measures everything and writes docs/numerics.md with its figure.
#   benchmarks/measure.sh <folder of the programs> <folder for the files> [options of run.py]
#   benchmarks/measure.sh build/release/bin results --quick
set -euo pipefail
[[ $# -ge 2 ]] || {
  sed -n '6,8s/^# //p' "$0" >&2
  exit 2
}
here=$(cd "$(dirname "$0")" && pwd)
binaries=$1
out=$2
shift 2
export PYTHONDONTWRITEBYTECODE=1

# The first Python with matplotlib; without one there are no plots.
python=python3
for candidate in python3 /usr/bin/python3; do
  if "$candidate" -c 'import matplotlib, scour' 2>/dev/null; then
    python=$candidate
    break
  fi
done

mkdir -p "$out"
# Exit code 1 means a failed bound, which belongs in the report.
"$binaries/numerics" --csv "$out/numerics.csv" >"$out/numerics.txt" || [[ $? -eq 1 ]]
tail -n 1 "$out/numerics.txt"
"$binaries/everyday" --json "$out/everyday.json" >"$out/everyday.txt" 2>"$out/everyday.log" || [[ $? -eq 1 ]]
tail -n 1 "$out/everyday.log"
for engine in bullet64 jolt box3d physx_pgs physx_tgs; do
  # An engine that this build lacks is refused.
  "$binaries/everyday" --engine $engine --json "$out/everyday_$engine.json" >"$out/everyday_$engine.txt" \
    2>"$out/everyday_$engine.log" || rm -f "$out/everyday_$engine.json"
done
if [[ -x $binaries/kernels ]]; then
  "$binaries/kernels" --benchmark_format=json >"$out/kernels.json" 2>/dev/null
fi
"$python" "$here/work_precision/run.py" "$binaries" --out "$out" "$@"
"$python" "$here/numerics_report.py" "$out"
