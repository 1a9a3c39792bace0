// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// In place of keys.cpp, membership.cpp and tcp_security.cpp in builds without libsodium.
#include <stdexcept>

#include "tandem/net/keys.h"
#include "tandem/net/membership.h"
#include "tcp_security.h"

namespace tandem::net {

namespace {

[[noreturn]] void refuse() {
  throw std::runtime_error("keys need a build with libsodium (Debian: libsodium-dev, pkgconf)");
}

}  // namespace

Key make_key() { refuse(); }
Key public_key(const Key& /*identity*/) { refuse(); }

std::string fingerprint(const Key& /*public_key*/) { refuse(); }
consensus::PeerId derived_id(const Key& /*public_key*/) { refuse(); }
Key organiser_public_key(const Key& /*organiser*/) { refuse(); }
std::vector<std::byte> sign(const Certificate& /*certificate*/, const Key& /*organiser*/) {
  refuse();
}
std::optional<Certificate> read_certificate(std::span<const std::byte> /*bytes*/,
                                            const Key& /*organiser_public*/) {
  refuse();
}
std::vector<std::byte> sign(const GroupChange& /*change*/, const Key& /*organiser*/) { refuse(); }
std::optional<GroupChange> read_group_change(std::span<const std::byte> /*bytes*/,
                                             const Key& /*organiser_public*/) {
  refuse();
}

bool has_protection() { return false; }
std::unique_ptr<TcpSecurity> make_tcp_security(const TcpOptions& /*options*/) { return nullptr; }

}  // namespace tandem::net
