// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/pbd/props_table.h"

#include <algorithm>
#include <array>

#include "tandem/pbd/bit_cast.h"

namespace tandem::pbd {
namespace {

/// Index of the shared record.
constexpr std::uint32_t kPlain = 0;

/// Compared bit for bit, as snapshots store the bits.
bool has_no_bits(double value) { return bit_cast<std::uint64_t>(value) == 0; }
bool all_zero(const auto& values) {
  return std::all_of(values.data(), values.data() + values.size(), has_no_bits);
}

/// Whether the properties are those of an empty slot.
bool is_plain(const BodyProps& props) {
  return props.type == BodyType::Static && props.gravity_scale == 1.0 && !props.stable_id &&
         props.can_sleep && !props.bullet && !props.locks.any() && !props.sleep_speed &&
         !props.sleep_spin &&
         all_zero(std::array{props.mass, props.inverse_mass, props.linear_damping,
                             props.angular_damping}) &&
         all_zero(props.origin) && all_zero(props.inertia) && all_zero(props.inverse_inertia) &&
         all_zero(props.principal.moments);
}

}  // namespace

void PropsTable::resize(std::size_t slots) {
  if (records_.empty()) records_.emplace_back();
  for (std::size_t slot = slots; slot < size(); ++slot) release(slot);
  record_of_.resize(slots, kPlain);
}

void PropsTable::set(std::size_t slot, const BodyProps& props) {
  if (is_plain(props)) {
    release(slot);
  } else {
    own(slot) = props;
  }
}

BodyProps& PropsTable::own(std::size_t slot) {
  std::uint32_t& record = record_of_[slot];
  if (record != kPlain) return records_[record];
  if (free_.empty()) {
    records_.emplace_back();
    free_.reserve(records_.capacity());  // release() must not allocate
    record = static_cast<std::uint32_t>(records_.size() - 1);
  } else {
    record = free_.back();
    free_.pop_back();
    records_[record] = {};
  }
  return records_[record];
}

void PropsTable::release(std::size_t slot) {
  if (record_of_[slot] != kPlain) free_.push_back(record_of_[slot]);
  record_of_[slot] = kPlain;
}

void PropsTable::assign(const PropsTable& source) {
  records_ = source.records_;
  record_of_ = source.record_of_;
  free_ = source.free_;
  free_.reserve(records_.size());
}

}  // namespace tandem::pbd
