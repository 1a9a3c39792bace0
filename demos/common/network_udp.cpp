// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <cctype>
#include <charconv>
#include <fstream>
#include <stdexcept>

#include "common/network.h"
#include "tandem/net/clock.h"
#include "tandem/net/session.h"
#include "tandem/net/udp.h"

namespace tandem::demos {

namespace {

net::UdpKey read_key(const std::string& path) {
  std::ifstream in(path);
  if (!in) throw std::invalid_argument("--key = " + path + ": cannot be read");
  std::string digits;
  for (char c = 0; digits.size() < 65 && in.get(c);) {
    if (std::isspace(static_cast<unsigned char>(c)) == 0) digits += c;
  }
  net::UdpKey key{};
  bool good = digits.size() == 2 * key.size();
  for (std::size_t i = 0; good && i < key.size(); ++i) {
    const char* const from = digits.data() + 2 * i;
    const auto [end, error] = std::from_chars(from, from + 2, key[i], 16);
    good = error == std::errc{} && end == from + 2;
  }
  if (!good) throw std::invalid_argument("--key = " + path + ": must hold 64 hex digits");
  return key;
}

/// No secret: it tells sessions of demos from other datagrams.
net::UdpKey known_key() {
  net::UdpKey key{};
  const std::string_view text = "tandem demo, not a secret";
  std::copy(text.begin(), text.end(), key.begin());
  return key;
}

bool is_loopback(const std::string& host) {
  return host == "localhost" || host == "::1" || host.starts_with("127.");
}

net::UdpOptions udp_options(const DemoOptions& options, std::uint64_t scene_hash) {
  net::UdpOptions result;
  result.self = options.peer_id;
  result.scene_hash = scene_hash;
  result.port = options.listen.value_or(0);
  result.kbit_per_s = options.budget;
  for (const std::string& text : options.connect) {
    const net::HostPort address = net::parse_host_port(text);
    if (options.insecure && !is_loopback(address.host)) {
      throw std::invalid_argument("--connect = " + text +
                                  ": must be of this machine with --insecure");
    }
    result.connect.push_back(address);
  }
  if (options.insecure) {
    result.address = "127.0.0.1";
    result.session_key = known_key();
  } else {
    result.session_key = read_key(options.key);
  }
  return result;
}

class UdpNetwork final : public Network {
 public:
  explicit UdpNetwork(const net::UdpOptions& options) : transport_(options) {}

  consensus::Transport& transport() override { return transport_; }
  consensus::SessionTime now() override { return clock_.now(); }
  std::uint16_t local_port() const override { return transport_.local_port(); }
  std::string trouble() const override {
    std::string text;
    for (const consensus::PeerStatus& peer : transport_.peers()) {
      if (!peer.reason.empty()) text += "; peer " + std::to_string(peer.id) + ": " + peer.reason;
    }
    const net::UdpStrangers strangers = transport_.strangers();
    if (strangers.bad_proof > 0) text += "; somebody has another key";
    if (strangers.refused > 0) text += "; somebody has another scene or the same id";
    return text;
  }

 private:
  net::UdpTransport transport_;
  net::SessionClock clock_;
};

}  // namespace

std::unique_ptr<Network> make_udp_network(const DemoOptions& options, std::uint64_t scene_hash) {
  return std::make_unique<UdpNetwork>(udp_options(options, scene_hash));
}

}  // namespace tandem::demos
