#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# Sets everything up, builds Release and runs a demo (cubes, cliff, piano, pile, room or tennis; the
# first where none is named) with the given arguments:
#   demos/run.sh --profile 3 --seconds 20
#   demos/run.sh tennis --profile 5
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
build "$demo"
exec "$root/build/release/bin/$demo" "$@"
