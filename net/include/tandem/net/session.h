// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "tandem/pbd/export.h"

namespace tandem::net {

/// Address at which a peer listens.
struct TANDEM_API HostPort {
  std::string host = {};   ///< name or address; IPv6 without brackets
  std::uint16_t port = 0;  ///< 1 to 65535

  friend bool operator==(const HostPort&, const HostPort&) = default;
};

/// Reads "HOST:PORT" or "[IPV6]:PORT". Throws std::invalid_argument naming the text and the rule.
TANDEM_API HostPort parse_host_port(std::string_view text);
/// The inverse of parse_host_port.
TANDEM_API std::string to_string(const HostPort& address);

/// Turns the first SIGINT or SIGTERM into a flag, so that a program can leave its session in order;
/// on Windows Ctrl+Break, and also closing the console, logging off and shutting down. Windows ends
/// the process 5 s after the last three. The second one ends the process as usual. At most one
/// object at a time.
/// @par Thread safety  requested, request, wait: from any thread.
class TANDEM_API StopSignal {
 public:
  /// Throws std::system_error if the handler cannot be installed.
  StopSignal();
  ~StopSignal();
  StopSignal(const StopSignal&) = delete;
  StopSignal& operator=(const StopSignal&) = delete;

  bool requested() const;
  /// Acts like a signal.
  void request();
  /// Sleeps for `duration` or until a stop is requested; true if it is.
  bool wait(std::chrono::nanoseconds duration) const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tandem::net
