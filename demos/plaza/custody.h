// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <vector>

#include "plaza/plaza.h"
#include "tandem/consensus/peer.h"
#include "tandem/nats/body_ledger.h"
#include "tandem/scene.h"

namespace tandem::demos {

/// Selects the bodies in one person's world: those nearby, the one they hold, and those they keep.
///
/// A body that nobody simulates is where its record says. A person who moves one becomes its keeper
/// and writes its position to the ledger until it rests.
///
/// A record with a keeper is a lease, renewed each second; after three seconds without renewal
/// anybody may take the body. Silence of the keeper's peer means nothing, since it may be too far
/// away to be connected. While the lease holds, a copy elsewhere is out of date, and neighbours'
/// states of it are ignored. A body that leaves its keeper's area passes to a neighbour who has it.
class Custody {
 public:
  struct Counters {
    std::uint64_t appeared = 0;
    std::uint64_t vanished = 0;
    std::uint64_t written = 0;
    std::uint64_t refused = 0;
    std::uint64_t crossings = 0;  ///< handovers of bodies between cells by this keeper
  };

  /// All must outlive it.
  Custody(const PlazaOptions& options, consensus::PeerId self, tandem::Scene& scene,
          consensus::Peer& peer, nats::BodyLedger& ledger);

  /// Before a step: takes in states and records of bodies, and adds those that come near.
  /// @param near    connected peers
  /// @param served  a server is connected: without one nobody can renew a lease
  void begin(const pbd::Vec3& feet, std::span<const consensus::PeerId> near, bool served,
             consensus::SessionTime now);
  /// After a step: writes records and removes bodies. @param held  by this person
  void finish(const pbd::Vec3& feet, const consensus::SharedId* held, consensus::SessionTime now);
  /// The person leaves: their bodies stay where they are.
  void leave();

  struct Local {
    std::size_t number = 0;
    pbd::BodyId body;
    // ns; 0: not still.
    consensus::SessionTime still_since = 0;
    consensus::SessionTime astray_since = 0;  ///< not where its record says, without a keeper
    consensus::SessionTime written_at = 0;    ///< by this peer, as its keeper
  };
  const std::map<consensus::SharedId, Local>& local() const { return local_; }
  const Counters& counters() const { return counters_; }

 private:
  struct Lying {
    nats::LedgerRecord record;
    consensus::SessionTime heard = 0;
  };

  void watch_cells(const pbd::Vec3& feet);
  void hear(const nats::LedgerNews& news, consensus::SessionTime now);
  /// Drops a copy that is not where its record says, if no neighbour can correct it.
  void settle(std::map<consensus::SharedId, Local>::iterator local,
              const nats::LedgerRecord& record);
  void vanish(std::map<consensus::SharedId, Local>::iterator local);
  bool is_connected(consensus::PeerId peer) const {
    return std::find(near_.begin(), near_.end(), peer) != near_.end();
  }
  void appear(std::size_t number, const pbd::Pose& pose, const pbd::Twist& twist);
  /// True if its keeper's lease holds, whether the keeper is heard or not.
  bool is_leased(const Lying& lying, consensus::SessionTime now) const;
  bool is_kept(const nats::LedgerRecord& record, consensus::SessionTime now) const;
  /// True if a neighbour's state of a body is consistent with its record.
  bool agrees(const consensus::UnknownState& state, consensus::SessionTime now) const;
  /// The nearby peer that stated a body's position last; this peer if none did.
  consensus::PeerId successor(const consensus::SharedId& id, consensus::SessionTime now) const;
  void keep(const consensus::SharedId& id, Local& local, bool held, const pbd::Vec3& feet,
            consensus::SessionTime now);
  bool may_go(const consensus::SharedId& id, const Local& local, const pbd::Vec3& feet,
              consensus::SessionTime now) const;

  PlazaOptions options_;
  nats::CellOptions cells_;
  consensus::PeerId self_;
  tandem::Scene& scene_;
  consensus::Peer& peer_;
  nats::BodyLedger& ledger_;
  std::map<consensus::SharedId, Local> local_;
  std::set<nats::Cell> watched_;
  std::optional<pbd::Vec3> watched_about_;      ///< the person's position at that choice
  std::map<consensus::SharedId, Lying> lying_;  ///< in the cells around, by their records
  std::vector<consensus::PeerId> near_;
  std::optional<consensus::SharedId> held_;  ///< by this person
  std::vector<nats::LedgerNews> news_;
  consensus::SessionTime served_since_ = 0;  ///< ns
  Counters counters_;
};

}  // namespace tandem::demos
