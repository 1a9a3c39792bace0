/* SPDX-License-Identifier: MIT */
/* Copyright (c) 2026 The Tandem authors */
/* Symbols that the page's parts of libsodium reference, but never reach. */
#include <stddef.h>

int sodium_runtime_has_ssse3(void) { return 0; }
int sodium_runtime_has_sse41(void) { return 0; }
int sodium_runtime_has_sse2(void) { return 0; }
int sodium_runtime_has_avx2(void) { return 0; }
void sodium_misuse(void) { __builtin_trap(); }
void randombytes_buf(void* bytes, size_t size) {
  (void)bytes;
  (void)size;
  __builtin_trap();
}
