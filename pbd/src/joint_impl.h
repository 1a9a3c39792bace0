// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "joint_system.h"
#include "tandem/pbd/by_body.h"
#include "tandem/pbd/joint.h"

namespace tandem::pbd {

/// The joints of a block by slot, and the system that solves them.
class __attribute__((visibility("hidden"))) JointBlock::Impl {
 public:
  std::uint32_t checked(JointId id) const {
    if (!contains(id)) {
      throw std::invalid_argument("joint: id " + std::to_string(id.index) + " (generation " +
                                  std::to_string(id.generation) + ") names no joint of this block");
    }
    return id.index;
  }
  bool contains(JointId id) const {
    return id.index < records.size() && records[id.index].alive &&
           generations[id.index] == id.generation;
  }
  void erase(std::uint32_t index) {
    note_change(records[index]);
    by_body.remove(index);
    records[index].alive = false;
    ++generations[index];
    free.push_back(index);
    --count;
    dirty = true;
  }

  const ByBody& named() {
    by_body.renew([&] {
      for (std::uint32_t i = 0; i < records.size(); ++i) {
        if (records[i].alive) by_body.add(i, records[i].def.a.index, records[i].def.b.index);
      }
    });
    return by_body;
  }

  /// Writes the current coordinates to `c`.
  void place(const JointRecord& record, std::span<const SolverBody> bodies, double* c) const {
    const SolverBody ground;
    const SixDofJointDef& def = record.def;
    coordinates(record, def.a.valid() ? bodies[def.a.index] : ground, bodies[def.b.index],
                record.twist, c);
  }
  bool is_shared(const JointRecord& record, std::span<const SolverBody> bodies) const {
    return (record.def.a.valid() && bodies[record.def.a.index].shared) ||
           bodies[record.def.b.index].shared;
  }
  /// See JointRecord::find_gap() and SubstepContext::displaced. Marks the bodies of open gaps.
  void find_gaps(const SubstepContext& ctx) {
    gaps = false;
    const SolverBody ground;
    const auto moved = [&](BodyId id) {
      return id.valid() && !ctx.displaced.empty() && ctx.displaced[id.index] != 0;
    };
    for (JointRecord& record : records) {
      if (!record.active()) continue;
      const SixDofJointDef& def = record.def;
      // With agreement a joint may stay open for as long as the peers want it to.
      const SolverBody& b = ctx.bodies[def.b.index];
      if (b.agreed || (def.a.valid() && ctx.bodies[def.a.index].agreed)) {
        record.gap = {};
        if (moved(def.a) || moved(def.b)) record.forgive(body_of(def.a, ctx.bodies, ground), b);
        continue;
      }
      record.find_gap(body_of(def.a, ctx.bodies, ground), ctx.bodies[def.b.index],
                      moved(def.a) || moved(def.b));
      if (!record.gap.is_open()) continue;
      for (const BodyId id : {def.a, def.b}) {
        if (!id.valid() || !ctx.bodies[id.index].is_solved()) continue;
        gaps = ctx.bodies[id.index].shared = true;
      }
    }
  }
  /// Visits joints of the group. Of other joints only the group is read: they may be solved at the
  /// same time.
  void for_shared(const SubstepContext& ctx, auto&& visit) {
    for (JointRecord& record : records) {
      const SixDofJointDef& def = record.def;
      const bool in =
          record.alive && (ctx.bodies[def.b.index].group == ctx.group ||
                           (def.a.valid() && ctx.bodies[def.a.index].group == ctx.group));
      if (in && record.active() && is_shared(record, ctx.bodies)) visit(record);
    }
  }
  /// Whether some coordinate has a row and some end can move.
  static bool is_solved(const JointRecord& record, std::span<const SolverBody> bodies) {
    const SixDofJointDef& def = record.def;
    return record.used != 0 && ((def.a.valid() && bodies[def.a.index].inv_mass > 0.0) ||
                                bodies[def.b.index].inv_mass > 0.0);
  }

  void note_change(const JointRecord& record) {
    if (record.def.a.valid()) changed.push_back(record.def.a.index);
    changed.push_back(record.def.b.index);
    apart_known = false;
  }
  /// See ConstraintBlock::append_apart().
  const std::vector<BodyPair>& kept_apart() {
    if (std::exchange(apart_known, true)) return apart;
    apart.clear();
    for (const JointRecord& record : records) {
      const SixDofJointDef& def = record.def;
      if (!record.active() || def.collide_connected || !def.a.valid()) continue;
      apart.push_back(BodyPair::of(def.a.index, def.b.index));
    }
    return apart;
  }

  std::vector<std::uint32_t> changed;  ///< bodies to wake in the next step
  std::vector<BodyPair> apart;         ///< see kept_apart()
  bool apart_known = true;
  std::vector<JointRecord> records;
  std::vector<std::uint32_t> generations;
  std::vector<std::uint32_t> free;
  JointSystem system;
  ByBody by_body;  ///< index of records; see named()
  int count = 0;
  bool gaps = false;  ///< some joint closes a gap in this step
  /// Joints were added or removed; for other changes of the plan see JointSystem::fits().
  bool dirty = true;
  bool natural = true;  ///< the system was built in the order of slots
};

}  // namespace tandem::pbd
