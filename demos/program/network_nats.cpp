// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <algorithm>
#include <stdexcept>
#include <string>

#include "program/network_udp.h"
#include "tandem/nats/nats_transport.h"
#include "tandem/net/session.h"

namespace tandem::demos {

namespace {

/// These scenes have no places: all peers are in one cell.
constexpr std::size_t kMaxPeers = 64;

nats::NatsOptions nats_options(const DemoOptions& options, std::uint64_t scene_hash) {
  nats::NatsOptions result;
  result.member = udp_options(options, scene_hash);
  for (const std::string& text : options.servers) {
    const net::HostPort address = net::parse_host_port(text);
    if (options.insecure && !is_loopback(address.host)) {
      refuse("network.servers", text, "an address of this machine, with insecure");
    }
    result.server.servers.push_back(address);
  }
  if (options.listen) {
    result.server.direct = nats::DirectOptions{.listen_address = result.member.listen_address,
                                               .listen_port = *options.listen,
                                               .reachable_at = {}};
  }
  result.cells.max_near = kMaxPeers;
  result.cells.levels = 1;
  return result;
}

class NatsNetwork final : public Network {
 public:
  explicit NatsNetwork(const nats::NatsOptions& options) : transport_(options) {
    const auto& identity = options.member.identity;
    if (identity) fingerprint_ = net::fingerprint(net::public_key(*identity));
  }

  consensus::Transport& transport() override { return transport_; }
  consensus::SessionTime now() override { return transport_.session_now(); }
  std::int64_t clock_error() const override { return transport_.clock().error_bound; }
  std::uint16_t local_port() const override { return transport_.status().hub.direct_port; }
  void change_group(std::span<const std::byte> signed_change) override {
    (void)transport_.change_group(signed_change);
  }
  std::uint64_t group() const override { return transport_.group(); }
  void connect(std::shared_ptr<net::DatagramPath> /*path*/) override {
    throw std::runtime_error("ICE is for UDP");
  }
  std::string trouble() const override {
    std::string text;
    const nats::NatsStatus status = transport_.status();
    if (!status.hub.connected) text += "; no NATS server";
    if (status.refused > 0) text += "; somebody has another key";
    for (const consensus::PeerStatus& peer : transport_.peers()) {
      if (!peer.reason.empty()) text += "; peer " + std::to_string(peer.id) + ": " + peer.reason;
    }
    return text;
  }
  Counts refused() const override {
    const nats::NatsStatus s = transport_.status();
    return {{"bad_proof", s.refused}, {"unknown", s.unknown + s.hub.direct_unknown}};
  }

 private:
  nats::NatsTransport transport_;
};

}  // namespace

std::unique_ptr<Network> make_nats_network(const DemoOptions& options, std::uint64_t scene_hash) {
  return std::make_unique<NatsNetwork>(nats_options(options, scene_hash));
}

}  // namespace tandem::demos
