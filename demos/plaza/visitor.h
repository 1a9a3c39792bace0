// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "plaza/custody.h"
#include "plaza/walker.h"
#include "tandem/consensus/nearby_interest.h"
#include "tandem/nats/nats_transport.h"
#include "tandem/net/udp.h"
#include "tandem/scene.h"

namespace tandem::demos {

struct VisitorLink {
  std::shared_ptr<nats::NatsHub> hub;   ///< null: UDP
  std::function<std::int64_t()> clock;  ///< ns, time of the square
  std::optional<std::uint16_t> meet;    ///< UDP port of a participant
};

/// One headless participant: a world of the bodies nearby, a peer, and a person who acts in it.
/// @par Thread safety  One object: one thread at a time.
class Visitor {
 public:
  Visitor(const PlazaOptions& options, std::size_t number, const VisitorLink& link);
  ~Visitor();
  Visitor(const Visitor&) = delete;
  Visitor& operator=(const Visitor&) = delete;

  /// ns.
  void step(consensus::SessionTime now, consensus::SessionTime end);
  void leave(consensus::SessionTime now);

  consensus::PeerId id() const { return id_; }
  const pbd::Vec3& feet() const { return walker_.feet(); }
  std::uint64_t taken() const { return walker_.taken(); }
  std::size_t connected() const { return near_.size(); }
  bool is_connected(consensus::PeerId peer) const;
  std::uint16_t port() const { return udp_ != nullptr ? udp_->local_port() : std::uint16_t{0}; }
  const nats::NatsTransport* transport() const { return nats_.get(); }
  const Custody* custody() const { return custody_ ? &*custody_ : nullptr; }
  /// The local copy of a body; null if there is none.
  const pbd::BodyState* copy_of(const consensus::SharedId& id) const;
  /// Bodies heard of in summaries, people in the largest cell around, and bytes.
  struct Far {
    std::uint64_t summaries = 0;
    std::uint64_t bytes = 0;
    std::uint32_t people = 0;
  };
  const Far& far() const { return far_; }

 private:
  consensus::Transport& wire() {
    return nats_ != nullptr ? static_cast<consensus::Transport&>(*nats_) : *udp_;
  }
  void look_about();
  void act(double dt, consensus::SessionTime now);
  void take_something();
  void say_far();

  PlazaOptions options_;
  consensus::PeerId id_;
  tandem::Scene scene_;
  std::shared_ptr<nats::NatsHub> hub_;  ///< null: UDP
  std::unique_ptr<nats::NatsTransport> nats_;
  std::unique_ptr<net::UdpTransport> udp_;
  std::unique_ptr<consensus::Peer> peer_;
  std::unique_ptr<consensus::NearbyInterest> interest_;
  std::unique_ptr<nats::BodyLedger> ledger_;
  std::optional<Custody> custody_;
  std::map<consensus::SharedId, pbd::BodyId> all_;  ///< over UDP
  Walker walker_;
  std::optional<consensus::SharedId> held_;
  consensus::GrabId grab_;
  std::vector<consensus::PeerStatus> peers_;  ///< scratch
  std::vector<consensus::PeerId> near_;
  std::vector<nats::NearPeer> near_peers_;
  std::vector<nats::CellSummary> summaries_;
  Far far_;
  bool served_ = true;  ///< the hub is connected
  std::uint64_t steps_ = 0;
};

/// Not secret: it separates the demo's sessions from others.
net::Key plaza_key();

}  // namespace tandem::demos
