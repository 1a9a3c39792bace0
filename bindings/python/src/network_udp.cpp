// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <pybind11/stl.h>

#include <utility>

#include "network.h"
#include "tandem/net/udp.h"

namespace tandem::python {
namespace {

class Udp final : public Network {
 public:
  Udp(std::uint16_t port, std::string address, const std::vector<std::string>& connect,
      const py::object& key, double kbit_per_s) {
    options_.self = 1;
    options_.listen_port = port;
    options_.listen_address = std::move(address);
    options_.connect = addresses(connect);
    options_.session_key = key_of(key);
    options_.kbit_per_s = kbit_per_s;
    options_.validate();
  }

  std::unique_ptr<tandem::Session> open(const Simulation& simulation, PeerId self,
                                        const SessionOptions& options) override {
    net::UdpOptions mine = options_;
    mine.self = self;
    return std::make_unique<tandem::Session>(simulation, mine, options);
  }
  std::uint16_t port(consensus::Transport& transport) const override {
    return dynamic_cast<net::UdpTransport&>(transport).local_port();
  }

 private:
  net::UdpOptions options_;
};

}  // namespace

void bind_udp(py::module_& m, NetworkClass&) {
  py::class_<Udp, Network, std::shared_ptr<Udp>>(m, "Udp",
                                                 R"(A mesh of processes over UDP, encrypted.

port: 0 = a free one. address: numeric, "127.0.0.1" for this machine alone, "::" for IPv6 and IPv4.
connect: "HOST:PORT" of others, of which one is enough. key: the same for all, 32 bytes or 64 hex digits
(secrets.token_bytes(32)). kbit_per_s: budget of each link. The session agrees on a time of its own.
)")
      .def(py::init<std::uint16_t, std::string, const std::vector<std::string>&, const py::object&,
                    double>(),
           py::arg("port") = 0, py::kw_only(), py::arg("address") = "0.0.0.0",
           py::arg("connect") = std::vector<std::string>{}, py::arg("key"),
           py::arg("kbit_per_s") = 2000.0);
}

}  // namespace tandem::python
