// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "common/network.h"
#include "tandem/net/clock.h"
#include "tandem/net/session.h"
#include "tandem/net/tcp.h"

namespace tandem::demos {

namespace {

class TcpNetwork final : public Network {
 public:
  explicit TcpNetwork(const net::TcpOptions& options) : transport_(options) {}

  consensus::Transport& transport() override { return transport_; }
  consensus::SessionTime now() override { return clock_.now(); }
  std::int64_t clock_error() const override { return -1; }
  std::uint16_t local_port() const override { return transport_.local_port(); }
  std::string trouble() const override {
    std::string text;
    for (const net::DialStatus& dial : transport_.dials()) {
      if (!dial.reason.empty()) text += "; " + net::to_string(dial.address) + ": " + dial.reason;
    }
    const net::StrangerStatus strangers = transport_.strangers();
    if (!strangers.last_reason.empty()) text += "; refused: " + strangers.last_reason;
    return text;
  }

 private:
  net::TcpTransport transport_;
  net::SessionClock clock_;
};

}  // namespace

std::unique_ptr<Network> make_network(const DemoOptions& options, std::uint64_t scene_hash) {
  return options.udp() ? make_udp_network(options, scene_hash)
                       : make_tcp_network(options, scene_hash);
}

std::unique_ptr<Network> make_tcp_network(const DemoOptions& options, std::uint64_t scene_hash) {
  net::TcpOptions result;
  result.self = options.peer_id;
  result.scene_hash = scene_hash;
  result.listen_port = options.listen;
  for (const std::string& address : options.connect) {
    result.connect.push_back(net::parse_host_port(address));
  }
  return std::make_unique<TcpNetwork>(result);
}

}  // namespace tandem::demos
