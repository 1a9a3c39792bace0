// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/pbd/slots.h"

#include "tandem/pbd/typed_block.h"

namespace tandem::pbd {

void Slots::save_free(ByteWriter& out) const {
  out.u32(static_cast<std::uint32_t>(free_.size()));
  for (const std::uint32_t slot : free_) out.u32(slot);
}

void Slots::load_free(ByteReader& in) {
  const std::uint32_t count = in.u32();
  free_.clear();
  if (in.failed() || count > alive_.size()) return in.fail();
  free_.reserve(alive_.size());
  for (std::uint32_t i = 0; i < count; ++i) free_.push_back(in.u32());
  if (!detail::are_free_slots(free_, alive_)) in.fail();
}

}  // namespace tandem::pbd
