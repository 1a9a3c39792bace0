// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "program/network_udp.h"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <string_view>

#include "tandem/net/session.h"
#include "tandem/net/udp.h"

namespace tandem::demos {

namespace {

/// Not secret: it separates sessions of demos from other datagrams.
net::Key known_key() {
  net::Key key{};
  const std::string_view text = "tandem demo, not a secret";
  std::copy(text.begin(), text.end(), key.begin());
  return key;
}

}  // namespace

net::UdpOptions udp_options(const DemoOptions& options, std::uint64_t scene_hash) {
  net::UdpOptions result;
  result.self = options.peer_id;
  result.scene_hash = scene_hash;
  result.listen_port = options.listen.value_or(0);
  constexpr double kLink = 2000.0;  // kbit/s, by default
  result.kbit_per_s = options.budget > 0.0 ? options.budget : kLink;
  result.min_kbit_per_s = std::min(result.min_kbit_per_s, result.kbit_per_s);
  result.clock = options.timeline == Timeline::None     ? net::Clock::None
                 : options.timeline == Timeline::System ? net::Clock::System
                                                        : net::Clock::Session;
  for (const std::string& text : options.connect) {
    const net::HostPort address = net::parse_host_port(text);
    if (options.insecure && !is_loopback(address.host)) {
      refuse("--connect", text, "an address of this machine without --key");
    }
    result.connect.push_back(address);
  }
  if (options.insecure) {
    result.listen_address = "127.0.0.1";
    result.session_key = known_key();
  } else {
    set_members(options, result);
  }
  return result;
}

namespace {

class UdpNetwork final : public Network {
 public:
  explicit UdpNetwork(const net::UdpOptions& options) : transport_(options) {
    if (options.identity) fingerprint_ = net::fingerprint(net::public_key(*options.identity));
  }

  consensus::Transport& transport() override { return transport_; }
  consensus::SessionTime now() override { return transport_.session_now(); }
  std::int64_t clock_error() const override { return transport_.clock().error_bound; }
  std::uint16_t local_port() const override { return transport_.local_port(); }
  void change_group(std::span<const std::byte> signed_change) override {
    (void)transport_.change_group(signed_change);
  }
  std::uint64_t group() const override { return transport_.group(); }
  void connect(std::shared_ptr<net::DatagramPath> path) override {
    transport_.connect(std::move(path));
  }
  std::string trouble() const override {
    std::string text;
    for (const net::UdpLookup& lookup : transport_.lookups()) {
      if (!lookup.reason.empty())
        text += "; " + net::to_string(lookup.address) + ": " + lookup.reason;
    }
    for (const consensus::PeerStatus& peer : transport_.peers()) {
      if (!peer.reason.empty()) text += "; peer " + std::to_string(peer.id) + ": " + peer.reason;
    }
    const net::UdpStrangers strangers = transport_.strangers();
    if (strangers.bad_proof > 0) text += "; somebody has another key";
    if (strangers.refused > 0) text += "; somebody has another scene or the same id";
    return text;
  }
  Counts refused() const override {
    const net::UdpStrangers s = transport_.strangers();
    return {{"refused", s.refused},       {"malformed", s.malformed}, {"limited", s.limited},
            {"bad_cookie", s.bad_cookie}, {"bad_proof", s.bad_proof}, {"unknown", s.unknown}};
  }

 private:
  net::UdpTransport transport_;
};

}  // namespace

std::unique_ptr<Network> make_udp_network(const DemoOptions& options, std::uint64_t scene_hash) {
  return std::make_unique<UdpNetwork>(udp_options(options, scene_hash));
}

}  // namespace tandem::demos
