// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "tandem/collision/shape.h"
#include "tandem/consensus/peer.h"
#include "tandem/consensus/shared_id.h"
#include "tandem/nats/cells.h"
#include "tandem/pbd/types.h"

namespace tandem::demos {

enum class PlazaWire : std::uint8_t {
  Nats,
  Udp,  ///< full mesh, all bodies everywhere: for few people, as a baseline
};

struct PlazaOptions {
  std::size_t people = 20;
  std::size_t bodies = 1000;
  double side = 100.0;    ///< m, of the square
  double seconds = 20.0;  ///< s, of session time
  double step_hz = 60.0;
  double update_hz = 20.0;  ///< states per second
  std::uint64_t seed = 1;
  std::string server = "127.0.0.1:4222";
  PlazaWire wire = PlazaWire::Nats;
  std::size_t per_hub = 32;  ///< people per connection to the server
  double near = 8.0;         ///< m: people within it are connected
  std::size_t direct = 16;   ///< nearest peers reached by UDP; 0: all traffic goes over the server
  bool tells_far = true;     ///< cells are summarised
  std::string json = {};     ///< file for the figures, "-" = standard output
  bool quiet = false;

  /// m: radius of simulated bodies, half of `near`: two people with a body in common are connected.
  double reach() const { return 0.5 * near; }
  /// m: hysteresis before a body is dropped.
  double slack() const { return 0.075 * near; }
  nats::CellOptions cells() const;
  consensus::PeerOptions peer() const;
  /// Peers compare it before they play together.
  std::uint64_t scene_hash() const;
};

/// A body of the square: a crate or a ball, by its number.
struct PlazaBody {
  static constexpr double kHalf = 0.15;  ///< m, half an edge or a radius
  static constexpr double kMass = 3.0;   ///< kg

  static consensus::SharedId id(std::size_t number);
  /// None if the id is not of a square with this many bodies.
  static std::optional<std::size_t> number(const consensus::SharedId& id, std::size_t bodies);
  static collision::Shape shape(std::size_t number);
};

/// m, world, initially.
pbd::Vec3 start_of_body(const PlazaOptions& options, std::size_t number);
/// A person's initial position, on the ground.
pbd::Vec3 start_of_person(const PlazaOptions& options, std::size_t number);

}  // namespace tandem::demos
