// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <compare>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "tandem/pbd/by_body.h"
#include "tandem/pbd/constraint.h"
#include "tandem/pbd/export.h"

namespace tandem::pbd {

struct ClothRows;

/// Names a row of one ClothBlock; ids are never reused.
struct TANDEM_API ClothRowId {
  std::uint64_t number = 0;
  bool valid() const { return number != 0; }
  friend auto operator<=>(const ClothRowId&, const ClothRowId&) = default;
};

/// A polyline of points that keep their distances: a thread of a cloth, or a rope.
/// C_i = |x_i+1 - x_i| - length_i [m]. All rows of a strand are solved at once, as a tridiagonal
/// system, so a strand holds any load.
struct TANDEM_API StrandDef {
  std::vector<BodyId> points = {};   ///< at least 2; a point is the body's centre of mass
  std::vector<double> lengths = {};  ///< m, > 0, one less than points; empty: the current distances
  double compliance = 0.0;           ///< 1/N, >= 0: strain per newton; 0 = rigid
};

/// Upper bound on the distance of two points far apart: replaces the many sweeps that cloth would
/// need.
/// C = |x_b - x_a| - length <= 0 [m]. Source: [kim2012].
struct TANDEM_API ClothTetherDef {
  BodyId a = {}, b = {};
  double length = 0.0;  ///< m, > 0
};

/// A weighted sum of points is zero: C = sum w_i x_i [m]. Weights 1, -2, 1 resist bending of a
/// strand; -1 for a body and weights with sum 1 for particles hold the body at their mean.
struct TANDEM_API MeanDef {
  std::vector<BodyId> points = {};   ///< at least 2, each named once
  std::vector<double> weights = {};  ///< one per point; their sum is 0
  double compliance = 0.0;           ///< m/N, >= 0; 0 = rigid
  /// Agreement between peers acts on the first point: where agreement moves it, the others follow,
  /// and it goes where they could follow. No effect on momentum.
  bool leads = false;
};

/// Attaches a particle to a host body: strands then move both as one mass.
struct TANDEM_API AttachmentDef {
  BodyId particle = {};
  BodyId host = {};
  Vec3 anchor_l = Vec3::Zero();  ///< m, frame of the host
};

/// Cloth and ropes: rows between point masses (bodies with locked rotation) and the bodies that
/// hold them.
///
/// Source: [macklin2016] Eq. 18; bending is a piecewise linear row, as in [bergou2006].
/// Differs: each strand is one linear system, as in [deul2018] for rods. An attached particle has
/// the mobility (K_p^-1 + K_h^-1)^-1 of itself and its host. Where a stronger constraint has
/// stretched a row by more than a hundredth, the recovery returns no more kinetic energy than rows
/// took. Links that no other strand crosses pull along their direction at the end of the substep
/// where the direction at its start would make the strand swing.
///
/// Rows are swept in the order in which they were added. Memory: allocates when rows are added or
/// removed, and in the first step after that. Copies share the row definitions; carried state is
/// their own.
/// Errors: std::invalid_argument naming field, value and rule.
class TANDEM_API ClothBlock final : public ConstraintBlock {
 public:
  static constexpr std::string_view kName = "cloth";

  ClothBlock();
  ~ClothBlock() override;

  ClothRowId add(const World& world, const StrandDef& def);
  ClothRowId add(const World& world, const ClothTetherDef& def);
  ClothRowId add(const World& world, const MeanDef& def);
  /// @throws std::invalid_argument also if the particle is attached already, or the host is a point
  ///   of rows
  ClothRowId add(const World& world, const AttachmentDef& def);
  /// Removes a row or attachment; its bodies keep moving.
  void remove(ClothRowId id);
  bool contains(ClothRowId id) const;
  /// Sweeps over all rows in each substep, 1 to 100; default two. More sweeps reduce the error
  /// between strands.
  void set_sweeps(int sweeps);

  std::string_view name() const override { return kName; }
  int order() const override { return static_cast<int>(SolveOrder::Joint) + 1; }
  bool empty() const override;
  void begin_step(const SubstepContext& ctx) override;
  void begin_substep(const SubstepContext& ctx) override;
  double project(const SubstepContext& ctx) override;
  void begin_displacement(const SubstepContext& ctx) override;
  double project_displacement(const SubstepContext& ctx) override;
  void end_displacement(const SubstepContext& ctx) override;
  void end_step(const SubstepContext& ctx, std::span<double> wanted) override;
  void append_edges(std::vector<ConstraintEdge>& edges) const override;
  void append_joined(std::uint32_t body, std::vector<std::uint32_t>& joined) const override;
  void take_changed(std::vector<std::uint32_t>& bodies) override;
  void remove_body(BodyId body) override;
  BlockReport report() const override;
  void save(ByteWriter& out) const override;
  void load(ByteReader& in) override;
  bool fits(const World& world) const override;
  std::unique_ptr<ConstraintBlock> make_empty() const override;
  bool assign(const ConstraintBlock& source) override;

 private:
  class Sweep;
  ClothRows& own_rows();
  const ByBody& neighbours() const;
  int sweeps_now();
  void require_no_host(BodyId point, std::string_view kind) const;
  std::uint32_t take_scalars(std::size_t count, std::span<const BodyId> bodies);

  std::shared_ptr<ClothRows> rows_;  ///< shared with copies; cloned before a change if it is shared
  mutable ByBody by_body_;           ///< pairs of neighbours, see append_joined()
  std::vector<double> carried_;      ///< m, per scalar of a row: the residual that agreement left
  std::vector<std::uint32_t> changed_;  ///< bodies, until the next step
  int sweeps_ = 2;
  double residual_ = 0.0;         ///< m
  std::unique_ptr<Sweep> sweep_;  ///< scratch of a step
};

}  // namespace tandem::pbd
