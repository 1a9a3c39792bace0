// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "network.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "bind.h"
#include "keywords.h"
#include "tandem/consensus/virtual_network.h"
#include "tandem/net/tcp.h"

namespace tandem::python {
namespace {

using consensus::LinkOptions;

/// ns
SessionTime duration(double seconds, const char* name) {
  pbd::detail::require(seconds >= 0.0 && seconds < 1e9, "VirtualNetwork", name, seconds,
                       "from 0 to 1e9 s");
  return std::llround(1e9 * seconds);
}

LinkOptions link_of(const py::kwargs& given) {
  LinkOptions link;
  if (given.contains("profile")) link = consensus::network_profile(given["profile"].cast<int>());
  take(given, "latency", link.latency);
  take(given, "jitter", link.jitter);
  take(given, "loss", link.loss);
  take(given, "duplicate", link.duplicate);
  take(given, "reorder", link.reorder);
  take(given, "bandwidth", link.bandwidth);
  return link;
}

std::uint64_t seed_of(const py::kwargs& given) {
  std::uint64_t seed = 1;
  take(given, "seed", seed);
  return seed;
}

/// Starts one second after 0, as 0 is no session time.
class Virtual final : public Network {
 public:
  explicit Virtual(const py::kwargs& given)
      : network_(link_of(given), seed_of(given), 1'000'000'000) {
    require_known(
        given, "VirtualNetwork",
        {"profile", "latency", "jitter", "loss", "duplicate", "reorder", "bandwidth", "seed"});
  }

  std::unique_ptr<tandem::Session> open(const Simulation& simulation, PeerId self,
                                        const SessionOptions& options) override {
    SessionOptions virtual_time = options;
    virtual_time.clock = [this] { return network_.now(); };
    return std::make_unique<tandem::Session>(simulation, network_.transport(self), virtual_time);
  }
  bool runs() const override { return false; }

  consensus::VirtualNetwork& network() { return network_; }

 private:
  consensus::VirtualNetwork network_;
};

class Tcp final : public Network {
 public:
  Tcp(std::optional<std::uint16_t> port, std::string address,
      const std::vector<std::string>& connect, const py::object& key) {
    options_.self = 1;
    options_.listen_port = port;
    if (key.is_none()) options_.listen_address = "127.0.0.1";
    if (!address.empty()) options_.listen_address = std::move(address);
    options_.connect = addresses(connect);
    if (!key.is_none()) options_.session_key = key_of(key);
    options_.validate();
  }

  std::unique_ptr<tandem::Session> open(const Simulation& simulation, PeerId self,
                                        const SessionOptions& options) override {
    net::TcpOptions mine = options_;
    mine.self = self;
    return std::make_unique<tandem::Session>(simulation, mine, options);
  }
  std::uint16_t port(consensus::Transport& transport) const override {
    return dynamic_cast<net::TcpTransport&>(transport).local_port();
  }

 private:
  net::TcpOptions options_;
};

}  // namespace

net::Key key_of(const py::handle& value) {
  constexpr const char* kRule = "32 bytes, or 64 hex digits";
  net::Key key{};
  if (py::isinstance<py::bytes>(value)) {
    const std::string bytes = value.cast<std::string>();
    if (bytes.size() != key.size()) {
      pbd::detail::refuse("key", kRule, std::to_string(bytes.size()) + " bytes");
    }
    std::copy(bytes.begin(), bytes.end(), key.begin());
    return key;
  }
  const std::string text = py::str(value);
  const auto digit = [&](char c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    if (c >= 'A' && c <= 'F') return c - 'A' + 10;
    // Without the text, which may be a secret.
    pbd::detail::refuse("key", kRule, "something else");
  };
  if (text.size() != 2 * key.size()) {
    pbd::detail::refuse("key", kRule, std::to_string(text.size()) + " characters");
  }
  for (std::size_t i = 0; i < key.size(); ++i) {
    key[i] = static_cast<std::uint8_t>(16 * digit(text[2 * i]) + digit(text[2 * i + 1]));
  }
  return key;
}

std::vector<net::HostPort> addresses(const std::vector<std::string>& texts) {
  std::vector<net::HostPort> result;
  for (const std::string& text : texts) result.push_back(net::parse_host_port(text));
  return result;
}

void bind_networks(py::module_& m) {
  NetworkClass base(m, "Network", "The network of a session: VirtualNetwork, Tcp or Udp.");
  py::class_<Virtual, Network, std::shared_ptr<Virtual>>(m, "VirtualNetwork",
                                                         R"(Peers of one process, in virtual time.

Keywords, all optional: profile (1 to 5, of the paper's Table 3), latency and jitter (s, one way), loss,
duplicate, reorder (chances), bandwidth (bit/s, 0 = no limit), seed. Nothing is delivered and no time
passes but in advance(). Same seed and same calls, same deliveries.

>>> import tandem
>>> network = tandem.VirtualNetwork(latency=0.05)
>>> network.advance(1 / 60)
>>> network.now
1016666667
)")
      .def(py::init([](const py::kwargs& given) { return std::make_shared<Virtual>(given); }))
      .def_property_readonly(
          "now", [](Virtual& v) { return v.network().now(); }, "session time, ns")
      .def(
          "advance",
          [](Virtual& v, double seconds) {
            v.network().advance_to(v.network().now() + duration(seconds, "seconds"));
          },
          py::arg("seconds"), "Let so much time pass, and deliver the packets due by then.")
      .def(
          "set_link",
          [](Virtual& v, PeerId from, PeerId to, const py::kwargs& given) {
            require_known(
                given, "set_link",
                {"profile", "latency", "jitter", "loss", "duplicate", "reorder", "bandwidth"});
            v.network().set_link(from, to, link_of(given));
          },
          py::arg("sender"), py::arg("receiver"),
          "Change one direction, by keywords as the network's.")
      .def(
          "cut", [](Virtual& v, PeerId from, PeerId to) { v.network().cut(from, to); },
          py::arg("sender"), py::arg("receiver"), "Cut one direction.")
      .def(
          "heal", [](Virtual& v, PeerId from, PeerId to) { v.network().heal(from, to); },
          py::arg("sender"), py::arg("receiver"), "Mend one direction.");
  py::class_<Tcp, Network, std::shared_ptr<Tcp>>(m, "Tcp", R"(A mesh of processes over TCP.

port: to accept peers on, 0 = a free one, None = only dial. address: numeric, to accept at. connect:
"HOST:PORT" of others, of which one is enough. key: the same for all, 32 bytes or 64 hex digits; without
one it is for this machine alone. Clocks must agree, by NTP or PTP.
)")
      .def(py::init<std::optional<std::uint16_t>, std::string, const std::vector<std::string>&,
                    const py::object&>(),
           py::arg("port") = py::none(), py::kw_only(), py::arg("address") = "",
           py::arg("connect") = std::vector<std::string>{}, py::arg("key") = py::none());
  bind_udp(m, base);
}

}  // namespace tandem::python
