// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <stdexcept>

#include "peer/metrics_server.h"

namespace tandem::demos {

class MetricsServer::Impl {};

bool has_metrics_server() { return false; }

MetricsServer::MetricsServer(const std::string& /*address*/, std::uint16_t port) {
  throw std::runtime_error("metrics.port = " + std::to_string(port) +
                           ": needs a build with Boost (Debian: libboost-dev)");
}
MetricsServer::~MetricsServer() = default;
std::uint16_t MetricsServer::port() const { return 0; }
void MetricsServer::publish(std::string /*text*/) {}

}  // namespace tandem::demos
