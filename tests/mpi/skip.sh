# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# For the other scripts here: run RANKS PROGRAM ... under mpirun on this host, or skip.
command -v mpirun >/dev/null || {
  echo "SKIPPED: there is no mpirun here (Debian: openmpi-bin)"
  exit 77
}
# Ranks that wait leave their processor to the others.
export OMPI_MCA_mpi_yield_when_idle=1
run() {
  local ranks=$1
  shift
  mpirun --oversubscribe --allow-run-as-root --bind-to none -n "$ranks" "$@"
}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
