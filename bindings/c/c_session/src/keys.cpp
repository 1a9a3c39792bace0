// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/net/keys.h"

#include <algorithm>

#include "guard.h"
#include "session_impl.h"
#include "tandem/net/membership.h"

using namespace tandem;
using namespace tandem::c;

tandem_result tandem_key_make(tandem_key* key, tandem_error* error) {
  return guarded(error, [&] {
    tandem_key& out = required(key, "key");
    std::ranges::copy(net::make_key(), out.bytes);
  });
}

tandem_result tandem_key_public(const tandem_key* identity, tandem_key* key, tandem_error* error) {
  return guarded(error, [&] {
    const net::Key secret = key_of(required(identity, "identity"));
    tandem_key& out = required(key, "key");
    std::ranges::copy(net::public_key(secret), out.bytes);
  });
}

uint64_t tandem_key_peer(const tandem_key* public_key) {
  uint64_t id = 0;
  guarded(nullptr, [&] { id = net::derived_id(key_of(required(public_key, "public_key"))); });
  return id;
}
