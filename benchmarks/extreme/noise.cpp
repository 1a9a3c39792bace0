// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "noise.h"

#include <cmath>
#include <numbers>

#include "tandem/pbd/math.h"

namespace tandem::extreme_bench {

double NoisyTransport::normal() {
  const auto uniform = [&] { return (static_cast<double>(random_() >> 11) + 0.5) * 0x1p-53; };
  const double radius = std::sqrt(-2.0 * std::log(uniform()));  // Box and Muller
  return radius * std::cos(2.0 * std::numbers::pi * uniform());
}

void NoisyTransport::drain(std::vector<consensus::Packet>& out) {
  const std::size_t first = out.size();
  inner_.drain(out);
  for (std::size_t i = first; i < out.size(); ++i) {
    if (!consensus::decode(out[i].bytes, packet_).ok() || packet_.states.empty()) continue;
    for (consensus::StateUpdate& update : packet_.states) {
      update.pose.position += distance_ * normals();
      update.pose.orientation = pbd::rotated(update.pose.orientation, angle_ * normals());
    }
    // Packets of states contain nothing else.
    out[i].bytes.clear();
    consensus::encode(std::span<const consensus::StateUpdate>(packet_.states), out[i].bytes);
  }
}

}  // namespace tandem::extreme_bench
