// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <boost/asio/ip/address.hpp>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace tandem::page_server {

/// 32 hex digits of the system's generator. @throws std::runtime_error if there is none
std::string random_token();

/// The part of a request's target after "/TOKEN/", without its query; nothing for another token.
/// Takes constant time.
std::optional<std::string_view> below(std::string_view token, std::string_view target);

/// True if a request's target, without its query, is "/TOKEN".
bool lacks_slash(std::string_view token, std::string_view target);

/// True if a request's host is a listener's own address: this keeps out pages of other sites and
/// other names of this machine.
bool is_name_of(std::string_view host, const boost::asio::ip::address& address, std::uint16_t port);

/// Rate limit of a connection's messages; the burst is one second's worth.
class Allowance {
 public:
  using Clock = std::chrono::steady_clock;

  explicit Allowance(double per_s) : per_s_(per_s), left_(per_s) {}

  /// False if less than `amount` is left; nothing is then taken.
  bool take(Clock::time_point now, double amount = 1.0);

 private:
  double per_s_;
  Clock::time_point last_ = Clock::now();
  double left_;
};

}  // namespace tandem::page_server
