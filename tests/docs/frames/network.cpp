// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors

// Stands around the blocks of docs/network.md.
#include "tandem/net/udp.h"
#include "tandem/scene.h"
#include "tandem/session.h"

using namespace tandem;

void member(Scene& scene, std::uint64_t hash, const net::Key& key, const net::Key& own_key,
            const net::Key& organiser, const std::vector<std::byte>& certificate) {
  // page: Which transport
}
