// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "contact_kernels.h"

namespace tandem::pbd {

#if TANDEM_AVX2
/// Compiled for processors that have AVX2.
const ContactKernels& avx2_kernels();
#endif

int widest_kernels() {
#if TANDEM_AVX2
  if (__builtin_cpu_supports("avx2") != 0) return 4;
#endif
  return 2;
}

const ContactKernels& contact_kernels(int width) {
  static const ContactKernels narrow = kernel::kernels<xsimd::default_arch, xsimd::default_arch>();
#if TANDEM_AVX2
  if (width != 2 && widest_kernels() == 4) return avx2_kernels();
#else
  (void)width;
#endif
  return narrow;
}

}  // namespace tandem::pbd
