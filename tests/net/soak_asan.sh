#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# A mesh of tandem-peers that fidget for 15 minutes, at profile 3 and with 5 % loss, built with the
# address and undefined behaviour sanitizers:
#   tests/net/soak_asan.sh [MINUTES [PEERS]]
# Exits with 1 where benchmarks/soak.py does, or where a sanitizer reports anything.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
minutes=${1:-15}
peers=${2:-4}
build=$root/build/soak-asan

cmake -S "$root" -B "$build" -G Ninja -DCMAKE_CXX_COMPILER=clang++ -DCMAKE_BUILD_TYPE=Debug \
  -DCMAKE_CXX_FLAGS_DEBUG=-O1 -DCMAKE_UNITY_BUILD=ON -DCMAKE_UNITY_BUILD_BATCH_SIZE=12 \
  "-DTANDEM_SANITIZE=address;undefined" -DTANDEM_CHECK_HEADERS=OFF -DTANDEM_BUILD_BENCHMARKS=OFF \
  -DTANDEM_BUILD_TESTS=OFF
cmake --build "$build" --target tandem-peer tandem-key proxy

reports=$build/reports
rm -rf "$reports"
mkdir -p "$reports"
# A small quarantine and short records of stacks: what the sanitizer keeps is no leak of ours. It
# still grows by 3 MiB in 8 minutes, in which the release build's bytes in use do not
# (benchmarks/soak.py build/release/bin judges those).
export ASAN_OPTIONS=log_path=$reports/asan:quarantine_size_mb=1:malloc_context_size=1:detect_leaks=1
export UBSAN_OPTIONS=log_path=$reports/ubsan:print_stacktrace=1
python3 "$root/benchmarks/soak.py" "$build/bin" --minutes "$minutes" --peers "$peers" --profile 3 \
  --loss 0.05 --growth 8
if compgen -G "$reports/*" >/dev/null; then
  cat "$reports"/*
  exit 1
fi
echo "no reports"
