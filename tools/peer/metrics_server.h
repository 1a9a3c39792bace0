// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <memory>
#include <string>

namespace tandem::demos {

/// True if this build can serve metrics.
bool has_metrics_server();

/// Serves a text at http://ADDRESS:PORT/metrics, on its own threads.
/// @par Thread safety  publish: from one thread at a time.
class MetricsServer {
 public:
  /// @param address  numeric     @param port  0 takes a free one
  /// @throws std::runtime_error if it cannot listen there, or this build has no server
  MetricsServer(const std::string& address, std::uint16_t port);
  ~MetricsServer();
  MetricsServer(const MetricsServer&) = delete;
  MetricsServer& operator=(const MetricsServer&) = delete;

  std::uint16_t port() const;
  /// Replaces the served text.
  void publish(std::string text);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tandem::demos
