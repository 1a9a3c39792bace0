// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "common/split_states.h"

#include <algorithm>

namespace tandem::demos {

using consensus::Delivery;

template <class Record>
bool SplitStates::post_records(consensus::PeerId to, std::span<const Record> records,
                               std::size_t each) {
  bool all = true;
  const std::size_t fit = (most_ - consensus::kHeaderBytes) / each;
  while (!records.empty()) {
    const std::span<const Record> part = records.first(std::min(fit, records.size()));
    records = records.subspan(part.size());
    part_.clear();
    consensus::encode(part, part_);
    all = inner_.post(to, part_, Delivery::Newest) && all;
  }
  return all;
}

bool SplitStates::post(consensus::PeerId to, std::span<const std::byte> bytes, Delivery delivery) {
  const bool fits = delivery != Delivery::Newest || bytes.size() <= most_;
  if (fits || !consensus::decode(bytes, decoded_).ok()) return inner_.post(to, bytes, delivery);
  const std::span<const consensus::StateUpdate> states(decoded_.states);
  const std::span<const consensus::SpringUpdate> springs(decoded_.springs);
  const bool all = post_records(to, states, consensus::kStateBytes);
  return post_records(to, springs, consensus::kSpringBytes) && all;
}

}  // namespace tandem::demos
