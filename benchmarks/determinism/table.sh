#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# Builds `determinism` with g++, clang and, if built before (preset web), for WebAssembly, runs all of them and prints
# the table of docs/determinism.md. Exits with 1 if two hashes differ, or the page
# has others.
#   benchmarks/determinism/table.sh [--quick|--cross] [arguments of determinism]
# --quick: without clang
# --cross: also libc++, ARM and Windows, by cross.sh, ten minutes more
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

cross=false
compilers=(g++ clang++)
case ${1-} in
  --cross) cross=true ;;
  --quick) compilers=(g++) ;;
esac
[[ ${1-} != --cross && ${1-} != --quick ]] || shift

for compiler in "${compilers[@]}"; do
  cmake --preset release -B "build/determinism_$compiler" -DCMAKE_CXX_COMPILER=$compiler \
    -DTANDEM_BUILD_TESTS=OFF -DTANDEM_BUILD_DEMOS=OFF -DTANDEM_BUILD_PYTHON=OFF >/dev/null
  cmake --build "build/determinism_$compiler" --target determinism >/dev/null
done

results=$(mktemp -d)
trap 'rm -rf "$results"' EXIT
gcc=build/determinism_g++/bin/determinism
clang=build/determinism_clang++/bin/determinism
"$gcc" --lanes 2 "$@" >"$results/1"
"$gcc" --lanes 4 "$@" >"$results/2"
names="g++, SSE2|g++, AVX2"
if [[ ${compilers[*]} == *clang++ ]]; then
  "$clang" "$@" >"$results/3"
  names+="|clang"
fi
if [[ -f build/web/bin/determinism.js ]]; then
  NODE_PATH=/usr/share/nodejs cmake --build build/web --target determinism >/dev/null
  node build/web/bin/determinism.js "$@" >"$results/4"
  names+="|wasm"
fi
if $cross; then
  benchmarks/determinism/cross.sh libcxx "$@" >"$results/5"
  benchmarks/determinism/cross.sh aarch64-linux "$@" >"$results/6"
  benchmarks/determinism/cross.sh x86_64-windows "$@" >"$results/7"
  names+="|clang 19, libc++|ARM|Windows"
fi

echo "| scene | steps | hash | ${names//|/ | } |"
echo "|---|---|---|$(sed 's/[^|]*|/---|/g; s/[^|]*$/---|/' <<<"$names")"
differ=0
stale=''
while read -r scene steps hash; do
  row="| $scene | $steps | \`$hash\` |"
  for result in "$results"/*; do
    own=$(awk -v scene="$scene" '$1 == scene {print $3}' "$result")
    if [[ $own == "$hash" ]]; then
      row+=" same |"
    else
      row+=" **$own** |"
      differ=1
    fi
  done
  echo "$row"
  if [[ $# -eq 0 ]] && ! grep -qF "| $scene | $steps | \`$hash\` |" docs/determinism.md; then
    stale+=" $scene"
  fi
done <"$results/1"
if [[ -n $stale ]]; then
  echo "docs/determinism.md has other hashes of$stale" >&2
  differ=1
fi
exit $differ
