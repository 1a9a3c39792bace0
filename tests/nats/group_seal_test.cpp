// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "group_seal.h"

#include <algorithm>

#include "net/protocol_support.h"
#include "support/catch.h"

namespace tandem::nats::group_seal_test {
namespace {

using protocol::Bytes;
using protocol::seeded;

net::Credentials member(std::uint64_t key) {
  net::Credentials out;
  out.session_key = protocol::secret(key);
  return out;
}

Bytes sealed(GroupSealer& sealer, const Bytes& plain) {
  Bytes out;
  sealer.seal(plain, out);
  return out;
}

TEST_CASE("group seal: members read it once, nobody else reads, changes or repeats it",
          "[nats][fault]") {
  const net::Credentials own = member(1);
  GroupSealer sealer(own.session_key, 5, seeded(2));
  GroupOpener opener;
  const Bytes plain = protocol::text("here I am");
  const Bytes first = sealed(sealer, plain);
  const Bytes second = sealed(sealer, plain);
  CHECK(first.size() == plain.size() + kGroupOverhead);
  CHECK(std::search(first.begin(), first.end(), plain.begin(), plain.end()) == first.end());

  for (std::size_t i = 0; i < first.size(); ++i) {
    Bytes changed = first;
    changed[i] ^= std::byte{1};
    CHECK_FALSE(opener.open(changed, own).has_value());
    CHECK_FALSE(opener.open(std::span(first).first(i), own).has_value());
  }
  CHECK_FALSE(opener.open(first, member(2)).has_value());
  const auto opened = opener.open(first, own);
  REQUIRE(opened.has_value());
  CHECK(opened->sender == 5);
  CHECK(Bytes(opened->plain.begin(), opened->plain.end()) == plain);
  CHECK_FALSE(opener.open(first, own).has_value());
  CHECK(opener.open(second, own).has_value());
  CHECK_FALSE(opener.open(first, own).has_value());
}

TEST_CASE("group seal: two processes of one peer have keys of their own", "[nats]") {
  const net::Credentials own = member(1);
  GroupSealer before(own.session_key, 5, seeded(2));
  GroupSealer after(own.session_key, 5, seeded(3));
  GroupOpener opener;
  const Bytes plain = protocol::text("here I am");
  const Bytes first = sealed(before, plain);
  const Bytes second = sealed(after, plain);
  CHECK(Bytes(first.begin() + kGroupHeader, first.end()) !=
        Bytes(second.begin() + kGroupHeader, second.end()));
  CHECK(opener.open(first, own).has_value());
  CHECK(opener.open(second, own).has_value());
}

TEST_CASE("group seal: after a change of the key the former one opens, and another does not",
          "[nats]") {
  net::Credentials own = member(1);
  GroupSealer old(own.session_key, 5, seeded(2));
  GroupSealer fresh(protocol::secret(9), 6, seeded(3));
  GroupOpener opener;
  CHECK(opener.open(sealed(old, protocol::text("a")), own).has_value());
  own.former = {own.session_key};
  own.session_key = protocol::secret(9);
  own.group = 1;
  CHECK(opener.open(sealed(old, protocol::text("b")), own).has_value());
  CHECK(opener.open(sealed(fresh, protocol::text("c")), own).has_value());
  own.former.clear();
  own.group = 2;
  CHECK_FALSE(opener.open(sealed(old, protocol::text("d")), own).has_value());
}

TEST_CASE("group seal: memory for senders has an end", "[nats][fault]") {
  const net::Credentials own = member(1);
  GroupOpener opener;
  for (std::uint64_t id = 1; id <= GroupOpener::kMaxSenders + 100; ++id) {
    GroupSealer sealer(own.session_key, id, seeded(id));
    CHECK(opener.open(sealed(sealer, protocol::text("x")), own).has_value());
  }
  CHECK(opener.senders() == GroupOpener::kMaxSenders);
}

}  // namespace
}  // namespace tandem::nats::group_seal_test
