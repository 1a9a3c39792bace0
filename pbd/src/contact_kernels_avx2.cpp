// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Compiled for AVX2. The linker keeps one of several functions with the same name: all that is
// included here must have names of its own, or machines without AVX may run AVX code.
#include "contact_kernels.h"

namespace tandem::pbd {
namespace {

// Instruction sets with names of this source alone, and so all functions instantiated with them.
struct Wide : xsimd::avx2 {};
struct Half : xsimd::sse4_2 {};

}  // namespace
}  // namespace tandem::pbd

namespace xsimd::types {

XSIMD_DECLARE_SIMD_REGISTER_ALIAS(tandem::pbd::Wide, avx2);
XSIMD_DECLARE_SIMD_REGISTER_ALIAS(tandem::pbd::Half, sse4_2);

}  // namespace xsimd::types

namespace tandem::pbd {

const ContactKernels& avx2_kernels() {
  static constexpr ContactKernels wide = kernel::kernels<Wide, Half>();
  return wide;
}

}  // namespace tandem::pbd
