#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# The cases of cluster_test on a number of ranks: tests/mpi/ranks.sh BIN RANKS. Exits with 77 where
# there is no mpirun.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/skip.sh"
export TANDEM_TEST_FOLDER=$folder
run "$2" "$1/mpi_test"
