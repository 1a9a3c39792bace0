// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "copies/session.h"

namespace tandem::extreme_bench {

using pbd::Quat;
using pbd::Vec3;
using peers_bench::Copy;
using peers_bench::CopyBuilder;

/// The connections between peers.
enum class Topology : std::uint8_t { Mesh, Star, Ring };

/// A user who holds a body from the start by a spring that all peers simulate.
struct Hand {
  int peer = 0;
  std::size_t body = 0;
  Vec3 attachment_l = Vec3::Zero();
  double stiffness = 500.0;  ///< N/m
  double damping = 20.0;     ///< N s/m
  std::function<Vec3(double time)> path;
};

/// Special conditions of some scenes.
struct Conditions {
  std::vector<peers_bench::Pace> pace;  ///< by peer; empty = default
  std::vector<double> update_hz;        ///< by peer; empty = default
  double noise = 0.0;                   ///< m, standard deviation of remote positions, each axis
  double noise_angle = 0.0;             ///< rad, the same for remote orientations
  double loss = 0.0;                    ///< fraction of packets
  double share = 0.0;                   ///< announced by all; 0 = the default
  double closing_share = 0.0;           ///< of a gap, per 1/60 s; 0 = the default
  bool owners = false;                  ///< every peer claims all bodies
};

struct Scene {
  std::string name;
  std::string group;  ///< scenes that are shown together
  double seconds = 6.0;
  int peers = 2;
  Topology topology = Topology::Mesh;
  std::function<Copy(int peer)> build;
  std::vector<Hand> hands;
  Conditions conditions;
  double differs = 0.0;      ///< m, distance that the surroundings keep between the copies
  bool by_angle = false;     ///< the disagreement is one of orientation
  bool stands = false;       ///< no body may end lower by more than a quarter of an edge
  double weight_from = 0.0;  ///< s: no gravity before; by then hands are known everywhere
  double sample_hz = 60.0;   ///< rate of comparison; all have just ended a step then
};

std::vector<Scene> contact_scenes();    ///< boxes, walls, stacks; geometry that differs
std::vector<Scene> stiff_scenes();      ///< chains, rods, unequal masses, rotations
std::vector<Scene> condition_scenes();  ///< faults of links and peers
/// The same disagreement in a mesh, a star and a ring of 2 to 16 peers.
std::vector<Scene> topology_scenes();

// Helpers for several scenes

inline constexpr double kHalf = 0.25;  ///< m, of a default box, 1 kg
/// s: hands wait this long, so that all peers know them before they move.
inline constexpr double kKnown = 0.5;

Vec3 up(double z);
/// Top at `height`.
void floor(CopyBuilder& b, double height = 0.0);
pbd::BodyId box_at(CopyBuilder& b, const Vec3& position, double mass = 1.0);
/// A box on the floor that two users pull to and fro.
Scene tug_of_war();

}  // namespace tandem::extreme_bench
