// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "convert.h"
#include "guard.h"
#include "tandem/consensus/virtual_network.h"
#include "transport_impl.h"

using namespace tandem;
using namespace tandem::c;

namespace {

using consensus::Delivery;
using consensus::Packet;
using consensus::PeerId;
using consensus::PeerStatus;

/// Bytes: enough for every single record, with room to spare.
constexpr std::size_t kMinMaxPacket = 512;

/// The caller's functions as a transport.
class Callbacks final : public consensus::Transport {
 public:
  explicit Callbacks(const tandem_transport_def& def) : def_(def) {}

  PeerId self() const override { return def_.self; }
  bool post(PeerId to, std::span<const std::byte> bytes, Delivery delivery) override {
    const tandem_delivery how = delivery == Delivery::Reliable ? TANDEM_RELIABLE : TANDEM_NEWEST;
    return def_.post(def_.user, to, bytes.data(), bytes.size(), how) != 0;
  }
  std::size_t max_packet_bytes(Delivery /*delivery*/) const override {
    return def_.max_packet > 0 ? def_.max_packet : consensus::kMaxPacketBytes;
  }
  void drain(std::vector<Packet>& out) override {
    if (def_.drain != nullptr) def_.drain(def_.user, receive, &out);
  }
  void drop(PeerId peer, const std::string& reason) override {
    if (def_.drop != nullptr) def_.drop(def_.user, peer, reason.c_str());
  }
  std::vector<PeerStatus> peers() const override {
    std::vector<PeerStatus> result;
    if (def_.peers != nullptr) def_.peers(def_.user, list, &result);
    return result;
  }

 private:
  /// Called by the caller's code, which must not see an exception: without memory the packet is
  /// lost.
  static void receive(void* inbox, std::uint64_t from, const void* bytes, std::size_t size) {
    if (inbox == nullptr || (bytes == nullptr && size > 0) || size > consensus::kMaxPacketBytes) {
      return;
    }
    guarded(nullptr, [&] {
      const auto* const first = static_cast<const std::byte*>(bytes);
      static_cast<std::vector<Packet>*>(inbox)->push_back({from, {first, first + size}});
    });
  }
  static void list(void* into, std::uint64_t peer, std::int32_t connected) {
    if (into == nullptr || peer == 0) return;
    guarded(nullptr, [&] {
      static_cast<std::vector<PeerStatus>*>(into)->push_back(
          {.id = peer, .connected = connected != 0, .reason = {}});
    });
  }

  tandem_transport_def def_;
};

}  // namespace

struct tandem_network {
  consensus::VirtualNetwork network;
  std::map<PeerId, std::unique_ptr<tandem_transport>> transports;
};

tandem_transport* tandem_transport_create(const tandem_transport_def* def, tandem_error* error) {
  return made_by(error, [&] {
    const tandem_transport_def& d = required(def, "def");
    if (d.self == 0) pbd::detail::refuse("self", "not 0", "0");
    if (d.post == nullptr || d.drain == nullptr || d.peers == nullptr) {
      pbd::detail::refuse("post, drain and peers", "given", "null");
    }
    if (d.max_packet != 0 &&
        (d.max_packet < kMinMaxPacket || d.max_packet > consensus::kMaxPacketBytes)) {
      pbd::detail::refuse("max_packet",
                          "0 or from " + std::to_string(kMinMaxPacket) + " to " +
                              std::to_string(consensus::kMaxPacketBytes),
                          std::to_string(d.max_packet));
    }
    auto result = std::make_unique<tandem_transport>();
    result->owned = std::make_unique<Callbacks>(d);
    result->transport = result->owned.get();
    return result.release();
  });
}

void tandem_transport_destroy(tandem_transport* transport) {
  // A network's transport is destroyed with it.
  if (transport != nullptr && transport->owned != nullptr) delete transport;
}

tandem_network* tandem_network_create(const tandem_link* link, uint64_t seed, int64_t start_ns,
                                      tandem_error* error) {
  return made_by(error, [&] {
    const tandem_link& l = required(link, "link");
    return new tandem_network{
        .network = consensus::VirtualNetwork(
            {.latency = l.latency, .jitter = l.jitter, .loss = l.loss, .bandwidth = l.bandwidth},
            seed, checked_time("start_ns", start_ns, -consensus::kMaxStamp)),
        .transports = {}};
  });
}

void tandem_network_destroy(tandem_network* network) { delete network; }

tandem_transport* tandem_network_transport(tandem_network* network, uint64_t peer,
                                           tandem_error* error) {
  return made_by(error, [&] {
    tandem_network& n = required(network, "network");
    consensus::Transport& transport = n.network.transport(peer);
    auto& entry = n.transports[peer];
    if (entry == nullptr) {
      entry = std::make_unique<tandem_transport>();
      entry->transport = &transport;
      entry->clock = [&n] { return n.network.now(); };
    }
    return entry.get();
  });
}

tandem_result tandem_network_advance(tandem_network* network, int64_t time_ns,
                                     tandem_error* error) {
  return guarded(error, [&] {
    required(network, "network")
        .network.advance_to(checked_time("time_ns", time_ns, -consensus::kMaxStamp));
  });
}
