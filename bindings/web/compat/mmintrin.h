/* SPDX-License-Identifier: MIT */
/* Copyright (c) 2026 The Tandem authors */
/* Eigen includes it with SSE2 and uses nothing of it; clang's own does not compile for wasm. */
