// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Compiled for AVX2: nothing may come in that other sources compile without it.
#include "contact_kernels.h"

namespace tandem::pbd {

const ContactKernels& avx2_kernels() {
  static constexpr ContactKernels wide = kernel::kernels<xsimd::avx2, xsimd::sse4_2>();
  return wide;
}

}  // namespace tandem::pbd
