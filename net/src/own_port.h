// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <asio/socket_base.hpp>

namespace tandem::net {

/// Set before binding a port. A restarted program gets its port although connections of its
/// predecessor linger. Windows allows that anyway, and its "reuse" would let another program share
/// the port: there this option prevents it.
#ifdef _WIN32
using OwnPort = asio::detail::socket_option::boolean<SOL_SOCKET, SO_EXCLUSIVEADDRUSE>;
#else
using OwnPort = asio::socket_base::reuse_address;
#endif

}  // namespace tandem::net
