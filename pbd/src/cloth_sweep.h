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
/// Legend: C violation [m], offset what C is held at [m], at = compliance / h^2 [1/kg], lambda
/// multiplier [N s^2], K mobility of a point: how far an impulse moves it [1/kg].
class __attribute__((visibility("hidden"))) ClothBlock::Sweep {
 public:
  static constexpr std::uint32_t kAllGroups = 0xfffffffeu;

  void begin_step(const ClothRows& rows, const SubstepContext& ctx, std::size_t scalars);
  /// Multipliers of the group start anew.
  void clear_lambdas(const ClothRows& rows, const SubstepContext& ctx);
  /// So many sweeps over the rows of the group, there and back. @param held  m, by scalar
  /// @param led  points that lead do not give way
  void run(const ClothRows& rows, const SubstepContext& ctx, std::span<const double> held,
           int sweeps, bool led);
  /// The real channel. What something stronger has stretched far comes back only as far as the
  /// kinetic energy that its rows took in this substep goes: more would be energy from nothing.
  /// @param carried  m, by scalar: what agreement left behind
  void run_real(const ClothRows& rows, const SubstepContext& ctx, std::span<const double> carried,
                int sweeps);
  /// Write C of all rows of the group, or of all groups.
  void violations(const ClothRows& rows, std::span<const SolverBody> bodies, std::uint32_t group,
                  std::span<double> out) const;
  /// Visit the scalars of rigid rows of the group: those of rows without compliance. A tether's
  /// says that only its excess counts.
  template <class Visit>
  void for_rigid(const ClothRows& rows, std::uint32_t group, Visit&& visit) const;
  /// Bring the points that lead to where the others are.
  void follow(const ClothRows& rows, const SubstepContext& ctx);

  std::vector<double> bounds;  ///< m, by scalar: where the displacement channel holds C
  int calls = 0;               ///< of project() in this substep

 private:
  /// A body as rows see it: a hundred of them lie in the memory of ten SolverBody.
  struct Point {
    Vec3 x = Vec3::Zero();  ///< m
    double inv_mass = 0.0;  ///< 1/kg
  };
  /// A held particle as part of its host.
  struct Hold {
    Vec3 r = Vec3::Zero();         ///< m, world, from the host's centre to the anchor
    Mat3 mobility = Mat3::Zero();  ///< of both as one mass, 1/kg
    Mat3 share = Mat3::Zero();     ///< of an impulse on both: the host's
    std::uint32_t host = 0;        ///< slot
  };
  static constexpr std::uint32_t kFree = 0xffffffffu;
  /// Added to the diagonal of a row, as a share of it: a strand that is too long between two things
  /// that do not move has no solution else.
  static constexpr double kRegular = 1e-9;

  bool in_group(std::uint32_t of, std::uint32_t group) const {
    return of == group || (group == kAllGroups && of != SolverBody::kNoGroup);
  }
  /// How a body was moved; turns are rotation vectors in the world.
  struct Moved {
    Vec3 x = Vec3::Zero(), turn = Vec3::Zero();  ///< m, rad
  };
  /// Set `offsets_` to keep what is stretched far. @return whether anything is
  bool hold_stretched(const ClothRows& rows, const SubstepContext& ctx,
                      std::span<const double> carried);
  void remember(const SubstepContext& ctx);
  /// Back to what was remembered, and on by those moves.
  void move_from_start(const SubstepContext& ctx, std::span<const Moved> moves) const;
  void moves_since(const SubstepContext& ctx, std::vector<Moved>& moves) const;
  /// From passive moves towards full ones, as far as they give no more energy than there was.
  double affordable(const SubstepContext& ctx) const;
  void find_groups(const ClothRows& rows, std::span<const SolverBody> bodies);
  void find_points(const ClothRows& rows, std::size_t bodies);
  void find_ropes(const ClothRows& rows);
  void gather(const SubstepContext& ctx);
  void scatter(const SubstepContext& ctx) const;
  void refresh_hold(const ClothRows::Attachment& attachment, std::span<const SolverBody> bodies,
                    Hold& hold) const;
  /// n K m of the point: how far an impulse along m moves it along n.
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
  /// The impulses of a strand whose links keep their directions, into `row_`.
  void solve_straight(const ClothRows& rows, const ClothRows::Strand& strand, double softness,
                      std::span<const double> held);
  /// What a round of Newton's method adds to the impulses of a strand whose links turn, into
  /// `link_`. @return how far they were from their lengths, as a share of these
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
  std::vector<std::uint32_t> point_of_;  ///< by body; kFree where no row has it
  /// What rows name, as points: strands as ClothRows::points, two for each tether, means as
  /// ClothRows::mean_points, and the particle of each attachment.
  std::vector<std::uint32_t> named_;
  std::vector<std::uint32_t> touched_;  ///< slots of all points and hosts, each once
  std::vector<Point> points_;
  std::vector<std::uint32_t> hold_of_;  ///< by point: index of its attachment; kFree without
  std::vector<Hold> holds_;
  std::vector<double> lambda_;   ///< N s^2, by scalar
  std::vector<double> offsets_;  ///< m, by scalar: where passive rows hold C
  struct {
    std::vector<SolverBody> start;
    std::vector<Moved> passive, full;
  } stretched_;  ///< by touched body: scratch of run_real()
  /// Of one strand, by row: direction, diagonal, what couples it to the next row, right-hand side.
  struct Row {
    Vec3 n = Vec3::Zero();
    double diagonal = 1.0;
    double next = 0.0;
    double rhs = 0.0;
  };
  std::vector<Row> row_;
  /// Of one strand whose links turn, by link: inverse of the diagonal block, right-hand side.
  struct Link {
    Mat3 inverse = Mat3::Identity();
    Vec3 rhs = Vec3::Zero();
  };
  std::vector<Link> link_;
  std::vector<Vec3>
      pulls_;  ///< N s^2, by point of a strand: what its link to the next one has done
  /// By strand: no other one shares a point with it. Threads that cross are solved one after
  /// another, and a cloth that is hit gains energy if each alone goes where it would turn to.
  std::vector<std::uint8_t> rope_;
  std::vector<std::uint8_t> turns_;       ///< by strand: its links turn, in this substep
  std::vector<std::uint32_t> strand_of_;  ///< by point: the first strand that has it
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
