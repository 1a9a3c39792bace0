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
# What happens in wall time fails where the machine stalls: there is a second try for it, which shows
# in what ctest prints, and for nothing else.
status=0
ctest --preset release -LE wall_time "$@" || status=1
ctest --preset release -L wall_time --repeat until-pass:2 "$@" || status=1
exit $status
