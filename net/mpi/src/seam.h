// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <span>
#include <vector>

#include "neighbours.h"
#include "tandem/pbd/constraint.h"
#include "tandem/pbd/contact.h"

namespace tandem::mpi {

/// Contacts between own bodies and copies, solved after all others of a sweep: the owners'
/// velocities come before, and the rows' changes go back after. So a sweep between two ranks is
/// Gauss-Seidel, and no impulse is applied to one side alone. Changes of one body by several ranks
/// add up.
class Seam final : public pbd::ConstraintBlock {
 public:
  /// @param world  the block's world
  Seam(const pbd::World& world, Ranks& ranks, Neighbours& neighbours)
      : world_(world), ranks_(ranks), neighbours_(neighbours) {}

  pbd::ContactBlock& rows() { return rows_; }
  const pbd::ContactBlock& rows() const { return rows_; }
  void forget();
  std::vector<Neighbour>& neighbours() { return neighbours_.all(); }
  /// Mark the copies that contacts of this step touch.
  void note_touched(std::span<const pbd::Manifold> between, std::uint32_t slots);

  std::string_view name() const override { return "seam"; }
  int order() const override { return static_cast<int>(pbd::SolveOrder::Contact) + 1; }
  bool empty() const override { return false; }  // others may have rows on bodies of this rank
  void begin_step(const pbd::SubstepContext& ctx) override;
  bool has_gaps() const override { return displaces_; }
  void begin_substep(const pbd::SubstepContext& ctx) override;
  void warm_start(const pbd::SubstepContext& ctx) override;
  double project(const pbd::SubstepContext& ctx) override;
  double project_displacement(const pbd::SubstepContext& ctx) override;
  double solve_velocity(const pbd::SubstepContext& ctx) override;
  void finish_velocity(const pbd::SubstepContext& ctx) override;
  void end_step(const pbd::SubstepContext& ctx, std::span<double> wanted) override;
  void take_changed(std::vector<std::uint32_t>& bodies) override { rows_.take_changed(bodies); }
  void append_edges(std::vector<pbd::ConstraintEdge>& edges) const override {
    rows_.append_edges(edges);
  }
  void append_joined(std::uint32_t body, std::vector<std::uint32_t>& joined) const override {
    rows_.append_joined(body, joined);
  }
  void remove_body(pbd::BodyId body) override { rows_.remove_body(body); }
  pbd::BlockReport report() const override;
  void save(pbd::ByteWriter& out) const override { rows_.save(out); }
  void load(pbd::ByteReader& in) override { rows_.load(in); }
  bool fits(const pbd::World& world) const override { return rows_.fits(world); }

 private:
  struct Motion {
    pbd::Vec3 v, w, v_push, w_push;
  };
  void exchange_velocities(const pbd::SubstepContext& ctx, bool with_pose, With with = With::All);
  void remember(const pbd::SubstepContext& ctx, With with = With::All);
  void exchange_corrections(const pbd::SubstepContext& ctx, Topic topic, bool with_push,
                            With with = With::All);
  /// Calls visit(slot) for the bodies that take part in this group.
  template <class Visit>
  static void for_touched(const Neighbour& neighbour, const pbd::SubstepContext& ctx,
                          Visit&& visit);
  /// Their number.
  static std::size_t part_of(const Neighbour& neighbour, const pbd::SubstepContext& ctx);

  const pbd::World& world_;
  Ranks& ranks_;
  Neighbours& neighbours_;
  pbd::ContactBlock rows_;
  bool displaces_ = false;             ///< with any neighbour
  std::vector<std::uint8_t> touched_;  ///< by slot, scratch
  std::vector<Motion> before_;         ///< of copies, in the order of for_touched()
};

}  // namespace tandem::mpi
