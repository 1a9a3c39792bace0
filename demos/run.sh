#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# Sets everything up, builds Release and runs a demo (cubes, cliff, piano, room or tennis; the first
# where none is named) with the given arguments:
#   demos/run.sh --profile 3 --seconds 20
#   demos/run.sh tennis --profile 5
# Results go to standard output; what the build says goes to standard error.
set -euo pipefail
demo=cubes
if [[ $# -gt 0 && $1 != -* ]]; then
  demo=$1
  shift
fi
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

bash "$root/cmake/install-deps.sh" >&2
(
  cd "$root"
  cmake --preset release >&2
  cmake --build --preset release --target "$demo" >&2
)
exec "$root/build/release/bin/$demo" "$@"
