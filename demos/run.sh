#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# Sets everything up, builds Release and runs the cubes demo with the given arguments:
#   demos/run.sh --profile 3 --seconds 20
# Results go to standard output; what the build says goes to standard error.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

bash "$root/cmake/install-deps.sh" >&2
(
  cd "$root"
  cmake --preset release >&2
  cmake --build --preset release --target cubes >&2
)
exec "$root/build/release/bin/cubes" "$@"
