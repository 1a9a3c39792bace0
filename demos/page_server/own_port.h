// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <boost/asio/socket_base.hpp>

namespace tandem::page_server {

/// Set before a port is bound. A program that starts again gets its port although connections of
/// its predecessor linger. On Windows it does so anyway, and "reuse" would let another program
/// share the port: there this keeps it from that.
#ifdef _WIN32
using OwnPort = boost::asio::detail::socket_option::boolean<SOL_SOCKET, SO_EXCLUSIVEADDRUSE>;
#else
using OwnPort = boost::asio::socket_base::reuse_address;
#endif

}  // namespace tandem::page_server
