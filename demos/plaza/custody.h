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

  /// Before a step: what is told of bodies, and which come near. @param near  peers that are
  /// connected
  void begin(const pbd::Vec3& feet, std::span<const consensus::PeerId> near,
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
    consensus::SessionTime astray_since = 0;   ///< not where its record says, and nobody keeps it
    consensus::SessionTime unheard_since = 0;  ///< its keeper says nothing of it
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
  void keep(const consensus::SharedId& id, Local& local, bool held, consensus::SessionTime now);
  /// Its keeper has carried it off, and does not tell of it any more.
  bool is_stale(const consensus::SharedId& id, Local& local, consensus::SessionTime now) const;
  bool may_go(const consensus::SharedId& id, const Local& local, const pbd::Vec3& feet) const;

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
  Counters counters_;
};

}  // namespace tandem::demos
