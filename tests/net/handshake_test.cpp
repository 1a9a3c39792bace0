// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "handshake.h"

#include <algorithm>
#include <array>
#include <set>

#include "packet_protection.h"
#include "protocol_support.h"
#include "support/catch.h"

namespace handshake_test {

using namespace tandem::net;
using namespace protocol;

namespace {

constexpr std::uint32_t kInitiatorNumber = 11;

HandshakeConfig config(std::uint64_t peer, std::uint64_t seed) {
  HandshakeConfig out;
  out.self = peer;
  out.incarnation = 1;
  out.scene_hash = 42;
  out.session_key = secret(1000);
  out.identity = crypto::make_key_pair(seeded(seed));
  out.complete(peer);
  return out;
}

Address address(std::uint8_t last, std::uint16_t port = 4000) {
  Address out{.ip = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xff, 0xff, 10, 0, 0, last}, .port = port};
  return out;
}

/// A responder with what a mesh would give it.
struct Listener {
  HandshakeConfig own;
  std::uint32_t numbers = 100;
  Verdict verdict = Verdict::Welcome;
  HandshakeResponder responder;

  explicit Listener(const HandshakeConfig& config_in, std::uint64_t seed = 50)
      : own(config_in),
        responder(
            own, seeded(seed),
            [this](const Introduction&, const Member&, const Address&) { return verdict; },
            [this] { return ++numbers; }) {}
};

struct Outcome {
  std::optional<Session> listener;
  std::size_t sent = 0;  // by the initiator
};

/// Plays both ends until the initiator has an end, 10 ms a step, over a link that loses.
Outcome play(HandshakeInitiator& initiator, Listener& listener, const Address& from,
             std::int64_t start, double loss = 0.0, std::uint64_t seed = 1) {
  Dice dice(seed);
  Outcome out;
  for (std::int64_t now = start; now < start + 20 * kSecond; now += 10 * kMs) {
    const Bytes question = copy(initiator.poll(now));
    if (initiator.state() != HandshakeInitiator::State::Asking &&
        initiator.state() != HandshakeInitiator::State::Proving) {
      break;
    }
    if (question.empty()) continue;
    ++out.sent;
    if (dice.chance(loss)) continue;
    const auto result = listener.responder.on_datagram(question, from, now);
    CHECK(result.reply.size() <= question.size());
    if (result.session) out.listener = result.session;
    if (!result.reply.empty() && !dice.chance(loss)) initiator.on_datagram(result.reply, now);
  }
  return out;
}

bool talk(const Session& a, const Session& b) {
  PacketSealer sealer(a.send, a.remote.receiver, 0);
  PacketOpener opener(b.receive);
  Bytes datagram;
  Bytes buffer;
  return sealer.seal(text("hello"), 0, datagram) &&
         decode_protected_header(datagram)->receiver == b.local_receiver &&
         opener.open(datagram, buffer).has_value();
}

using State = HandshakeInitiator::State;

}  // namespace

TEST_CASE("handshake: two members get the same keys and know each other", "[net]") {
  const auto one = config(1, 1);
  Listener two(config(2, 2));
  HandshakeInitiator initiator(one, seeded(3), kInitiatorNumber, 0);
  const auto outcome = play(initiator, two, address(1), 0);
  REQUIRE(initiator.state() == State::Done);
  REQUIRE(outcome.listener);
  const Session& a = initiator.session();
  const Session& b = *outcome.listener;
  CHECK(a.remote.peer == 2);
  CHECK(b.remote.peer == 1);
  CHECK(a.member.key == two.own.identity.public_key);
  CHECK(b.member.key == one.identity.public_key);
  CHECK(talk(a, b));
  CHECK(talk(b, a));
  CHECK_FALSE(a.send == a.receive);
  CHECK(outcome.sent == 2);  // one round trip for the address, one for the proof
}

TEST_CASE("handshake: it gets through half of the datagrams lost", "[net][fault]") {
  // Up to five attempts of five seconds: more than 50 questions, half of a quarter lost.
  int done = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const auto one = config(1, 1);
    Listener two(config(2, 2));
    std::optional<Session> theirs;
    for (std::int64_t attempt = 0; attempt < 5; ++attempt) {
      HandshakeInitiator initiator(one, seeded(100 * seed + static_cast<std::uint64_t>(attempt)),
                                   kInitiatorNumber, attempt * 6 * kSecond);
      const auto outcome = play(initiator, two, address(1), attempt * 6 * kSecond, 0.5,
                                100 * seed + static_cast<std::uint64_t>(attempt));
      if (outcome.listener) theirs = outcome.listener;
      if (initiator.state() != State::Done) continue;
      REQUIRE(theirs);
      CHECK(talk(initiator.session(), *theirs));  // a repeated answer has the same keys
      ++done;
      break;
    }
  }
  CHECK(done == 20);
}

TEST_CASE("handshake: the listener keeps no state before the address is proved", "[net][fault]") {
  Listener two(config(2, 2));
  Dice dice(5);
  Bytes hello;
  for (int i = 0; i < 100'000; ++i) {
    encode({.type = HandshakeType::Hello, .nonce = dice.next()}, hello);
    Address from = address(0);
    for (std::size_t at = 12; at < 16; ++at) from.ip[at] = static_cast<std::uint8_t>(dice.next());
    const auto result = two.responder.on_datagram(hello, from, i * 20'000);  // 50 k per s
    REQUIRE(result.reply.size() <= hello.size());
    REQUIRE_FALSE(result.session);
  }
  CHECK(two.responder.half_open() == 0);
  CHECK(two.responder.counters().challenged == 100'000);
}

TEST_CASE("handshake: forged packets from a peer's address do not keep it out", "[net][fault]") {
  // 2000 a second of somebody who has no key and does not see what is answered.
  const auto one = config(1, 1);
  Listener two(config(2, 2));
  const Address victim = address(1);
  Dice dice(9);
  Bytes hello;
  Bytes proof;
  const std::vector<std::uint8_t> noise(150, 7);
  std::int64_t now = 0;
  const auto flood = [&] {
    encode({.type = HandshakeType::Hello, .nonce = dice.next()}, hello);
    (void)two.responder.on_datagram(hello, victim, now);
    encode({.type = HandshakeType::Initiate, .nonce = dice.next(), .noise = noise}, proof);
    const auto result = two.responder.on_datagram(proof, victim, now);
    CHECK(result.reply.empty());
  };
  for (; now < 10 * kSecond; now += kMs) flood();
  HandshakeInitiator initiator(one, seeded(3), kInitiatorNumber, now);
  const std::int64_t start = now;
  for (; now < start + kSecond; now += kMs) {
    flood();
    const Bytes question = copy(initiator.poll(now));
    if (initiator.state() == State::Done) break;
    if (question.empty()) continue;
    const Bytes reply = copy(two.responder.on_datagram(question, victim, now).reply);
    if (!reply.empty()) initiator.on_datagram(reply, now);
  }
  CHECK(initiator.state() == State::Done);
  CHECK(two.responder.counters().bad_cookie > 10'000);
}

TEST_CASE("handshake: a recorded proof proves nothing from another port, later or to another",
          "[net][fault]") {
  const auto one = config(1, 1);
  Listener two(config(2, 2));
  HandshakeInitiator initiator(one, seeded(3), kInitiatorNumber, 0);
  const Bytes hello = copy(initiator.poll(0));
  initiator.on_datagram(copy(two.responder.on_datagram(hello, address(1), 0).reply), 0);
  const Bytes recorded = copy(initiator.poll(0));
  REQUIRE(two.responder.on_datagram(recorded, address(1), 0).session);
  const auto noise = decode_handshake(recorded)->noise;

  Listener other(config(3, 4), 52);
  for (Listener* listener : {&two, &other}) {
    std::size_t sent = 0;
    std::size_t answered = 0;
    for (int i = 0; i < 10'000; ++i) {
      const std::int64_t now = i * kMs;
      const Address from =
          address(static_cast<std::uint8_t>(2 + i % 250), static_cast<std::uint16_t>(5000 + i));
      const auto cookie =
          decode_handshake(listener->responder.on_datagram(hello, from, now).reply)->cookie;
      Bytes again;
      encode({.type = HandshakeType::Initiate,
              .nonce = decode_handshake(hello)->nonce,
              .cookie = cookie,
              .noise = noise},
             again);
      const auto result = listener->responder.on_datagram(again, from, now);
      REQUIRE_FALSE(result.session);
      sent += again.size();
      answered += result.reply.size();
    }
    CHECK(answered == 0);
    CHECK(sent > 0);
  }
  CHECK(two.responder.accepted() == 1);
  CHECK(other.responder.accepted() == 0);
  CHECK(two.responder.half_open() <= 1);
}

TEST_CASE("handshake: a cookie is good for its address, its question and its time alone",
          "[net][fault]") {
  const auto one = config(1, 1);
  Listener two(config(2, 2));
  HandshakeInitiator initiator(one, seeded(3), kInitiatorNumber, 0);
  const Bytes hello = copy(initiator.poll(0));
  initiator.on_datagram(copy(two.responder.on_datagram(hello, address(1), 0).reply), 0);
  const Bytes proof = copy(initiator.poll(0));
  REQUIRE(decode_handshake(proof)->type == HandshakeType::Initiate);

  const auto refused = [&](const Bytes& datagram, const Address& from, std::int64_t now) {
    const auto result = two.responder.on_datagram(datagram, from, now);
    return result.reply.empty() && !result.session;
  };
  CHECK(refused(proof, address(2), 0));
  CHECK(refused(proof, address(1, 4001), 0));
  CHECK(refused(proof, address(1), HandshakeResponder::kCookieLife + 1));
  for (std::size_t at = 7; at < kHandshakeHeader + kCookieBytes; ++at) {
    Bytes bad = proof;
    bad[at] ^= std::byte{1};
    CHECK(refused(bad, address(static_cast<std::uint8_t>(100 + at)), 0));
  }
  Listener restarted(config(2, 2), 51);  // another cookie key
  CHECK(restarted.responder.on_datagram(proof, address(1), 0).reply.empty());
  CHECK(two.responder.accepted() == 0);
  CHECK(two.responder.half_open() == 0);
  CHECK_FALSE(refused(proof, address(1), kSecond));
}

TEST_CASE("handshake: no answer is longer than its question", "[net][fault]") {
  const auto one = config(1, 1);
  Listener two(config(2, 2));
  two.verdict = Verdict::Full;
  HandshakeInitiator initiator(one, seeded(3), kInitiatorNumber, 0);
  const Bytes hello = copy(initiator.poll(0));
  initiator.on_datagram(copy(two.responder.on_datagram(hello, address(1), 0).reply), 0);
  const Bytes proof = copy(initiator.poll(0));
  Dice dice(8);
  std::int64_t now = 0;
  std::uint64_t answers = 0;
  for (int i = 0; i < 20'000; ++i) {
    now += 100'000;
    Bytes junk = dice.chance(0.5) ? hello : proof;
    if (dice.chance(0.5)) junk.resize(dice.below(junk.size() + 40));
    if (!junk.empty() && dice.chance(0.7)) {
      junk[dice.below(junk.size())] = static_cast<std::byte>(dice.next());
    }
    const auto from = address(static_cast<std::uint8_t>(dice.below(250)));
    const auto result = two.responder.on_datagram(junk, from, now);
    REQUIRE(result.reply.size() <= junk.size());
    answers += result.reply.empty() ? 0 : 1;
  }
  CHECK(answers > 1000);
}

TEST_CASE("handshake: without the session key nobody gets an answer to his proof", "[net][fault]") {
  auto one = config(1, 1);
  one.session_key = secret(7);
  Listener two(config(2, 2));
  HandshakeInitiator initiator(one, seeded(3), kInitiatorNumber, 0);
  const auto outcome = play(initiator, two, address(1), 0);
  CHECK(initiator.state() == State::TimedOut);
  CHECK_FALSE(outcome.listener);
  CHECK(two.responder.counters().bad_proof > 0);
  CHECK(two.responder.half_open() == 0);
}

TEST_CASE("handshake: with public keys a member cannot take another's name", "[net][fault]") {
  auto one = config(1, 1);
  auto two = config(2, 2);
  auto liar = config(1, 3);  // has the session key and says it is peer 1
  one.trusted = two.trusted = {{1, one.identity.public_key}, {2, two.identity.public_key}};
  Listener listener(two);
  HandshakeInitiator good(one, seeded(3), kInitiatorNumber, 0);
  play(good, listener, address(1), 0);
  CHECK(good.state() == State::Done);

  HandshakeInitiator bad(liar, seeded(4), kInitiatorNumber, 0);
  const auto outcome = play(bad, listener, address(9), 0);
  CHECK(bad.state() == State::Refused);
  CHECK(bad.reason() == describe(Verdict::NotTrusted));
  CHECK_FALSE(outcome.listener);

  // With peer 1's public key but not its secret he gets an answer, and keys that open nothing.
  liar.identity.public_key = one.identity.public_key;
  HandshakeInitiator worse(liar, seeded(5), kInitiatorNumber, 0);
  const auto second = play(worse, listener, address(9), 0);
  CHECK(worse.state() == State::TimedOut);
  REQUIRE(second.listener);  // not confirmed, and never will be

  // And the other way round: the listener is not whom it says.
  Listener impostor(config(2, 6));
  HandshakeInitiator victim(one, seeded(6), kInitiatorNumber, 0);
  play(victim, impostor, address(1), 0);
  CHECK(victim.state() == State::Refused);
}

TEST_CASE("handshake: refusals say why at both ends", "[net][fault]") {
  const auto expect = [](const HandshakeConfig& one, Listener& two, Verdict verdict) {
    HandshakeInitiator initiator(one, seeded(3), kInitiatorNumber, 0);
    const auto outcome = play(initiator, two, address(1), 0);
    CHECK(initiator.state() == State::Refused);
    CHECK(initiator.reason() == describe(verdict));
    CHECK_FALSE(outcome.listener);
    CHECK(two.responder.counters().refused == 1);
    CHECK(two.responder.half_open() == 0);
  };
  auto other_scene = config(1, 1);
  other_scene.scene_hash = 43;
  Listener a(config(2, 2));
  expect(other_scene, a, Verdict::SceneDiffers);
  Listener b(config(2, 2));
  expect(config(2, 1), b, Verdict::SameId);
  Listener c(config(2, 2));
  c.verdict = Verdict::Full;
  expect(config(1, 1), c, Verdict::Full);
}

TEST_CASE("handshake: another version is reported, and a forged report has no effect",
          "[net][fault]") {
  const auto one = config(1, 1);
  Listener two(config(2, 2));
  HandshakeInitiator initiator(one, seeded(3), kInitiatorNumber, 0);
  Bytes forged = copy(initiator.poll(0));
  forged[0] = static_cast<std::byte>(HandshakeType::Challenge);
  forged[5] = std::byte{99};
  initiator.on_datagram(forged, 0);
  CHECK(initiator.reason() == "protocol version 99 differs from 4");
  CHECK(initiator.state() == State::Asking);
  play(initiator, two, address(1), 0);
  CHECK(initiator.state() == State::Done);

  // A question of the future is answered with our version, so that its end can say the same.
  Bytes hello;
  encode({.type = HandshakeType::Hello, .version = 99, .nonce = 5}, hello);
  const Bytes reply = copy(two.responder.on_datagram(hello, address(3), 0).reply);
  REQUIRE(decode_handshake(reply));
  CHECK(decode_handshake(reply)->version == kUdpVersion);
}

TEST_CASE("handshake: keys are never had twice, even where one end repeats its random numbers",
          "[net][fault]") {
  // A restart, a second start in one process, a virtual machine set back: end one does the same
  // again, byte for byte. End two's randomness makes the keys, and so all nonces, new.
  std::set<std::array<std::uint8_t, 32>> keys;
  const auto remember = [&keys](const crypto::Secret& key) {
    std::array<std::uint8_t, 32> bytes{};
    std::copy(key.bytes().begin(), key.bytes().end(), bytes.begin());
    keys.insert(bytes);
  };
  for (std::uint64_t run = 0; run < 50; ++run) {
    const auto one = config(1, 1);
    Listener two(config(2, 2), 1000 + run);
    HandshakeInitiator initiator(one, seeded(3), kInitiatorNumber, 0);
    play(initiator, two, address(1), 0);
    REQUIRE(initiator.state() == State::Done);
    remember(initiator.session().send);
    remember(initiator.session().receive);
  }
  for (std::uint64_t run = 0; run < 50; ++run) {
    const auto one = config(1, 1);
    Listener two(config(2, 2), 50);
    HandshakeInitiator initiator(one, seeded(5000 + run), kInitiatorNumber, 0);
    play(initiator, two, address(1), 0);
    REQUIRE(initiator.state() == State::Done);
    remember(initiator.session().send);
    remember(initiator.session().receive);
  }
  CHECK(keys.size() == 200);
}

TEST_CASE("handshake: recorded proofs are answered alike and are bounded in number",
          "[net][fault]") {
  const auto one = config(1, 1);
  Listener two(config(2, 2));
  Bytes first_reply;
  Bytes first_proof;
  for (int i = 0; i < 300; ++i) {
    const std::int64_t now = i * 2 * kMs;
    const auto from = address(static_cast<std::uint8_t>(i));
    HandshakeInitiator initiator(one, seeded(static_cast<std::uint64_t>(i)), kInitiatorNumber, now);
    const Bytes hello = copy(initiator.poll(now));
    initiator.on_datagram(copy(two.responder.on_datagram(hello, from, now).reply), now);
    const Bytes proof = copy(initiator.poll(now));
    const auto result = two.responder.on_datagram(proof, from, now);
    CHECK(result.session);
    const Bytes reply = copy(result.reply);
    const auto again = two.responder.on_datagram(proof, from, now);
    CHECK_FALSE(again.session);
    CHECK(copy(again.reply) == reply);
  }
  CHECK(two.responder.half_open() == HandshakeResponder::kMaxHalfOpen);
}

}  // namespace handshake_test
