/* SPDX-License-Identifier: MIT */
/* Copyright (c) 2026 The Tandem authors */
#ifndef TESTS_CSHARP_REFERENCE_H
#define TESTS_CSHARP_REFERENCE_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Made by layout.py. */
void print_layout(void);

/* Heights of the tutorial's first program in C++, every half second. */
enum { TUTORIAL_HASHES = 5 };
void tutorial_of_cpp(uint64_t hashes[TUTORIAL_HASHES]);

#ifdef __cplusplus
}
#endif

#endif
