#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# Drives the page of the live view with a headless Chromium: against a mock server, and against the
# demos in a folder where one is named. Ends with 77 (skipped) where it lacks what it needs.
#   tests/view/run.sh [--bin build/release/bin]
set -euo pipefail
bin=
if [[ ${1:-} == --bin ]]; then
  bin=$(cd "$2" && pwd)
  shift 2
fi
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)

name=tests/view
source "$here/needs.sh"
npm_modules "$here" "$here/../../demos/view/page"

tests=("$here/protocol_test.mjs" "$here/timeline_test.mjs" "$here/page_test.mjs")
if [[ -n $bin ]]; then
  [[ -x $bin/cubes ]] || { echo "tests/view: $bin/cubes is not there" >&2; exit 1; }
  export TANDEM_BIN=$bin
  tests+=("$here/session_test.mjs")
  # Only where scene files can be read.
  [[ ! -x $bin/scene_view ]] || tests+=("$here/scene_view_test.mjs")
fi
# One after another: each has a browser that draws in software.
exec node --test --test-concurrency=1 "$@" "${tests[@]}"
