// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <boost/asio/ip/address.hpp>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "view/protocol.h"

namespace tandem::demos::view {

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

/// How many commands a page may still send: kCommandsPerSecond, and as many at once.
class Allowance {
 public:
  using Clock = std::chrono::steady_clock;

  bool take(Clock::time_point now);

 private:
  Clock::time_point last_ = Clock::now();
  double left_ = kCommandsPerSecond;
};

}  // namespace tandem::demos::view
