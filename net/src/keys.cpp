// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/net/keys.h"

#include "crypto.h"

namespace tandem::net {

Key make_key() {
  Key out{};
  crypto::system_random()(out);
  return out;
}

Key public_key(const Key& identity) {
  crypto::initialise();
  return crypto::public_key_of(crypto::Secret(identity));
}

}  // namespace tandem::net
