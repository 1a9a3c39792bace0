// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#define CATCH_CONFIG_RUNNER
#include <mpi.h>

#include "support/catch.h"
#include "tandem/mpi/cluster.h"

/// All ranks run all cases, in the same order; the program fails where any of them does.
int main(int argc, char** argv) {
  const tandem::mpi::Environment environment(argc, argv);
  int failed = Catch::Session().run(argc, argv);
  MPI_Allreduce(MPI_IN_PLACE, &failed, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
  return failed;
}
