// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <stdexcept>

#include "network.h"

namespace tandem::python {
namespace {

/// Placeholder for builds without it.
class Udp final : public Network {
 public:
  std::unique_ptr<tandem::Session> open(const Simulation&, PeerId, const SessionOptions&) override {
    return nullptr;
  }
};

}  // namespace

void bind_udp(py::module_& m, NetworkClass&) {
  py::class_<Udp, Network, std::shared_ptr<Udp>>(m, "Udp",
                                                 "Not in this build: it had no libsodium.")
      .def(py::init([](const py::args&, const py::kwargs&) -> std::shared_ptr<Udp> {
        throw std::runtime_error("this build has no UDP: libsodium was not found");
      }));
}

}  // namespace tandem::python
