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

/// Which bodies of the square are in one person's world: those near, those he holds, and those he
/// is the keeper of, which means that he writes into the ledger where they go until they rest.
///
/// A body that nobody simulates is where its record says. Who moves one becomes its keeper; when it
/// has come to rest he writes that, and keeps it no longer.
///
/// A record with a keeper is a lease. He writes each second where the body is, whether he holds it
/// or it rolls; who has read nothing of it for three may take it. That he is not heard says
/// nothing, since he may be further away than those who are connected. While the lease holds a copy
/// that is elsewhere is of before, and what a neighbour says of such a copy is not taken up. A body
/// that leaves who keeps it goes on to a neighbour who has it.
class Custody {
 public:
  struct Counters {
    std::uint64_t appeared = 0;
    std::uint64_t vanished = 0;
    std::uint64_t written = 0;
    std::uint64_t refused = 0;
    std::uint64_t crossings = 0;  ///< of bodies, from cell to cell, by this keeper
  };

  /// All must outlive it.
  Custody(const PlazaOptions& options, consensus::PeerId self, tandem::Scene& scene,
          consensus::Peer& peer, nats::BodyLedger& ledger);

  /// Before a step: what is told of bodies, and which come near.
  /// @param near    peers that are connected
  /// @param served  there is a server: without one nobody can renew a lease
  void begin(const pbd::Vec3& feet, std::span<const consensus::PeerId> near, bool served,
             consensus::SessionTime now);
  /// After a step: what is to be written, and who has gone. @param held  by this person
  void finish(const pbd::Vec3& feet, const consensus::SharedId* held, consensus::SessionTime now);
  /// The person goes: bodies that he keeps are left where they are.
  void leave();

  struct Local {
    std::size_t number = 0;
    pbd::BodyId body;
    // ns; 0: it is not so.
    consensus::SessionTime still_since = 0;
    consensus::SessionTime astray_since = 0;  ///< not where its record says, and nobody keeps it
    consensus::SessionTime written_at = 0;    ///< by this person, as its keeper
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
  /// Let go of a copy that is not where its record has it, where no neighbour can put that right.
  void settle(std::map<consensus::SharedId, Local>::iterator local,
              const nats::LedgerRecord& record);
  void vanish(std::map<consensus::SharedId, Local>::iterator local);
  bool is_connected(consensus::PeerId peer) const {
    return std::find(near_.begin(), near_.end(), peer) != near_.end();
  }
  void appear(std::size_t number, const pbd::Pose& pose, const pbd::Twist& twist);
  /// Whether its keeper's word still holds, although he may not be heard here.
  bool is_leased(const Lying& lying, consensus::SessionTime now) const;
  bool is_kept(const nats::LedgerRecord& record, consensus::SessionTime now) const;
  /// Whether what a neighbour says of a body can be, by its record.
  bool agrees(const consensus::UnknownState& state, consensus::SessionTime now) const;
  /// Who of those near has said last where a body is; this peer where nobody has.
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
  std::optional<pbd::Vec3> watched_about_;      ///< where the person was when they were chosen
  std::map<consensus::SharedId, Lying> lying_;  ///< in the cells about, by their records
  std::vector<consensus::PeerId> near_;
  std::optional<consensus::SharedId> held_;  ///< by this person
  std::vector<nats::LedgerNews> news_;
  consensus::SessionTime served_since_ = 0;  ///< ns
  Counters counters_;
};

}  // namespace tandem::demos
