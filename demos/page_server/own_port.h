// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <boost/asio/socket_base.hpp>

namespace tandem::page_server {

/// Set before binding, so that a restarted program takes its port while old connections linger.
/// Windows always allows that, and its "reuse" would let another program share the port: there this
/// option prevents sharing.
#ifdef _WIN32
using OwnPort = boost::asio::detail::socket_option::boolean<SOL_SOCKET, SO_EXCLUSIVEADDRUSE>;
#else
using OwnPort = boost::asio::socket_base::reuse_address;
#endif

}  // namespace tandem::page_server
