// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors

// Stands around the blocks of docs/hands.md.

// page: Grab, move, let go

// page: Hands that others see
