// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "contact_patch.h"
#include "tandem/pbd/bytes.h"

namespace tandem::collision {

inline constexpr std::uint32_t kCacheMagic = 0x33434354;  // "TCC3"

void save_cache(pbd::ByteWriter& out, const PairCache& cache);
/// @return false where the bytes are no cache; the cache is then of no use
bool load_cache(pbd::ByteReader& in, PairCache& cache, PatchPool& pool);

}  // namespace tandem::collision
