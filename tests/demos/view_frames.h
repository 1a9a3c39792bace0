// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include "tandem/pbd/types.h"

namespace tandem::demos::view {

/// A page's reader of frames, written from demos/view/README.md.
struct PageBody {
  pbd::Vec3 position = pbd::Vec3::Zero();
  pbd::Quat orientation = pbd::Quat::Identity();
};
struct PagePane {
  float step_ms = 0, latency_ms = 0, divergence_p50_mm = 0, divergence_max_mm = 0;
  std::vector<PageBody> bodies;
  std::size_t records = 0;  ///< in the last frame
  struct Contact {
    int body = 0;
    std::array<float, 7> at{};
  };
  std::vector<Contact> contacts;
  struct Spring {
    int body = 0;
    std::array<float, 6> ends{};
    int who = 0, own = 0;
  };
  std::vector<Spring> springs;
  struct Target {
    int body = 0, peer = 0;
    std::array<float, 3> position{};
  };
  std::vector<Target> targets;
  std::vector<int> influence;
};

class PageReader {
 public:
  PageReader(double unit, std::size_t pane_count, std::size_t bodies)
      : panes(pane_count), unit_(unit) {
    for (PagePane& pane : panes) pane.bodies.resize(bodies);
  }

  bool key = false, overlays = false;
  std::uint32_t number = 0;
  double time = 0;
  std::vector<PagePane> panes;

  /// @throws std::runtime_error where the bytes are none of a frame, or more than one
  void read(const std::string& bytes) {
    bytes_ = &bytes;
    at_ = 0;
    if (u8() != 1) throw std::runtime_error("kind");
    const unsigned flags = u8();
    key = (flags & 1) != 0;
    overlays = (flags & 2) != 0;
    if (u16() != panes.size()) throw std::runtime_error("peers");
    number = u32();
    time = f64();
    for (PagePane& pane : panes) read(pane);
    if (at_ != bytes.size()) throw std::runtime_error("length");
  }

 private:
  void read(PagePane& pane) {
    pane.step_ms = f32();
    pane.latency_ms = f32();
    pane.divergence_p50_mm = f32();
    pane.divergence_max_mm = f32();
    std::vector<unsigned> mask((pane.bodies.size() + 7) / 8);
    for (unsigned& byte : mask) byte = u8();
    pane.records = 0;
    for (std::size_t b = 0; b < pane.bodies.size(); ++b) {
      if ((mask[b / 8] >> b % 8 & 1) == 0) continue;
      ++pane.records;
      const std::uint32_t low = u32();
      const std::uint32_t high = u32();
      const auto metres = [this](std::uint32_t raw) {
        return (static_cast<double>(raw) - 0x100000) * unit_;
      };
      pane.bodies[b].position = {metres(low & 0x1fffff), metres(low >> 21 | (high & 0x3ff) << 11),
                                 metres(high >> 10 & 0x1fffff)};
      if ((high >> 31) != 0) pane.bodies[b].orientation = turn(u32());
    }
    pane.springs.resize(u16());
    for (PagePane::Spring& spring : pane.springs) {
      spring.body = static_cast<int>(u16());
      for (float& value : spring.ends) value = f32();
      spring.who = static_cast<int>(u8());
      spring.own = static_cast<int>(u8());
    }
    if (!overlays) return;
    pane.contacts.resize(u16());
    for (PagePane::Contact& contact : pane.contacts) {
      contact.body = static_cast<int>(u16());
      for (float& value : contact.at) value = f32();
    }
    pane.targets.resize(u16());
    for (PagePane::Target& target : pane.targets) {
      target.body = static_cast<int>(u16());
      target.peer = static_cast<int>(u16());
      for (float& value : target.position) value = f32();
    }
    pane.influence.resize(pane.bodies.size());
    for (int& share : pane.influence) share = static_cast<int>(u8());
  }
  static pbd::Quat turn(std::uint32_t bits) {
    std::array<double, 4> parts{};
    const std::size_t left_out = bits >> 30;
    double rest = 1.0;
    for (std::size_t i = 0, shift = 0; i < 4; ++i) {
      if (i == left_out) continue;
      parts[i] = (static_cast<double>(bits >> shift & 1023) - 511.0) / 511.0 / std::sqrt(2.0);
      rest -= parts[i] * parts[i];
      shift += 10;
    }
    parts[left_out] = std::sqrt(std::max(0.0, rest));
    return {parts[3], parts[0], parts[1], parts[2]};
  }

  std::uint64_t raw(std::size_t count) {
    if (at_ + count > bytes_->size()) throw std::runtime_error("too short");
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < count; ++i) {
      value |= static_cast<std::uint64_t>(static_cast<unsigned char>((*bytes_)[at_ + i])) << 8 * i;
    }
    at_ += count;
    return value;
  }
  unsigned u8() { return static_cast<unsigned>(raw(1)); }
  unsigned u16() { return static_cast<unsigned>(raw(2)); }
  std::uint32_t u32() { return static_cast<std::uint32_t>(raw(4)); }
  float f32() { return std::bit_cast<float>(u32()); }
  double f64() { return std::bit_cast<double>(raw(8)); }

  double unit_;
  const std::string* bytes_ = nullptr;
  std::size_t at_ = 0;
};

}  // namespace tandem::demos::view
