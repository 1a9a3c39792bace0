// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "view/frame_encoder.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

namespace tandem::demos::view {

namespace {

constexpr std::uint8_t kFrame = 1;
constexpr std::uint8_t kKey = 1;
constexpr std::uint8_t kOverlays = 2;
constexpr std::uint32_t kMiddle = 0x100000;  // of 21 bits
constexpr double kTurnSteps = 511.0;
constexpr std::size_t kMaxMarks = 16384;  // per kind and pane

std::uint32_t position_bits(double value, double unit) {
  const double steps = std::round(value / unit) + kMiddle;
  // Written so that NaN gives 0.
  if (!(steps >= 0.0)) return 0;
  return static_cast<std::uint32_t>(std::min(steps, 2.0 * kMiddle - 1.0));
}

/// The smallest three components, with the sign of the largest made positive.
std::uint32_t turn_bits(const pbd::Quat& q) {
  const std::array<double, 4> parts = {q.x(), q.y(), q.z(), q.w()};
  std::size_t largest = 0;
  for (std::size_t i = 1; i < 4; ++i) {
    if (std::abs(parts[i]) > std::abs(parts[largest])) largest = i;
  }
  const double sign = parts[largest] < 0.0 ? -1.0 : 1.0;
  std::uint32_t bits = static_cast<std::uint32_t>(largest) << 30;
  std::uint32_t shift = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    if (i == largest) continue;
    const double steps =
        std::round(sign * parts[i] * std::numbers::sqrt2 * kTurnSteps) + kTurnSteps;
    const double kept = steps >= 0.0 ? std::min(steps, 2.0 * kTurnSteps) : 0.0;
    bits |= static_cast<std::uint32_t>(kept) << shift;
    shift += 10;
  }
  return bits;
}

class Writer {
 public:
  explicit Writer(std::vector<std::byte>& out) : out_(out) {}
  template <class Integer>
  void put(Integer value) {
    const std::size_t at = out_.size();
    out_.resize(at + sizeof(Integer));
    for (std::size_t i = 0; i < sizeof(Integer); ++i) {
      out_[at + i] = static_cast<std::byte>(value >> (8 * i));
    }
  }
  void f32(double value) { put(std::bit_cast<std::uint32_t>(static_cast<float>(value))); }
  void f64(double value) { put(std::bit_cast<std::uint64_t>(value)); }
  void vec3(const pbd::Vec3& v) {
    for (const double value : {v.x(), v.y(), v.z()}) f32(value);
  }
  /// The number to write.
  std::size_t count(std::size_t all) {
    const std::size_t kept = std::min(all, kMaxMarks);
    put(static_cast<std::uint16_t>(kept));
    return kept;
  }

 private:
  std::vector<std::byte>& out_;
};

void write_springs(Writer& out, const PaneFrame& pane) {
  const std::size_t springs = out.count(pane.springs.size());
  for (std::size_t i = 0; i < springs; ++i) {
    out.put(pane.springs[i].body);
    out.vec3(pane.springs[i].anchor);
    out.vec3(pane.springs[i].attachment);
    out.put(pane.springs[i].pane);
    out.put(static_cast<std::uint8_t>(pane.springs[i].own ? 1 : 0));
  }
}

void write_overlays(Writer& out, const PaneFrame& pane, std::size_t bodies) {
  const std::size_t contacts = out.count(pane.contacts.size());
  for (std::size_t i = 0; i < contacts; ++i) {
    out.put(pane.contacts[i].body);
    out.vec3(pane.contacts[i].point);
    out.vec3(pane.contacts[i].normal);
    out.f32(pane.contacts[i].depth);
  }
  const std::size_t targets = out.count(pane.targets.size());
  for (std::size_t i = 0; i < targets; ++i) {
    out.put(pane.targets[i].body);
    out.put(pane.targets[i].pane);
    out.vec3(pane.targets[i].position);
  }
  for (std::size_t i = 0; i < bodies; ++i) {
    out.put(i < pane.influence.size() ? pane.influence[i] : std::uint8_t{0});
  }
}

}  // namespace

FrameEncoder::FrameEncoder(const Layout& layout) : position_unit_(layout.position_unit) {
  for (const Layout::Body& body : layout.bodies) turns_.push_back(body.turns ? 1 : 0);
}

FrameEncoder::Record FrameEncoder::record_of(const pbd::Pose& pose, bool turns) const {
  const std::uint32_t x = position_bits(pose.position.x(), position_unit_);
  const std::uint32_t y = position_bits(pose.position.y(), position_unit_);
  const std::uint32_t z = position_bits(pose.position.z(), position_unit_);
  Record record;
  record.low = x | y << 21;
  record.high = y >> 11 | z << 10;
  if (turns) record.turn = turn_bits(pose.orientation);
  return record;
}

bool FrameEncoder::take(const Frame& frame, bool always) {
  const std::size_t bodies = turns_.size();
  next_.resize(frame.panes.size() * bodies);
  for (std::size_t pane = 0; pane < frame.panes.size(); ++pane) {
    for (std::size_t body = 0; body < bodies; ++body) {
      next_[pane * bodies + body] = record_of(frame.panes[pane].poses[body], turns_[body] != 0);
    }
  }
  const bool as_many = next_.size() == records_.size();
  if (!always && number_ != 0 && next_ == records_) return false;
  changes_.assign(next_.size(), kMoved | kTurned);
  for (std::size_t i = 0; as_many && i < records_.size(); ++i) {
    const bool moved = next_[i].low != records_[i].low || next_[i].high != records_[i].high;
    const bool turned = next_[i].turn != records_[i].turn;
    changes_[i] = static_cast<std::uint8_t>((moved ? kMoved : 0) | (turned ? kTurned : 0));
  }
  records_.swap(next_);
  frame_ = frame;
  // After a change of panes no page has the previous number: all get a key frame.
  number_ += as_many || number_ == 0 ? 1 : 2;
  written_.fill(nullptr);
  return true;
}

FrameEncoder::Bytes FrameEncoder::bytes(bool key, bool overlays) {
  overlays = overlays && frame_.overlays;
  Bytes& place = written_[(key ? 2U : 0U) + (overlays ? 1U : 0U)];
  if (place == nullptr) place = write(key, overlays);
  return place;
}

FrameEncoder::Bytes FrameEncoder::write(bool key, bool overlays) const {
  const std::size_t bodies = turns_.size();
  const std::size_t panes = frame_.panes.size();
  auto result = std::make_shared<std::vector<std::byte>>();
  result->reserve(16 + panes * (32 + bodies * 13));
  Writer out(*result);
  out.put(kFrame);
  out.put(static_cast<std::uint8_t>((key ? kKey : 0) | (overlays ? kOverlays : 0)));
  out.put(static_cast<std::uint16_t>(panes));
  out.put(number_);
  out.f64(frame_.time);
  for (std::size_t p = 0; p < panes; ++p) {
    const PaneFrame& pane = frame_.panes[p];
    out.f32(pane.step_ms);
    out.f32(pane.latency_ms);
    out.f32(pane.divergence_p50_mm);
    out.f32(pane.divergence_max_mm);
    const std::uint8_t* const changes = &changes_[p * bodies];
    for (std::size_t first = 0; first < bodies; first += 8) {
      std::uint8_t mask = 0;
      for (std::size_t bit = 0; bit < std::min<std::size_t>(8, bodies - first); ++bit) {
        if (key || changes[first + bit] != 0) mask = static_cast<std::uint8_t>(mask | 1U << bit);
      }
      out.put(mask);
    }
    for (std::size_t body = 0; body < bodies; ++body) {
      if (!key && changes[body] == 0) continue;
      const Record& record = records_[p * bodies + body];
      const bool turn = turns_[body] != 0 && (key || (changes[body] & kTurned) != 0);
      out.put(record.low);
      out.put(record.high | (turn ? 0x80000000U : 0U));
      if (turn) out.put(record.turn);
    }
    write_springs(out, pane);
    if (overlays) write_overlays(out, pane, bodies);
  }
  return result;
}

}  // namespace tandem::demos::view
