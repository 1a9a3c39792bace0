#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# Sets everything up, builds Release and runs the tests. Arguments go to ctest: tests/run.sh -R pbd
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

bash cmake/install-deps.sh
cmake --preset release
cmake --build --preset release
ctest --preset release "$@"
