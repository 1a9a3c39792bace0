// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Who may be whom, as what, and for how long; in virtual time.
#include "tandem/net/membership.h"

#include <set>

#include "credentials.h"
#include "sim_world.h"
#include "support/catch.h"

namespace membership_test {

using namespace tandem::net;
using namespace protocol;
using tandem::consensus::Delivery;
using tandem::consensus::Packet;
using tandem::consensus::PeerId;

namespace {

constexpr std::uint64_t kScene = 42;
constexpr std::int64_t kToday = 1'800'000'000;  // s since 1970

Key key(std::uint64_t seed) {
  Key out{};
  seeded(seed)(out);
  return out;
}

const Key kOrganiser = key(77);

std::vector<std::byte> certificate(PeerId peer, Role role = Role::Share,
                                   std::int64_t expires = kToday + 3600,
                                   std::uint64_t session = kScene) {
  return sign({.member = identity_of(peer).public_key,
               .peer = peer,
               .role = role,
               .expires = expires,
               .session = session},
              kOrganiser);
}

/// Members with certificates, and nobody listed.
void certify(UdpNodeOptions& options) {
  options.handshake.organiser = organiser_public_key(kOrganiser);
  options.handshake.certificate = certificate(options.handshake.self);
  options.handshake.today = [] { return kToday; };
}

/// Packets that `by` has received from `from`, by role.
std::vector<Packet> drained(World& world, PeerId by, PeerId from) {
  std::vector<Packet> all;
  world.node(by).drain(all);
  std::erase_if(all, [from](const Packet& packet) { return packet.from != from; });
  return all;
}

std::string reason(World& world, PeerId at, PeerId of) { return status(world.node(at), of).reason; }

}  // namespace

TEST_CASE("membership: only the organiser's public key reads unchanged signed statements",
          "[net]") {
  const Key own = organiser_public_key(kOrganiser);
  const Certificate one{
      .member = key(1), .peer = 7, .role = Role::Act, .expires = kToday, .session = kScene};
  const auto bytes = sign(one, kOrganiser);
  CHECK(bytes.size() == kCertificateBytes);
  CHECK(read_certificate(bytes, own) == one);
  CHECK_FALSE(read_certificate(bytes, organiser_public_key(key(78))));
  CHECK_FALSE(read_certificate(bytes, Key{}));
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    auto changed = bytes;
    changed[i] ^= std::byte{1};
    CHECK_FALSE(read_certificate(changed, own));
    CHECK_FALSE(read_certificate(std::span(bytes).first(i), own));
  }
  const GroupChange change{
      .number = 3, .session = kScene, .session_key = key(2), .revoked = {key(3), key(4)}};
  const auto signed_change = sign(change, kOrganiser);
  const auto read = read_group_change(signed_change, own);
  REQUIRE(read);
  CHECK(read->number == 3);
  CHECK(read->session_key == key(2));
  CHECK(read->revoked == change.revoked);
  for (std::size_t i = 0; i < signed_change.size(); ++i) {
    auto changed = signed_change;
    changed[i] ^= std::byte{1};
    CHECK_FALSE(read_group_change(changed, own));
  }
  // Neither passes for the other.
  CHECK_FALSE(read_certificate(std::span(signed_change).first(kCertificateBytes), own));
  CHECK_THROWS(sign(GroupChange{.number = 0}, kOrganiser));
  CHECK_THROWS(sign(GroupChange{.number = 1, .revoked = std::vector<Key>(101)}, kOrganiser));
  CHECK(fingerprint(key(1)).size() == 19);
  CHECK(fingerprint(key(1)) != fingerprint(key(2)));
}

TEST_CASE("membership: a made-up id costs its maker work that is checked by one hash", "[net]") {
  std::set<std::uint64_t> stamps;
  double tries = 0.0;
  for (PeerId id = 1; id <= 20; ++id) {
    const auto own = identity_of(id).public_key;
    const std::uint64_t stamp = work_for(id, own);
    tries += static_cast<double>(stamp) / 20.0;
    CHECK(has_worked(id, own, stamp));
    // For one id and one key.
    CHECK_FALSE(has_worked(id + 1000, own, stamp));
    CHECK_FALSE(has_worked(id, identity_of(id + 1).public_key, stamp));
  }
  // The mean of 20 geometric distributions with p = 2^-14 is within half and double.
  CHECK(tries > 8192);
  CHECK(tries < 32768);
  // Without it nobody comes in.
  World world({.delay = kMs});
  world.start(1);
  world.change = [](UdpNodeOptions& options) { options.handshake.stamp = 1; };
  world.start(2).dial(address_of(1), 0);
  world.run(kSecond);
  CHECK_FALSE(linked(world, 1, 2));
  CHECK(world.node(1).strangers().refused > 0);
}

TEST_CASE("membership: a member keeps its chosen id, and a derived id is its key's",
          "[net][fault]") {
  World world({.delay = 10 * kMs});
  world.start(1);
  world.start(2).dial(address_of(1), 0);
  world.run(kSecond);
  REQUIRE(linked(world, 1, 2));
  // A member that says it is 2, from elsewhere, and started later than any other.
  HandshakeConfig liar;
  liar.self = 2;
  liar.incarnation = ~std::uint64_t{0};
  liar.scene_hash = kScene;
  liar.session_key = secret(1000);
  liar.identity = crypto::make_key_pair(seeded(9));
  liar.complete(2);
  const auto ask = [&world](const HandshakeConfig& config) {
    HandshakeInitiator initiator(config, seeded(3), 7, world.now);
    for (int i = 0; i < 300; ++i) {
      const Bytes question = copy(initiator.poll(world.now));
      if (!question.empty()) world.node(1).on_datagram(question, address_of(40), world.now);
      world.run(kMs);
      for (const Bytes& answer : world.path(address_of(1), address_of(40)).arrived(world.now)) {
        initiator.on_datagram(answer, world.now);
      }
    }
    return initiator.state() == HandshakeInitiator::State::Refused ? initiator.verdict()
                                                                   : Verdict::Welcome;
  };
  CHECK(ask(liar) == Verdict::Taken);
  CHECK(linked(world, 1, 2));
  CHECK(status(world.node(1), 2).rejected == 0);

  liar.self = derived_id(identity_of(3).public_key);
  liar.stamp = 0;
  liar.complete(liar.self);
  CHECK(ask(liar) == Verdict::NotTrusted);
  liar.self = derived_id(liar.identity.public_key);
  liar.stamp = 0;
  liar.complete(liar.self);
  CHECK(ask(liar) == Verdict::Welcome);
}

TEST_CASE("membership: an honest owner of an id is back within two seconds despite a rival",
          "[net][fault]") {
  const bool lists = GENERATE(false, true);
  const auto own = crypto::make_key_pair(seeded(900));
  // Derived, as ids are where nobody says otherwise; or listed.
  const PeerId id = lists ? PeerId{2} : derived_id(own.public_key);
  World world({.delay = 20 * kMs});
  world.change = [&](UdpNodeOptions& options) {
    if (options.handshake.self == id) options.handshake.identity = own;
    if (lists) {
      options.handshake.trusted[id] = own.public_key;
      options.handshake.trusted[1] = identity_of(1).public_key;
    }
  };
  world.move(id, address_of(2));
  world.start(1);
  HandshakeConfig liar;
  liar.self = id;
  liar.incarnation = ~std::uint64_t{0};
  liar.scene_hash = kScene;
  liar.session_key = secret(1000);
  liar.identity = crypto::make_key_pair(seeded(9));
  liar.complete(id);
  std::optional<HandshakeInitiator> attempt;
  std::uint64_t attempts = 0;
  world.watch(address_of(40));
  world.each_step = [&] {
    if (!attempt || attempt->state() == HandshakeInitiator::State::Refused) {
      attempt.emplace(liar, seeded(++attempts), 7, world.now);
    }
    const Bytes question = copy(attempt->poll(world.now));
    if (!question.empty()) world.node(1).on_datagram(question, address_of(40), world.now);
    for (const Bytes& answer : world.arrived(address_of(1), address_of(40))) {
      attempt->on_datagram(answer, world.now);
    }
  };
  // It is there before the owner is, and while it is away for a short and for a long time.
  world.run(kSecond);
  std::uint64_t incarnation = 1;
  for (const std::int64_t away : {std::int64_t{0}, 100 * kMs, 10 * kSecond}) {
    world.stop(id);
    world.run(away);
    world.start(id, ++incarnation).dial(address_of(1), world.now);
    world.run(2 * kSecond);
    CHECK(linked(world, 1, id));
    CHECK(world.node(1).connections() == 1);
  }
  CHECK(attempts > 20);
}

TEST_CASE("membership: messages for one process go to no other with its id", "[net][fault]") {
  World world({.delay = 10 * kMs});
  world.start(1);
  world.start(2, 5).dial(address_of(1), 0);
  world.run(kSecond);
  cut(world, 1, 2);
  REQUIRE(world.node(1).post(2, text("for peer 2 alone"), Delivery::Reliable, world.now));
  world.run(200 * kMs);
  world.stop(2);
  world.run(6 * kSecond);
  cut(world, 1, 2, true);
  // The id is free, and it knows the incarnation too.
  world.change = [](UdpNodeOptions& options) {
    options.handshake.identity = crypto::make_key_pair(seeded(9));
  };
  world.start(2, 5).dial(address_of(1), world.now);
  world.run(2 * kSecond);
  REQUIRE(linked(world, 1, 2));
  CHECK(drained(world, 2, 1).empty());
}

TEST_CASE("membership: a certificate admits a member in its role until it expires",
          "[net][fault]") {
  World world({.delay = 10 * kMs});
  std::int64_t today = kToday;
  world.change = [&today](UdpNodeOptions& options) {
    certify(options);
    options.handshake.today = [&today] { return today; };
    const PeerId self = options.handshake.self;
    if (self == 3) options.handshake.certificate = certificate(3, Role::Act, kToday + 10);
    if (self == 4) options.handshake.certificate = certificate(4, Role::Watch);
    if (self == 5) options.handshake.certificate = certificate(6);  // another's
    if (self == 6) options.handshake.certificate = certificate(6, Role::Share, kToday);
    if (self == 7) options.handshake.certificate = certificate(7, Role::Share, kToday + 9, 43);
    if (self == 8) options.handshake.certificate.clear();
  };
  world.start(1);
  for (PeerId peer = 2; peer <= 8; ++peer) world.start(peer).dial(address_of(1), 0);
  world.run(2 * kSecond);
  for (PeerId peer = 2; peer <= 4; ++peer) CHECK(linked(world, 1, peer));
  for (PeerId peer = 5; peer <= 8; ++peer) CHECK_FALSE(linked(world, 1, peer));
  for (PeerId peer = 2; peer <= 4; ++peer) {
    REQUIRE(world.node(peer).post(1, number(peer), Delivery::Reliable, world.now));
  }
  world.run(500 * kMs);
  std::vector<Packet> got;
  world.node(1).drain(got);
  REQUIRE(got.size() == 3);
  CHECK(got[0].role == Role::Share);
  CHECK(got[1].role == Role::Act);
  CHECK(got[2].role == Role::Watch);
  CHECK(status(world.node(1), 4).role == Role::Watch);
  // A session goes on, and 3's time is over.
  today = kToday + 10;
  world.run(kSecond);
  CHECK_FALSE(linked(world, 1, 3));
  CHECK(reason(world, 1, 3) == describe(Verdict::Expired));
  CHECK(reason(world, 3, 1).find(describe(Verdict::Expired)) != std::string::npos);
  CHECK(linked(world, 1, 2));
}

TEST_CASE("membership: a relay cannot be an end of others' connection, with listed keys or without",
          "[net][fault]") {
  // The relay is a member: it has the session key, and makes up whatever keys it likes. It plays
  // both ends towards peer 3, as from peer 1.
  const bool signed_members = GENERATE(true, false);
  World world({.delay = 10 * kMs});
  world.change = [signed_members](UdpNodeOptions& options) {
    if (signed_members) certify(options);
  };
  world.start(2);
  world.start(3).dial(address_of(2), 0);
  world.run(kSecond);
  REQUIRE(linked(world, 2, 3));
  HandshakeConfig liar;
  liar.self = 1;
  liar.incarnation = 1;
  liar.scene_hash = kScene;
  liar.session_key = secret(1000);
  liar.identity = crypto::make_key_pair(seeded(9));
  if (signed_members) {
    liar.organiser = organiser_public_key(kOrganiser);
    liar.today = [] { return kToday; };
    liar.certificate = certificate(2);  // the only one it has: its own
    liar.identity = identity_of(2);
  }
  liar.complete(1);
  HandshakeInitiator as_one(liar, seeded(4), 7, world.now);
  // The answers of 3 go to the relay, sealed for the relay.
  const Address behind = relayed_address(1);
  UdpNodeOptions three;
  three.handshake.self = 3;
  three.handshake.incarnation = 1;
  three.handshake.scene_hash = kScene;
  three.handshake.session_key = secret(1000);
  three.handshake.identity = identity_of(3);
  world.change(three);
  HandshakeResponder responder(
      three.handshake, seeded(8),
      [&](const Introduction&, const Member& member, const Address& from) {
        return is_relayed(from) && !member.bound ? Verdict::Unbound : Verdict::Welcome;
      },
      [] { return 5U; });
  three.handshake.complete(3);
  for (std::int64_t now = 0; now < kSecond; now += 10 * kMs) {
    const Bytes question = copy(as_one.poll(world.now + now));
    if (question.empty()) continue;
    const auto result = responder.on_datagram(question, behind, world.now + now);
    CHECK_FALSE(result.session);
    if (!result.reply.empty()) as_one.on_datagram(result.reply, world.now + now);
  }
  REQUIRE(as_one.state() == HandshakeInitiator::State::Refused);
  CHECK(as_one.verdict() == (signed_members ? Verdict::NotSigned : Verdict::Unbound));

  // Whole nodes: who does not reach 3 is not passed on where nothing shows who he is, and is where
  // an organiser does.
  world.start(4).dial(address_of(2), world.now);
  cut(world, 3, 4);
  world.run(8 * kSecond);
  CHECK(linked(world, 3, 4) == signed_members);
}

TEST_CASE("membership: a revoked member reads nothing from one second after, and never comes back",
          "[net][fault]") {
  World world({.delay = 40 * kMs, .jitter = 20 * kMs, .loss = 0.1});
  world.change = certify;
  for (PeerId peer = 1; peer <= 5; ++peer) {
    UdpNode& node = world.start(peer);
    for (PeerId other = 1; other < peer; ++other) node.dial(address_of(other), 0);
  }
  world.run(4 * kSecond);
  for (PeerId a = 1; a <= 5; ++a) {
    for (PeerId b = 1; b < a; ++b) REQUIRE(linked(world, a, b));
  }
  world.stop(5);  // is away when it happens
  world.run(6 * kSecond);

  std::uint64_t said = 0;
  std::uint64_t had_by_revoked = 0;
  std::map<PeerId, std::uint64_t> had;
  std::int64_t quiet_from = INT64_MAX;
  world.each_step = [&] {
    if (world.now % (16 * kMs) == 0) {
      ++said;
      for (PeerId from = 1; from <= 4; ++from) {
        for (PeerId to = 1; to <= 4; ++to) {
          if (from == to) continue;
          (void)world.node(from).post(to, number(said), Delivery::Newest, world.now);
        }
      }
    }
    for (PeerId by = 1; by <= 4; ++by) {
      std::vector<Packet> packets;
      world.node(by).drain(packets);
      had[by] += packets.size();
      if (by == 4 && world.now > quiet_from) had_by_revoked += packets.size();
    }
  };
  world.run(kSecond);
  const auto change = sign({.number = 1,
                            .session = kScene,
                            .session_key = key(2000),
                            .revoked = {identity_of(4).public_key}},
                           kOrganiser);
  CHECK(world.node(2).change_group(change, world.now) == Credentials::Changed::Yes);
  quiet_from = world.now + kSecond;
  had.clear();
  world.run(10 * kSecond);
  CHECK(had_by_revoked == 0);
  for (PeerId a = 1; a <= 3; ++a) {
    CHECK(world.node(a).credentials().group == 1);
    CHECK_FALSE(status(world.node(a), 4).connected);
    for (PeerId b = 1; b < a; ++b) CHECK(linked(world, a, b));
    CHECK(had[a] > 900);  // 1250 from two others, 10 % lost: nothing has stopped
  }
  CHECK(reason(world, 1, 4) == describe(Verdict::Revoked));
  CHECK(reason(world, 4, 1).find(describe(Verdict::Revoked)) != std::string::npos);

  // It has the old session key and its certificate, and even the new key from somewhere.
  world.each_step = [] {};
  world.stop(4);
  world.change = [](UdpNodeOptions& options) {
    certify(options);
    options.handshake.session_key = crypto::Secret(key(2000));
  };
  world.start(4, 2).dial(address_of(1), world.now);
  world.run(3 * kSecond);
  CHECK_FALSE(status(world.node(1), 4).connected);

  // A peer that was away comes back with the old key, hears of the change, and is met by all.
  world.change = certify;
  world.start(5, 2).dial(address_of(1), world.now);
  world.run(10 * kSecond);
  for (PeerId a = 1; a <= 3; ++a) CHECK(linked(world, a, 5));
  CHECK(world.node(5).credentials().group == 1);

  // And where it is the one that is dialled.
  world.stop(5);
  world.run(6 * kSecond);
  world.start(5, 3);
  world.node(2).dial(address_of(5), world.now);
  world.run(15 * kSecond);
  CHECK(linked(world, 2, 5));
}

TEST_CASE("membership: a group change that the organiser has not signed moves nobody",
          "[net][fault]") {
  World world({.delay = 10 * kMs});
  world.change = certify;
  world.start(1);
  world.start(2).dial(address_of(1), 0);
  // This one takes another's word for the organiser's, and passes it on.
  world.change = [](UdpNodeOptions& options) {
    certify(options);
    options.handshake.organiser = organiser_public_key(key(78));
    for (PeerId peer = 1; peer <= 2; ++peer) {
      options.handshake.trusted[peer] = identity_of(peer).public_key;
    }
  };
  world.start(3).dial(address_of(1), 0);
  world.run(kSecond);
  REQUIRE(linked(world, 1, 3));
  const auto forged = sign({.number = 9,
                            .session = kScene,
                            .session_key = key(5),
                            .revoked = {identity_of(2).public_key}},
                           key(78));
  CHECK(world.node(1).change_group(forged, world.now) == Credentials::Changed::Forged);
  CHECK(world.node(3).change_group(forged, world.now) == Credentials::Changed::Yes);
  world.run(kSecond);
  CHECK(world.node(1).credentials().group == 0);
  CHECK(linked(world, 1, 2));
  CHECK(reason(world, 1, 3) == "dropped: group change that the organiser has not signed");
  // An older one has no effect, nor has one of another session.
  const auto second = sign({.number = 2, .session_key = key(5)}, kOrganiser);
  const auto first = sign({.number = 1, .session_key = key(6)}, kOrganiser);
  const auto elsewhere = sign({.number = 5, .session = 43, .session_key = key(6)}, kOrganiser);
  CHECK(world.node(1).change_group(second, world.now) == Credentials::Changed::Yes);
  CHECK(world.node(1).change_group(first, world.now) == Credentials::Changed::Known);
  CHECK(world.node(1).change_group(elsewhere, world.now) == Credentials::Changed::Forged);
  CHECK(world.node(1).credentials().group == 2);
}

}  // namespace membership_test
