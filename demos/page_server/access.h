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

/// 32 hex digits of the system's generator. @throws std::runtime_error where it has none
std::string random_token();

/// What comes after "/TOKEN/" in a request's target, without its query; nothing where the token is
/// another one. Takes as long whatever they differ in.
std::optional<std::string_view> below(std::string_view token, std::string_view target);

/// Whether a request's target, without its query, is "/TOKEN".
bool lacks_slash(std::string_view token, std::string_view target);

/// Whether a request's host is a listener's own address: neither another site's page nor another
/// name of this machine gets in.
bool is_name_of(std::string_view host, const boost::asio::ip::address& address, std::uint16_t port);

/// What a connection may still send: so much each second, and a second's worth at once.
class Allowance {
 public:
  using Clock = std::chrono::steady_clock;

  explicit Allowance(double per_s) : per_s_(per_s), left_(per_s) {}

  /// False where there is not so much left; nothing is then taken.
  bool take(Clock::time_point now, double amount = 1.0);

 private:
  double per_s_;
  Clock::time_point last_ = Clock::now();
  double left_;
};

}  // namespace tandem::page_server
