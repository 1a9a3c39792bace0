// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// A build without libsodium.
#include "raw_peer.h"
#include "support/catch.h"
#include "tandem/net/keys.h"

namespace no_protection_test {

using namespace tandem::net;

TEST_CASE("tcp: a key is refused where nothing can be encrypted, not passed over", "[net][fault]") {
  TcpOptions options = raw::options(1);
  options.session_key.emplace().fill(7);
  CHECK_THROWS_WITH(TcpTransport(options),
                    "TcpOptions: session_key must be none in a build without libsodium, is given");
  CHECK_THROWS_AS(make_key(), std::runtime_error);
}

}  // namespace no_protection_test
