// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <stdexcept>
#include <string>

#include "program/network.h"
#include "tandem/net/clock.h"
#include "tandem/net/session.h"
#include "tandem/net/tcp.h"

namespace tandem::demos {

namespace {

class TcpNetwork final : public Network {
 public:
  explicit TcpNetwork(const net::TcpOptions& options) : transport_(options) {
    if (options.identity) fingerprint_ = net::fingerprint(net::public_key(*options.identity));
  }

  consensus::Transport& transport() override { return transport_; }
  consensus::SessionTime now() override { return clock_.now(); }
  std::int64_t clock_error() const override { return -1; }
  std::uint16_t local_port() const override { return transport_.local_port(); }
  void change_group(std::span<const std::byte> signed_change) override {
    transport_.change_group(signed_change);
  }
  std::uint64_t group() const override { return transport_.group(); }
  void connect(std::shared_ptr<net::DatagramPath> /*path*/) override {
    throw std::runtime_error("datagrams need UDP");
  }
  std::string trouble() const override {
    std::string text;
    for (const net::DialStatus& dial : transport_.dials()) {
      if (!dial.reason.empty()) text += "; " + net::to_string(dial.address) + ": " + dial.reason;
    }
    const net::StrangerStatus strangers = transport_.strangers();
    if (strangers.bad_proof > 0) text += "; somebody has another key";
    if (!strangers.last_reason.empty()) text += "; refused: " + strangers.last_reason;
    return text;
  }
  Counts refused() const override {
    const net::StrangerStatus s = transport_.strangers();
    return {{"refused", s.refused}, {"malformed", s.malformed}, {"timed_out", s.timed_out},
            {"limited", s.limited}, {"bad_proof", s.bad_proof}, {"forged", s.forged}};
  }
  std::int64_t clock_stepped() const override { return clock_.stepped(); }

 private:
  net::TcpTransport transport_;
  net::SessionClock clock_;
};

}  // namespace

std::unique_ptr<Network> make_network(const DemoOptions& options, std::uint64_t scene_hash) {
  if (options.wire == Wire::Nats) return make_nats_network(options, scene_hash);
  return options.udp() ? make_udp_network(options, scene_hash)
                       : make_tcp_network(options, scene_hash);
}

Key read_key(const std::string& path) {
  try {
    return read_session_key(path);
  } catch (const std::invalid_argument& error) {
    refuse("--key", path, error.what());
  }
}

std::unique_ptr<Network> make_tcp_network(const DemoOptions& options, std::uint64_t scene_hash) {
  net::TcpOptions result;
  result.self = options.peer_id;
  result.scene_hash = scene_hash;
  result.listen_port = options.listen;
  const bool here_alone = options.key.empty();
  for (const std::string& text : options.connect) {
    const net::HostPort address = net::parse_host_port(text);
    if (here_alone && !is_loopback(address.host)) {
      refuse("--connect", text, "an address of this machine, without --key");
    }
    result.connect.push_back(address);
  }
  if (here_alone) {
    result.listen_address = "127.0.0.1";
  } else {
    set_members(options, result);
  }
  return std::make_unique<TcpNetwork>(result);
}

}  // namespace tandem::demos
