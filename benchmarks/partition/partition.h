// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "cells.h"
#include "tandem/consensus/peer.h"

namespace tandem::partition_bench {

/// Who solves what happens where.
struct PartitionCell {
  consensus::PeerId peer = 0;
  Cell cell;
};

struct PartitionOptions {
  /// m: bodies whose middle is this close to a border are simulated on both sides, and averaged. A
  /// body's size at least, so that each contact across the border is known to both.
  double overlap = 0.4;
  /// m: bodies of others up to this far beyond are simulated along and follow what their own peer
  /// says. At least a body's size and the way that a fast one makes while news travels.
  double reach = 0.6;
  /// m: a body must get this much further before it changes sides again.
  double slack = 0.1;
  /// s: a body is left to a peer that was heard of it within this time, and not before.
  double patience = 0.5;

  /// @throws std::invalid_argument naming field, value and rule
  void validate() const;
};

/// Makes and removes bodies of this peer's world, with their shapes and joints; the application's.
class PartitionBodies {
 public:
  virtual ~PartitionBodies() = default;
  /// A body of another peer comes near. @param twist  world
  /// @return its instance in that state; an invalid id where no such body is known
  virtual pbd::BodyId appear(const consensus::SharedId& id, const pbd::Pose& pose,
                             const pbd::Twist& twist) = 0;
  /// A body is far away: remove it from the world.
  virtual void vanish(const consensus::SharedId& id, pbd::BodyId body) = 0;
};

struct PartitionStats {
  std::size_t own = 0;       ///< bodies that this peer alone simulates with authority
  std::size_t common = 0;    ///< that several peers do
  std::size_t followed = 0;  ///< others', simulated along
  std::uint64_t appeared = 0;
  std::uint64_t vanished = 0;
};

/// One world solved by several peers, each with the contacts and joints of its own part of space:
/// the asymmetric constraint model with constraints assigned by place, [friston] Sec. 8.3.
///
/// A body deep in a cell is owned by the cell's peer. Within `overlap` of a border it is
/// everybody's on both sides: each peer simulates it with the contacts it knows, and they agree as
/// peers do. Beyond, a peer follows the owner's states, up to `reach`; further away it knows
/// nothing of the body and is not told of it. Authority goes over while a body passes the border,
/// by agreement.
///
/// Each step:  peer.before_step(t);  solver.step(world, dt);  partition.update(t + dt);
/// peer.after_step(t + dt).  Sets itself as the peer's interest. The peer's authority_ramp should
/// be 0: all of them start with what is theirs.
/// @par Thread safety  Distinct objects: safe. One object: the thread that steps its world.
class Partition final : public consensus::Interest {
 public:
  /// World, peer and bodies must outlive it.
  /// @param self   the peer's id     @param cells  of all peers; they fill space without overlap
  /// @throws std::invalid_argument where an option is not what it must be or a peer has not one
  /// cell
  Partition(pbd::World& world, consensus::Peer& peer, PartitionBodies& bodies,
            consensus::PeerId self, std::vector<PartitionCell> cells,
            const PartitionOptions& options = {});
  ~Partition() override;
  Partition(const Partition&) = delete;
  Partition& operator=(const Partition&) = delete;

  /// Share a body that is in the world from the start. Where it is nobody's business here it
  /// vanishes at once. @throws std::invalid_argument as Peer::share
  void add(const consensus::SharedId& id, pbd::BodyId body);
  /// Other cells, as when load is shared out anew; bodies change hands in the steps that follow.
  /// @throws std::invalid_argument as the constructor
  void set_cells(std::vector<PartitionCell> cells);

  /// After a step, before the peer sends. @param now  session time of the world, ns
  void update(consensus::SessionTime now);

  /// Whose body one at this place is: the peer of its cell.
  consensus::PeerId peer_at(const pbd::Vec3& position) const;
  const PartitionStats& stats() const { return stats_; }

  // Interest
  bool concerns(consensus::PeerId to, const consensus::SharedId& id,
                const pbd::Pose& pose) const override;

 private:
  enum class Side : std::uint8_t { Own, Common, Followed };
  struct Member {
    consensus::SharedId id;
    pbd::BodyId body;
    Side side = Side::Common;
    consensus::PeerId owner = 0;       ///< of a followed one
    consensus::SessionTime since = 0;  ///< ns, when it came; 0 = not yet updated
  };

  /// Index of the first member whose id is not below.
  std::ptrdiff_t place_of(const consensus::SharedId& id) const;
  /// Whether a peer was heard of a body lately.
  bool is_fresh(const Member& member, consensus::PeerId from, consensus::SessionTime now) const;
  /// @param comes  it was not here before
  void set_side(Member& member, bool comes, consensus::SessionTime now);
  void take_in(consensus::SessionTime now);
  double own_depth(const pbd::Vec3& position) const;
  std::size_t cell_at(const pbd::Vec3& position) const;

  pbd::World& world_;
  consensus::Peer& peer_;
  PartitionBodies& bodies_;
  consensus::PeerId self_;
  PartitionOptions options_;
  std::vector<PartitionCell> cells_;
  std::size_t own_cell_ = 0;
  std::vector<Member> members_;         ///< by id
  consensus::SessionTime updated_ = 0;  ///< ns, when update() was called
  PartitionStats stats_;
};

}  // namespace tandem::partition_bench
