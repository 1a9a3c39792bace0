// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// In place of keys.cpp and tcp_security.cpp in builds without libsodium.
#include <stdexcept>

#include "tandem/net/keys.h"
#include "tcp_security.h"

namespace tandem::net {

namespace {

[[noreturn]] void refuse() {
  throw std::runtime_error("keys need a build with libsodium (Debian: libsodium-dev, pkgconf)");
}

}  // namespace

Key make_key() { refuse(); }
Key public_key(const Key& /*identity*/) { refuse(); }

bool has_protection() { return false; }
std::unique_ptr<TcpSecurity> make_tcp_security(const TcpOptions& /*options*/) { return nullptr; }

}  // namespace tandem::net
