// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// TANDEM_BENCH_MAKE is the factory of this program's engine.
#include "work_precision/run.h"

int main(int argc, char** argv) {
  return tandem::bench::work_precision_main(argc, argv, tandem::bench::TANDEM_BENCH_MAKE);
}
