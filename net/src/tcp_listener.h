// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <asio/io_context.hpp>
#include <asio/ip/tcp.hpp>
#include <cstdint>
#include <functional>
#include <memory>

#include "tcp_link.h"
#include "tcp_report.h"
#include "tcp_security.h"

namespace tandem::net {

/// The listening socket. Network thread only.
class TcpListener {
 public:
  struct Hooks {
    std::function<std::shared_ptr<TcpLink>()> new_link;
    std::function<void(const std::shared_ptr<TcpLink>&)> accepted;
  };

  /// Listens as the options say. @param security  may be null: no limit on connections. Throws
  /// std::system_error if it cannot.
  TcpListener(asio::io_context& context, const TcpOptions& options, TcpReport& report,
              TcpSecurity* security, Hooks hooks);

  /// 0 if nothing listens.
  std::uint16_t port() const { return port_; }
  /// Accepts again some time after an error.
  void sweep(SteadyTime now);
  void close();

 private:
  void listen(const TcpOptions& options);
  void accept();
  bool over_rate(TcpLink& link) const;

  asio::ip::tcp::acceptor acceptor_;
  TcpReport& report_;
  TcpSecurity* security_;
  Hooks hooks_;
  std::uint16_t port_ = 0;
  SteadyTime accept_again_{};  // after an error; zero: accepting
};

}  // namespace tandem::net
