// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/net/keys.h"

#include <algorithm>

#include "guard.h"

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
    net::Key secret{};
    std::ranges::copy(required(identity, "identity").bytes, secret.begin());
    tandem_key& out = required(key, "key");
    std::ranges::copy(net::public_key(secret), out.bytes);
  });
}
