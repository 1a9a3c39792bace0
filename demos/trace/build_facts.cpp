// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "trace/build_facts.h"

#if defined(__GLIBC__)
#include <gnu/libc-version.h>
#endif

#include "session/physics.h"

namespace tandem::demos {

std::string build_facts() {
  std::string facts = TANDEM_BUILD_FACTS;
#if defined(__GLIBC__)
  facts += ", glibc " + std::string(gnu_get_libc_version());
#endif
#if defined(__x86_64__)
  // The C library selects other sines and powers on machines with fused multiply-add.
  __builtin_cpu_init();
  facts += __builtin_cpu_supports("fma") ? ", fma" : ", no fma";
#endif
  return facts + (has_bullet() ? ", Bullet" : "");
}

}  // namespace tandem::demos
