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

/// Who hears whom.
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

/// What only some scenes have.
struct Conditions {
  std::vector<peers_bench::Pace> pace;  ///< by peer; empty = all as usual
  std::vector<double> update_hz;        ///< likewise
  double noise = 0.0;                   ///< m, standard deviation of remote positions, each axis
  double noise_angle = 0.0;             ///< rad, likewise of remote orientations
  double loss = 0.0;                    ///< part of the packets
  double share = 0.0;                   ///< announced by all; 0 = the default
  double closing_share = 0.0;           ///< of a gap, per 1/60 s; 0 = the default
  bool owners = false;                  ///< every peer says that the bodies are its own
};

struct Scene {
  std::string name;
  std::string group;  ///< what is shown together
  double seconds = 6.0;
  int peers = 2;
  Topology topology = Topology::Mesh;
  std::function<Copy(int peer)> build;
  std::vector<Hand> hands;
  Conditions conditions;
  double differs = 0.0;      ///< m, how far apart the copies' surroundings hold them
  bool by_angle = false;     ///< the disagreement is one of orientation
  bool stands = false;       ///< nothing may be lower at the end by more than a quarter of an edge
  double weight_from = 0.0;  ///< s: nothing has weight before; hands are known everywhere by then
  double sample_hz = 60.0;   ///< how often copies are compared; all have ended a step then
};

std::vector<Scene> contact_scenes();    ///< boxes, walls, stacks; geometry that differs
std::vector<Scene> stiff_scenes();      ///< chains, rods, unequal masses, rotations
std::vector<Scene> condition_scenes();  ///< what goes wrong on the way or at a peer
/// The same disagreement in a mesh, a star and a ring of 2 to 16 peers.
std::vector<Scene> topology_scenes();

// Builders that several of them use ---------------------------------------------------------------

inline constexpr double kHalf = 0.25;  ///< m, of a usual box, 1 kg
/// s: hands are still for so long, so that all peers know of them when they begin to move.
inline constexpr double kKnown = 0.5;

Vec3 up(double z);
/// The top of it is at this height.
void floor(CopyBuilder& b, double height = 0.0);
pbd::BodyId box_at(CopyBuilder& b, const Vec3& position, double mass = 1.0);
/// A box on the floor that is drawn to and fro by two users.
Scene tug_of_war();

}  // namespace tandem::extreme_bench
