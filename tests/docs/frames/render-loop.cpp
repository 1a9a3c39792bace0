// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors

// Stands around the block of docs/render-loop.md.

// page: In a render loop
