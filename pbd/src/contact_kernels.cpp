// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "contact_kernels.h"

#include <type_traits>

namespace tandem::pbd {
namespace {

/// Two numbers at once, also in builds for wider vectors.
constexpr bool kTwo = xsimd::batch<double, xsimd::default_arch>::size == 2;
using Narrow = std::conditional_t<kTwo, xsimd::default_arch, xsimd::sse2>;

}  // namespace

#if TANDEM_AVX2
/// Compiled for processors with AVX2.
const ContactKernels& avx2_kernels();
#endif

int widest_kernels() {
#if TANDEM_AVX2
  if (__builtin_cpu_supports("avx2") != 0) return 4;
#endif
  return 2;
}

const ContactKernels& contact_kernels(int width) {
  static constexpr ContactKernels narrow = kernel::kernels<Narrow, Narrow>();
#if TANDEM_AVX2
  if (width != 2 && widest_kernels() == 4) return avx2_kernels();
#else
  (void)width;
#endif
  return narrow;
}

}  // namespace tandem::pbd
