// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "plaza/plaza.h"

#include <algorithm>
#include <cmath>

#include "scenes/random.h"

namespace tandem::demos {

namespace {

constexpr std::uint64_t kSquare = 0x706c617a61;  // "plaza", first half of all bodies' ids

/// Uniform over the square without its rim. `what` separates the random streams.
pbd::Vec3 place(const PlazaOptions& options, std::uint64_t what, std::size_t number) {
  constexpr double kRim = 0.5;  // m
  Random random(derived_seed(options.seed, what + number));
  const double low = std::min(kRim, 0.25 * options.side);
  const double x = random.uniform(low, options.side - low);
  return {x, random.uniform(low, options.side - low), 0.0};
}

}  // namespace

nats::CellOptions PlazaOptions::cells() const {
  nats::CellOptions out;
  out.edge = 0.5 * near;
  out.near = near;
  out.slack = 2.0 * slack();
  // The largest cells are about as large as the square.
  out.levels = 1;
  while (tells_far && out.levels < 4 && nats::cell_edge(out, out.levels) < 2.0 * side) ++out.levels;
  return out;
}

consensus::PeerOptions PlazaOptions::peer() const {
  consensus::PeerOptions out;
  out.update_hz = update_hz;
  out.sending.format = consensus::StateFormat::Compact;
  out.sending.tolerance = 1e-3;
  return out;
}

std::uint64_t PlazaOptions::scene_hash() const {
  std::uint64_t out = derived_seed(seed, 0x706c617a61);  // "plaza"
  for (const double part : {side, static_cast<double>(bodies), near}) {
    out = derived_seed(out, static_cast<std::uint64_t>(std::llround(1000.0 * part)));
  }
  return out;
}

consensus::SharedId PlazaBody::id(std::size_t number) { return {kSquare, number + 1}; }

std::optional<std::size_t> PlazaBody::number(const consensus::SharedId& id, std::size_t bodies) {
  if (id.high != kSquare || id.low == 0 || id.low > bodies) return std::nullopt;
  return id.low - 1;
}

collision::Shape PlazaBody::shape(std::size_t number) {
  if (number % 3 == 2) return collision::Sphere{kHalf};
  return collision::Box(kHalf, kHalf, kHalf);
}

pbd::Vec3 start_of_body(const PlazaOptions& options, std::size_t number) {
  return place(options, 1'000'000, number) + pbd::Vec3(0.0, 0.0, PlazaBody::kHalf);
}

pbd::Vec3 start_of_person(const PlazaOptions& options, std::size_t number) {
  return place(options, 2'000'000, number);
}

}  // namespace tandem::demos
