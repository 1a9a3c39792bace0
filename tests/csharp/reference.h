/* SPDX-License-Identifier: MIT */
/* Copyright (c) 2026 The Tandem authors */
#ifndef TESTS_CSHARP_REFERENCE_H
#define TESTS_CSHARP_REFERENCE_H

/* Made by layout.py. */
void print_layout(void);

#endif
