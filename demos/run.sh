#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# Sets everything up, builds Release and runs a demo (cubes, cliff, piano, pile, room or tennis; the
# first where none is named) with the given arguments:
#   demos/run.sh --profile 3 --seconds 20
#   demos/run.sh tennis --profile 5
# or plaza, a square for very many people over a NATS server, which it starts unless --server names one:
#   demos/run.sh plaza --people 200
# or draws key frames of all of them as PNG (needs Chromium):
#   demos/run.sh --pictures docs/img
# Results go to standard output; what the build says goes to standard error.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

# What the page is built with is not needed without it.
packages=()
for argument in "$@"; do
  [[ $argument != --view* && $argument != --pictures ]] || packages=(--with-view)
done

build() {
  bash "$root/cmake/install-deps.sh" "${packages[@]}" >&2
  (
    cd "$root"
    cmake --preset release >&2
    cmake --build --preset release --target "$@" >&2
  )
}

run_plaza() {
  bash "$root/cmake/install-deps.sh" --with-cluster >&2
  (
    cd "$root"
    cmake --preset release -B build/nats -DTANDEM_WITH_NATS=ON -DTANDEM_BUILD_BENCHMARKS=OFF >&2
    cmake --build build/nats --target plaza >&2
  )
  if [[ " $* " == *" --server"* ]]; then
    "$root/build/nats/bin/plaza" "$@"
    return
  fi
  local folder server address
  folder=$(mktemp -d)
  # Debian has it where no user looks.
  PATH=$PATH:/usr/sbin nats-server -a 127.0.0.1 -p -1 -js -sd "$folder" --ports_file_dir "$folder" \
    2>"$folder/log" &
  server=$!
  trap 'kill '"$server"' 2>/dev/null; wait '"$server"' 2>/dev/null; rm -rf "'"$folder"'"' EXIT
  for _ in {1..100}; do
    address=$(sed -n 's/.*"nats": *\["nats:..\([^"]*\)".*/\1/p' "$folder"/*.ports 2>/dev/null || true)
    [[ -z $address ]] || break
    sleep 0.1
  done
  if [[ -z $address ]]; then
    cat "$folder/log" >&2
    return 1
  fi
  "$root/build/nats/bin/plaza" --server "$address" "$@"
}

if [[ ${1:-} == --pictures ]]; then
  shift
  out=$(realpath -m "${1:-pictures}")
  build cliff cubes piano pile room tennis
  npm --prefix "$root/tests/view" ci --no-audit --no-fund >&2
  TANDEM_BIN=$root/build/release/bin exec node "$root/tests/view/pictures.mjs" \
    "$out" "${@:2}"
fi

demo=cubes
if [[ $# -gt 0 && $1 != -* ]]; then
  demo=$1
  shift
fi
if [[ $demo == plaza ]]; then
  run_plaza "$@"
  exit
fi
build "$demo"
exec "$root/build/release/bin/$demo" "$@"
