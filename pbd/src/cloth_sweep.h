// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "cloth_rows.h"
#include "tandem/pbd/cloth_block.h"
#include "tandem/pbd/math.h"

namespace tandem::pbd {

/// Scratch of a step, and the sweeps over rows.
/// Legend: C violation [m], offset value at which C is held [m], at = compliance / h^2 [1/kg],
/// lambda multiplier [N s^2], K mobility of a point, motion per impulse [1/kg].
class __attribute__((visibility("hidden"))) ClothBlock::Sweep {
 public:
  static constexpr std::uint32_t kAllGroups = 0xfffffffeu;

  void begin_step(const ClothRows& rows, const SubstepContext& ctx, std::size_t scalars);
  /// Resets the multipliers of the group.
  void clear_lambdas(const ClothRows& rows, const SubstepContext& ctx);
  /// Sweeps over the rows of the group, back and forth. @param held  m, by scalar
  /// @param led  leading points do not move
  void run(const ClothRows& rows, const SubstepContext& ctx, std::span<const double> held,
           int sweeps, bool led);
  /// The real channel. A row that a stronger constraint has stretched far recovers only as far as
  /// the kinetic energy goes that rows took in this substep: more would be energy from nothing.
  /// @param carried  m, by scalar: left by agreement
  void run_real(const ClothRows& rows, const SubstepContext& ctx, std::span<const double> carried,
                int sweeps);
  /// Writes C of all rows of the group, or of all groups.
  void violations(const ClothRows& rows, std::span<const SolverBody> bodies, std::uint32_t group,
                  std::span<double> out) const;
  /// Visits the scalars of rigid rows of the group, those without compliance. Its flag marks a
  /// tether, whose positive C alone counts.
  template <class Visit>
  void for_rigid(const ClothRows& rows, std::uint32_t group, Visit&& visit) const;
  /// Moves leading points to where the others are.
  void follow(const ClothRows& rows, const SubstepContext& ctx);

  std::vector<double> bounds;  ///< m, by scalar: values at which the displacement channel holds C
  int calls = 0;               ///< calls of project() in this substep

 private:
  /// A body as rows see it, compact: a hundred take the memory of ten SolverBody.
  struct Point {
    Vec3 x = Vec3::Zero();  ///< m
    double inv_mass = 0.0;  ///< 1/kg
  };
  /// A held particle as part of its host.
  struct Hold {
    Vec3 r = Vec3::Zero();         ///< m, world, from the host's centre to the anchor
    Mat3 mobility = Mat3::Zero();  ///< of particle and host as one mass, 1/kg
    Mat3 share = Mat3::Zero();     ///< the host's share of an impulse on both
    std::uint32_t host = 0;        ///< slot
  };
  static constexpr std::uint32_t kFree = 0xffffffffu;
  /// Added to the diagonal of a row, as a share of it: a strand that is too long between two
  /// immovable ends has no solution otherwise.
  static constexpr double kRegular = 1e-9;

  bool in_group(std::uint32_t of, std::uint32_t group) const {
    return of == group || (group == kAllGroups && of != SolverBody::kNoGroup);
  }
  /// Displacement of a body; turns are rotation vectors in the world.
  struct Moved {
    Vec3 x = Vec3::Zero(), turn = Vec3::Zero();  ///< m, rad
  };
  /// Sets `offsets_` so that far-stretched rows hold their stretch. @return whether there are any
  bool hold_stretched(const ClothRows& rows, const SubstepContext& ctx,
                      std::span<const double> carried);
  void remember(const SubstepContext& ctx);
  /// Returns to the remembered poses and applies the moves.
  void move_from_start(const SubstepContext& ctx, std::span<const Moved> moves) const;
  void moves_since(const SubstepContext& ctx, std::vector<Moved>& moves) const;
  /// The largest share of the way from passive to full moves that adds no energy.
  double affordable(const SubstepContext& ctx) const;
  void find_groups(const ClothRows& rows, std::span<const SolverBody> bodies);
  void find_points(const ClothRows& rows, std::size_t bodies);
  void find_ropes(const ClothRows& rows);
  void gather(const SubstepContext& ctx);
  void scatter(const SubstepContext& ctx) const;
  void refresh_hold(const ClothRows::Attachment& attachment, std::span<const SolverBody> bodies,
                    Hold& hold) const;
  /// n K m of the point: motion along n per impulse along m.
  double mobility(std::uint32_t point, const Vec3& n, const Vec3& m) const {
    const std::uint32_t hold = hold_of_[point];
    if (hold == kFree) return points_[point].inv_mass * dot(n, m);
    return n.dot(holds_[hold].mobility * m);
  }
  void push(std::span<SolverBody> bodies, std::uint32_t point, const Vec3& impulse) {
    if (hold_of_[point] == kFree) {
      points_[point].x += points_[point].inv_mass * impulse;
    } else {
      push_held(bodies, point, impulse);
    }
  }
  void push_held(std::span<SolverBody> bodies, std::uint32_t point, const Vec3& impulse);
  void solve_strand(const ClothRows& rows, std::size_t index, const SubstepContext& ctx,
                    std::span<const double> held);
  /// Solves a strand whose links keep their directions; impulses in `row_`.
  void solve_straight(const ClothRows& rows, const ClothRows::Strand& strand, double softness,
                      std::span<const double> held);
  /// One Newton iteration for a strand whose links turn; adds to the impulses in `link_`. @return
  /// the largest error of a length, as a share of it
  double solve_turning(const ClothRows& rows, const ClothRows::Strand& strand, double softness,
                       std::span<const double> held);
  bool swings_fast(const ClothRows& rows, const ClothRows::Strand& strand) const;
  double mobility_trace(std::uint32_t point) const {
    const std::uint32_t hold = hold_of_[point];
    return hold == kFree ? 3.0 * points_[point].inv_mass : holds_[hold].mobility.trace();
  }
  Vec3 moved(std::uint32_t point, const Vec3& impulse) const {
    const std::uint32_t hold = hold_of_[point];
    return hold == kFree ? Vec3(points_[point].inv_mass * impulse)
                         : Vec3(holds_[hold].mobility * impulse);
  }
  void solve_tether(const ClothRows::Tether& tether, std::size_t index, const SubstepContext& ctx,
                    std::span<const double> held);
  void solve_mean(const ClothRows& rows, const ClothRows::Mean& mean, const SubstepContext& ctx,
                  std::span<const double> held, bool led);
  void solve_attachment(const ClothRows& rows, std::size_t index, const SubstepContext& ctx,
                        std::span<const double> held);

  std::vector<std::uint32_t> strand_group_, tether_group_, mean_group_, attachment_group_;
  std::vector<std::uint32_t> slots_;     ///< by point
  std::vector<std::uint32_t> point_of_;  ///< by body; kFree if no row has it
  /// Points that rows name: strands as in ClothRows::points, two per tether, means as in
  /// ClothRows::mean_points, and the particle of each attachment.
  std::vector<std::uint32_t> named_;
  std::vector<std::uint32_t> touched_;  ///< slots of all points and hosts, each once
  std::vector<Point> points_;
  std::vector<std::uint32_t> hold_of_;  ///< by point: index of its attachment, or kFree
  std::vector<Hold> holds_;
  std::vector<double> lambda_;   ///< N s^2, by scalar
  std::vector<double> offsets_;  ///< m, by scalar: value at which passive rows hold C
  struct {
    std::vector<SolverBody> start;
    std::vector<Moved> passive, full;
  } stretched_;  ///< by touched body: scratch of run_real()
  /// One strand, by row: direction, diagonal, coupling to the next row, right-hand side.
  struct Row {
    Vec3 n = Vec3::Zero();
    double diagonal = 1.0;
    double next = 0.0;
    double rhs = 0.0;
  };
  std::vector<Row> row_;
  /// One strand whose links turn, by link: inverse of the diagonal block, right-hand side.
  struct Link {
    Mat3 inverse = Mat3::Identity();
    Vec3 rhs = Vec3::Zero();
  };
  std::vector<Link> link_;
  std::vector<Vec3>
      pulls_;  ///< N s^2, by point of a strand: what its link to the next one has done
  /// By strand: shares no point with another one. Crossing threads are solved one after another; if
  /// each of them turned by itself, a cloth that is hit would gain energy.
  std::vector<std::uint8_t> rope_;
  std::vector<std::uint8_t> turns_;       ///< by strand: its links turn in this substep
  std::vector<std::uint32_t> strand_of_;  ///< by point: its first strand
  std::size_t tethers_at_ = 0, means_at_ = 0, attachments_at_ = 0;  ///< into named_
};

template <class Visit>
void ClothBlock::Sweep::for_rigid(const ClothRows& rows, std::uint32_t group, Visit&& visit) const {
  const auto visit_all = [&](std::uint32_t at, std::uint32_t scalars, bool excess) {
    for (std::uint32_t k = at; k < at + scalars; ++k) visit(k, excess);
  };
  for (std::size_t i = 0; i < rows.strands.size(); ++i) {
    const ClothRows::Strand& strand = rows.strands[i];
    if (strand.compliance == 0.0 && in_group(strand_group_[i], group)) {
      visit_all(strand.at, strand.count - 1, false);
    }
  }
  for (std::size_t i = 0; i < rows.tethers.size(); ++i) {
    if (in_group(tether_group_[i], group)) visit_all(rows.tethers[i].at, 1, true);
  }
  for (std::size_t i = 0; i < rows.means.size(); ++i) {
    const ClothRows::Mean& mean = rows.means[i];
    if (mean.compliance == 0.0 && in_group(mean_group_[i], group)) visit_all(mean.at, 3, false);
  }
  for (std::size_t i = 0; i < rows.attachments.size(); ++i) {
    if (in_group(attachment_group_[i], group)) visit_all(rows.attachments[i].at, 3, false);
  }
}

}  // namespace tandem::pbd
