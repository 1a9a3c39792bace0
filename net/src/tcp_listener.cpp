// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tcp_listener.h"

#include <algorithm>
#include <asio/ip/v6_only.hpp>
#include <chrono>
#include <utility>

#include "loopback.h"
#include "own_port.h"
#include "socket_error.h"

namespace tandem::net {

namespace {

// After a failed accept(), for example for lack of descriptors.
constexpr std::chrono::milliseconds kAcceptPause{100};

}  // namespace

TcpListener::TcpListener(asio::io_context& context, const TcpOptions& options, TcpReport& report,
                         TcpSecurity* security, Hooks hooks)
    : acceptor_(context), report_(report), security_(security), hooks_(std::move(hooks)) {
  if (options.listen_port) listen(options);
}

void TcpListener::listen(const TcpOptions& options) {
  std::error_code error;
  const asio::ip::address address = asio::ip::make_address(options.listen_address, error);
  const asio::ip::tcp::endpoint endpoint(address, *options.listen_port);
  if (!error) acceptor_.open(endpoint.protocol(), error);
  if (!error) acceptor_.set_option(OwnPort(true), error);
  if (!error && address.is_v6()) acceptor_.set_option(asio::ip::v6_only(false), error);
  if (!error) acceptor_.bind(endpoint, error);
  if (!error) acceptor_.listen(asio::socket_base::max_listen_connections, error);
  if (!error) acceptor_.non_blocking(true, error);
  if (!error) port_ = acceptor_.local_endpoint(error).port();
  if (error) {
    throw socket_error(error,
                       "TcpTransport: cannot listen on " +
                           to_string(HostPort{options.listen_address, *options.listen_port}));
  }
  accept();
}

void TcpListener::accept() {
  const auto link = hooks_.new_link();
  acceptor_.async_accept(link->socket(), [this, link](const std::error_code& error) {
    if (!acceptor_.is_open()) return;
    if (error) {
      accept_again_ = std::chrono::steady_clock::now() + kAcceptPause;
      return;
    }
    report_.count(&StrangerStatus::accepted);
    if (over_rate(*link)) {
      report_.count(&StrangerStatus::limited, "too many connections from one address");
    } else {
      hooks_.accepted(link);
    }
    accept();
  });
}

/// Only the address of a new connection is known.
bool TcpListener::over_rate(TcpLink& link) const {
  if (security_ == nullptr) return false;
  std::error_code error;
  const asio::ip::address from = link.socket().remote_endpoint(error).address();
  if (error) return false;  // already closed, which link.start() will find
  return !security_->allow(to_bytes(from), nanoseconds(std::chrono::steady_clock::now()));
}

void TcpListener::sweep(SteadyTime now) {
  if (accept_again_ == SteadyTime{} || now < accept_again_) return;
  accept_again_ = {};
  accept();
}

void TcpListener::close() {
  std::error_code ignored;
  acceptor_.close(ignored);
}

}  // namespace tandem::net
