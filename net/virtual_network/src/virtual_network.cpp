// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/consensus/virtual_network.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "link_model.h"
#include "tandem/pbd/validate.h"

namespace tandem::consensus {

struct __attribute__((visibility("hidden"))) VirtualNetwork::State {
  LinkOptions defaults;
  std::uint64_t seed = 0;
  SessionTime now = 0;
  SessionTime start = 0;
  std::map<PeerId, std::unique_ptr<Endpoint>> endpoints;
  std::map<std::pair<PeerId, PeerId>, Link> links;
  Air air;

  Link* find(PeerId from, PeerId to) {
    const auto at = links.find({from, to});
    return at == links.end() ? nullptr : &at->second;
  }
  Link& checked(PeerId from, PeerId to, const char* what) {
    if (Link* const link = find(from, to)) return *link;
    pbd::detail::refuse(std::string("VirtualNetwork::") + what + ": link",
                        "between peers that have joined",
                        "from " + std::to_string(from) + " to " + std::to_string(to));
  }
  void add_link(PeerId from, PeerId to) {
    links.try_emplace({from, to}, from, to, defaults, seed, now);
  }
};

class __attribute__((visibility("hidden"))) VirtualNetwork::Endpoint : public Transport {
 public:
  Endpoint(State& network, PeerId self) : network_(network), self_(self) {}

  PeerId self() const override { return self_; }

  bool post(PeerId to, std::span<const std::byte> bytes, Delivery delivery) override {
    Link* const link = network_.find(self_, to);
    return link != nullptr && link->post(network_.now, bytes, delivery, network_.air);
  }

  std::size_t max_packet_bytes(Delivery delivery) const override {
    std::size_t most = Transport::max_packet_bytes(delivery);
    if (delivery == Delivery::Reliable) return most;
    for (const auto& [ends, link] : network_.links) {
      if (ends.first == self_) most = std::min(most, link.max_state_bytes());
    }
    return most;
  }

  void drain(std::vector<Packet>& out) override {
    std::move(arrived_.begin(), arrived_.end(), std::back_inserter(out));
    arrived_.clear();
  }

  void drop(PeerId peer, const std::string& reason) override {
    Link* const out = network_.find(self_, peer);
    Link* const in = network_.find(peer, self_);
    if (out == nullptr || in == nullptr) return;
    const std::string told = reason.empty() ? "no reason given" : reason;
    out->close(network_.now, told, network_.air);
    in->close(network_.now, "dropped by the peer: " + told, network_.air);
    std::erase_if(arrived_, [&](const Packet& packet) { return packet.from == peer; });
  }

  std::vector<PeerStatus> peers() const override {
    std::vector<PeerStatus> result;
    for (const auto& [id, endpoint] : network_.endpoints) {
      if (id != self_) result.push_back(status_of(id));
    }
    return result;
  }

  void arrive(Flight flight) {
    arrived_.push_back({flight.from, std::move(flight.bytes), shown_at(flight.due)});
  }
  void set_clock(SessionTime ahead, double drift_ppm) {
    ahead_ = ahead;
    drift_ppm_ = drift_ppm;
  }

 private:
  /// By this peer's clock.
  SessionTime shown_at(SessionTime time) const {
    const auto passed = static_cast<double>(time - network_.start);
    return time + ahead_ + static_cast<SessionTime>(std::floor(1e-6 * drift_ppm_ * passed + 0.5));
  }
  PeerStatus status_of(PeerId id) const {
    const Link& out = *network_.find(self_, id);
    const Link& in = *network_.find(id, self_);
    PeerStatus status;
    status.id = id;
    status.connected = out.open() && in.open();
    if (!status.connected) status.reason = out.open() ? in.reason() : out.reason();
    status.packets_in = in.counters().delivered;
    status.packets_out = out.counters().posted;
    status.bytes_in = in.bytes_delivered();
    status.bytes_out = out.bytes_posted();
    status.dropped_queue_full = out.counters().queue_full;
    if (in.delay() >= 0.0 && out.delay() >= 0.0) {
      status.round_trip = static_cast<std::int64_t>(std::floor(in.delay() + out.delay() + 0.5));
    }
    return status;
  }

  State& network_;
  PeerId self_;
  SessionTime ahead_ = 0;
  double drift_ppm_ = 0.0;
  std::vector<Packet> arrived_;
};

VirtualNetwork::VirtualNetwork(const LinkOptions& options, std::uint64_t seed, SessionTime start)
    : state_(std::make_unique<State>()) {
  options.validate();
  state_->defaults = options;
  state_->seed = seed;
  state_->now = state_->start = start;
}

VirtualNetwork::~VirtualNetwork() = default;

Transport& VirtualNetwork::transport(PeerId peer) {
  if (peer == 0) {
    pbd::detail::refuse("VirtualNetwork::transport: peer", "not 0", "0");
  }
  const auto found = state_->endpoints.find(peer);
  if (found != state_->endpoints.end()) return *found->second;
  for (const auto& [other, endpoint] : state_->endpoints) {
    state_->add_link(peer, other);
    state_->add_link(other, peer);
  }
  auto& endpoint = state_->endpoints[peer];
  endpoint = std::make_unique<Endpoint>(*state_, peer);
  return *endpoint;
}

void VirtualNetwork::set_link(PeerId from, PeerId to, const LinkOptions& options) {
  options.validate();
  state_->checked(from, to, "set_link").set_options(state_->now, options, state_->air);
}

void VirtualNetwork::cut(PeerId from, PeerId to) {
  state_->checked(from, to, "cut").cut(state_->now, state_->air);
}

void VirtualNetwork::heal(PeerId from, PeerId to) {
  state_->checked(from, to, "heal").heal(state_->now, state_->air);
}

SessionTime VirtualNetwork::now() const { return state_->now; }

void VirtualNetwork::advance_to(SessionTime time) {
  if (time < state_->now) {
    pbd::detail::refuse("VirtualNetwork::advance_to: time",
                        "at least " + std::to_string(state_->now), std::to_string(time));
  }
  for (auto& [ends, link] : state_->links) link.send_waiting(time, state_->air);
  while (!state_->air.empty() && state_->air.next_due() <= time) {
    Flight flight = state_->air.pop();
    state_->find(flight.from, flight.to)->count_delivered(flight);
    Endpoint& to = *state_->endpoints[flight.to];
    to.arrive(std::move(flight));
  }
  state_->now = time;
}

std::optional<SessionTime> VirtualNetwork::next_event() const {
  std::optional<SessionTime> earliest;
  if (!state_->air.empty()) earliest = state_->air.next_due();
  for (const auto& [ends, link] : state_->links) {
    if (link.waits() && (!earliest || link.free_at() < *earliest)) earliest = link.free_at();
  }
  return earliest;
}

void VirtualNetwork::set_clock(PeerId peer, SessionTime ahead, double drift_ppm) {
  constexpr SessionTime kMax = 1'000'000'000'000'000'000;
  const auto at = state_->endpoints.find(peer);
  if (at == state_->endpoints.end()) {
    pbd::detail::refuse("VirtualNetwork::set_clock: peer", "one that has joined",
                        std::to_string(peer));
  }
  if (ahead < -kMax || ahead > kMax) {
    pbd::detail::refuse("VirtualNetwork::set_clock: ahead", "within 1e18 ns of 0",
                        std::to_string(ahead));
  }
  pbd::detail::require(std::abs(drift_ppm) <= 1000.0, "VirtualNetwork::set_clock", "drift_ppm",
                       drift_ppm, "within 1000 of 0");
  at->second->set_clock(ahead, drift_ppm);
}

LinkCounters VirtualNetwork::counters(PeerId from, PeerId to) const {
  return state_->checked(from, to, "counters").counters();
}

}  // namespace tandem::consensus
