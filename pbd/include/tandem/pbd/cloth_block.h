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

/// Names a row of one ClothBlock; never given again.
struct TANDEM_API ClothRowId {
  std::uint64_t number = 0;
  bool valid() const { return number != 0; }
  friend auto operator<=>(const ClothRowId&, const ClothRowId&) = default;
};

/// Points in a line that keep their distances: the thread of a cloth, or a rope.
/// C_i = |x_i+1 - x_i| - length_i [m]. All rows of a strand are solved at once, by a tridiagonal
/// system, so that a strand holds whatever hangs on it.
struct TANDEM_API StrandDef {
  std::vector<BodyId> points = {};   ///< at least 2; their centres of mass
  std::vector<double> lengths = {};  ///< m, > 0, one less than points; empty: as they are now
  double compliance = 0.0;           ///< 1/N, >= 0: strain for each newton; 0 = rigid
};

/// Two points that are never further apart, over a long way: what cloth would need many sweeps for.
/// C = |x_b - x_a| - length <= 0 [m]. Source: [kim2012].
struct TANDEM_API ClothTetherDef {
  BodyId a = {}, b = {};
  double length = 0.0;  ///< m, > 0
};

/// A weighted sum of points is zero: C = sum w_i x_i [m]. Weights 1, -2, 1 resist bending of a
/// strand; -1 and some that add up to 1 hold a body to the mean of particles.
struct TANDEM_API MeanDef {
  std::vector<BodyId> points = {};   ///< at least 2, each once
  std::vector<double> weights = {};  ///< one for each; their sum is 0
  double compliance = 0.0;           ///< m/N, >= 0; 0 = rigid
  /// The first point is where agreement between peers acts: it leads the others where agreement
  /// moves it, and goes to where they could follow. Without effect on momentum.
  bool leads = false;
};

/// A particle is held by a body: from then on both are moved by strands as one mass.
struct TANDEM_API AttachmentDef {
  BodyId particle = {};
  BodyId host = {};
  Vec3 anchor_l = Vec3::Zero();  ///< m, frame of the host
};

/// Cloth and ropes: rows between point masses, which are bodies of the world whose rotation is
/// locked, and bodies that hold them.
///
/// Source: [macklin2016] Eq. 18; bending is a row that is linear in places, as in [bergou2006].
/// Differs: each strand is one linear system, as [deul2018] has it for rods; an attached particle
/// has the mobility (K_p^-1 + K_h^-1)^-1 of itself and its host; what something stronger has
/// stretched by more than a hundredth comes back with no more kinetic energy than rows took; links
/// of a strand that no other one crosses pull along where they end, where they would set it
/// swinging else.
///
/// Rows are swept in the order in which they were added. Memory: allocates where rows are added or
/// removed, and in the first step after that. Copies share what rows are and have their own
/// carried state.
/// Errors: std::invalid_argument naming field, value and rule.
class TANDEM_API ClothBlock final : public ConstraintBlock {
 public:
  static constexpr std::string_view kName = "cloth";

  ClothBlock();
  ~ClothBlock() override;

  ClothRowId add(const World& world, const StrandDef& def);
  ClothRowId add(const World& world, const ClothTetherDef& def);
  ClothRowId add(const World& world, const MeanDef& def);
  /// @throws as well where the particle is attached already, or the host is a point of rows
  ClothRowId add(const World& world, const AttachmentDef& def);
  /// What it held goes on as it moves.
  void remove(ClothRowId id);
  bool contains(ClothRowId id) const;
  /// Sweeps over all rows in each substep, 1 to 100; two by default. The error of what is not in
  /// one strand falls with it.
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

  std::shared_ptr<ClothRows> rows_;     ///< shared by copies; changed where no copy has it
  mutable ByBody by_body_;              ///< see neighbours()
  std::vector<double> carried_;         ///< m, by scalar of a row: what agreement left behind
  std::vector<std::uint32_t> changed_;  ///< bodies, until the next step
  int sweeps_ = 2;
  double residual_ = 0.0;         ///< m
  std::unique_ptr<Sweep> sweep_;  ///< scratch of a step
};

}  // namespace tandem::pbd
