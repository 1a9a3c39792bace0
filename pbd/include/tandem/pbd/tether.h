// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "tandem/pbd/export.h"
#include "tandem/pbd/typed_block.h"

namespace tandem::pbd {

/// A user's spring: pulls a point of a body towards a moving point of the world, with damping and a
/// bound on its force. Three of them at different points hold a body like a loose hand.
/// C = p - anchor(t) [m, three rows];  force = -stiffness C - damping dC/dt, cut at max_force.
/// Source: [macklin2016] Eq. 26 as a 3x3 block. It has no part in the displacement channel: a loose
/// spring does not hold a body against its target, and its stretch acts in the real channel at
/// once.
class TANDEM_API Tether {
 public:
  static constexpr std::string_view kName = "tether";
  static constexpr int kOrder = static_cast<int>(SolveOrder::Compliant);
  static constexpr bool kGroupsAtOnce = true;

  /// N/m: a spring below has no effect, one above is a joint. Rows use compliance over substep
  /// squared, which would leave the range of a double outside these bounds.
  static constexpr double kMinStiffness = 1e-9;
  static constexpr double kMaxStiffness = 1e15;

  struct Def {
    BodyId body = {};
    Vec3 anchor_l = Vec3::Zero();  ///< m, frame of the body
    /// m, world, at the start of the next step. Steps advance it by `anchor_velocity`, so
    /// Tethers::def() returns its current place.
    Vec3 anchor_w = Vec3::Zero();
    Vec3 anchor_velocity = Vec3::Zero();  ///< m/s, world
    double stiffness = 500.0;             ///< N/m, kMinStiffness to kMaxStiffness
    double damping = 20.0;                ///< N s/m, >= 0
    double max_force = 1e9;               ///< N, > 0
  };

  // CONFIGURATION PROPERTIES FOLLOW
  static void check(const World& world, const Def& def);
  explicit Tether(const Def& def) : def_(def) {}
  const Def& def() const { return def_; }
  Def& def() { return def_; }
  BodyId body_a() const { return {}; }
  BodyId body_b() const { return def_.body; }

  // RUN TIME PROPERTIES FOLLOW
  void begin_substep(const SubstepContext& ctx);
  double project(const SubstepContext& ctx);
  /// A moving anchor moves the body.
  bool actuated() const { return !def_.anchor_velocity.isZero(0.0); }
  bool force_driven() const { return true; }
  double residual() const { return 0.0; }
  double displacement_residual() const { return 0.0; }
  /// Force (N, world) on the body in the last substep.
  const Vec3& force() const { return force_; }
  void save(ByteWriter& out) const;
  void load(ByteReader& in);

 private:
  Def def_;
  Vec3 lambda_ = Vec3::Zero();   ///< N s^2
  Vec3 c_start_ = Vec3::Zero();  ///< m
  Vec3 r_ = Vec3::Zero();        ///< m, world, lever arm at the start of the substep
  Vec3 force_ = Vec3::Zero();
};

using Tethers = TypedBlock<Tether>;

}  // namespace tandem::pbd
