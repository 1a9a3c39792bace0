// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <asio/error.hpp>
#include <string>
#include <system_error>

namespace tandem::net {

/// An Asio socket error that compares with std::errc: Asio's own category does not, and the
/// standard library for Windows does not know socket error codes.
inline std::system_error socket_error(const std::error_code& error, const std::string& what) {
#ifdef _WIN32
  if (error == asio::error::address_in_use) {
    return {std::make_error_code(std::errc::address_in_use), what};
  }
#endif
  return {error.value(), std::system_category(), what};
}

}  // namespace tandem::net
