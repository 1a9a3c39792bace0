// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// What members make, remove, and know of each other while a session runs, in virtual time.
#include <cmath>
#include <map>
#include <memory>
#include <random>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "support/bodies.h"
#include "support/catch.h"
#include "tandem/consensus/virtual_network.h"
#include "tandem/session.h"

namespace spawn_test {

using namespace tandem;
using pbd::Vec3;
using tandem::testing::names;
using tandem::testing::refusal;

constexpr SessionTime kStep = 16'666'667;   // ns
constexpr SessionTime kStart = 60 * kStep;  // ns

/// A member whose world holds what has been spawned, and nothing else.
struct Member {
  Member(consensus::Transport& transport, SpawnOptions limits = {})
      : session({world, solver}, transport, {.spawning = options(std::move(limits))}) {
    session.on_join([this](PeerId id) { joined.push_back(id); });
    session.on_leave([this](PeerId id) { left.push_back(id); });
  }
  SpawnOptions options(SpawnOptions limits) {
    limits.make = [this](std::string_view what) {
      if (what == "nothing") return pbd::BodyId{};
      if (!what.starts_with("ball")) throw std::invalid_argument("no such thing");
      const pbd::BodyId body = world.add_body({});
      made[body.index] = std::string(what);
      return body;
    };
    limits.remove = [this](pbd::BodyId body) {
      made.erase(body.index);
      world.remove_body(body);
    };
    return limits;
  }
  pbd::Pose pose(const SharedId& id) { return world.pose(session.peer().body_of(id)); }
  bool has(const SharedId& id) { return world.contains(session.peer().body_of(id)); }

  pbd::World world{testing::weightless()};
  pbd::Solver solver;
  std::map<std::uint32_t, std::string> made;  // by index in the world
  std::vector<PeerId> joined, left;
  Session session;
};

struct Fixture {
  explicit Fixture(int peers) : network({.latency = 0.05, .jitter = 0.005}, 1, kStart) {
    for (int i = 1; i <= peers; ++i) network.transport(static_cast<PeerId>(i));
  }
  consensus::Transport& transport(PeerId peer) { return network.transport(peer); }
  void advance(int steps, const std::vector<Member*>& members) {
    for (int i = 0; i < steps; ++i) {
      network.advance_to(network.now() + kStep);
      for (Member* const member : members) member->session.advance(network.now());
    }
  }
  void cut(PeerId a, PeerId b) {
    network.cut(a, b);
    network.cut(b, a);
  }
  void heal(PeerId a, PeerId b) {
    network.heal(a, b);
    network.heal(b, a);
  }
  consensus::VirtualNetwork network;
};

TEST_CASE("spawn: a body made by one member is at all until any member removes it", "[session]") {
  Fixture f(3);
  Member one(f.transport(1)), two(f.transport(2)), three(f.transport(3));
  const std::vector<Member*> all = {&one, &two, &three};
  f.advance(60, all);
  const pbd::Pose at{.position = Vec3(1.0, 2.0, 3.0)};
  const SharedId id = one.session.spawn("ball 7", at, {.linear = Vec3(0.5, 0.0, 0.0)});
  CHECK(one.has(id));
  f.advance(120, all);
  for (Member* const member : all) {
    REQUIRE(member->made.size() == 1);
    CHECK(member->made.begin()->second == "ball 7");
    // It has gone on for two seconds everywhere, as fast as it was made, and copies agree.
    const Vec3 velocity = member->world.twist(member->session.peer().body_of(id)).linear;
    CHECK((velocity - Vec3(0.5, 0.0, 0.0)).norm() < 1e-6);
    CHECK(std::abs(member->pose(id).position.x() - 2.0) < 0.06);
    CHECK((member->pose(id).position - one.pose(id).position).norm() < 1e-3);
  }
  // It is held by a hand as any shared body is.
  const GrabId grab = two.session.grab({.body = id});
  f.advance(10, all);
  CHECK(one.session.peer().held(id));
  two.session.move(grab, Vec3(1.0, 2.0, 3.0));
  two.session.release(grab);
  three.session.despawn(id);
  f.advance(10, all);
  for (Member* const member : all) {
    CHECK(member->made.empty());
    CHECK_FALSE(member->has(id));
    CHECK(member->session.spawns_refused() == 0);
  }
  CHECK(names(refusal([&] { three.session.despawn(id); }), "despawn", id.to_string(), "spawned"));
}

TEST_CASE("spawn: a newcomer has all there is where it is now, and nothing that is gone",
          "[session]") {
  Fixture f(3);
  Member one(f.transport(1)), two(f.transport(2));
  f.cut(1, 3);
  f.cut(2, 3);
  f.advance(60, {&one, &two});
  std::vector<SharedId> kept;
  for (int i = 0; i < 40; ++i) {
    Member& maker = i % 2 == 0 ? one : two;
    const SharedId id =
        maker.session.spawn("ball", {.position = Vec3(i, 0.0, 0.0)}, {.linear = Vec3(0, 0.2, 0)});
    f.advance(1, {&one, &two});
    if (i % 4 == 3) {
      f.advance(10, {&one, &two});
      one.session.despawn(id);
    } else {
      kept.push_back(id);
    }
  }
  f.advance(60, {&one, &two});
  f.heal(1, 3);
  f.heal(2, 3);
  Member three(f.transport(3));
  f.advance(90, {&one, &two, &three});
  CHECK(three.joined == std::vector<PeerId>{1, 2});
  CHECK(three.made.size() == kept.size());
  for (const SharedId& id : kept) {
    REQUIRE(three.has(id));
    CHECK((three.pose(id).position - one.pose(id).position).norm() < 2e-3);
  }
  for (Member* const member : {&one, &two, &three}) CHECK(member->session.spawns_refused() == 0);
}

TEST_CASE("spawn: halves that meet have the bodies of both, without those removed in either",
          "[session][fault]") {
  Fixture f(2);
  Member one(f.transport(1)), two(f.transport(2));
  f.advance(30, {&one, &two});
  std::vector<SharedId> common;
  for (int i = 0; i < 3; ++i) common.push_back(one.session.spawn("ball", {}));
  f.advance(30, {&one, &two});
  f.cut(1, 2);
  f.advance(30, {&one, &two});
  CHECK(one.left == std::vector<PeerId>{2});
  const SharedId of_one = one.session.spawn("ball", {});
  const SharedId of_two = two.session.spawn("ball", {});
  two.session.despawn(common[0]);
  one.session.despawn(common[1]);
  f.advance(65 * 60, {&one, &two});  // longer than what is sent to them is kept
  f.heal(1, 2);
  f.advance(60, {&one, &two});
  CHECK(one.joined == std::vector<PeerId>{2, 2});
  for (Member* const member : {&one, &two}) {
    CHECK(member->made.size() == 3);
    CHECK_FALSE(member->has(common[0]));
    CHECK_FALSE(member->has(common[1]));
    CHECK(member->has(common[2]));
    CHECK(member->has(of_one));
    CHECK(member->has(of_two));
  }
}

TEST_CASE("spawn: members that are cut off, leave and start again end with the same bodies",
          "[session][property][long]") {
  for (std::uint32_t seed = 1; seed <= 8; ++seed) {
    constexpr int kMembers = 3;
    std::mt19937 random(seed);
    Fixture f(kMembers);
    std::vector<std::unique_ptr<Member>> members(kMembers);
    const auto start = [&](std::size_t i) {
      members[i].reset();
      members[i] = std::make_unique<Member>(f.transport(i + 1));
    };
    const auto with_all_others = [&](std::size_t i, const auto& change) {
      for (std::size_t k = 0; k < kMembers; ++k) {
        if (k != i) change(i + 1, k + 1);
      }
    };
    for (std::size_t i = 0; i < kMembers; ++i) start(i);
    std::vector<SharedId> ids;
    std::vector<GrabId> grabs(kMembers);
    for (int step = 0; step < 3000; ++step) {
      f.advance(1, {members[0].get(), members[1].get(), members[2].get()});
      if (step >= 2000) {
        for (std::size_t i = 0; i < kMembers; ++i) {
          with_all_others(i, [&](PeerId a, PeerId b) { f.network.heal(a, b); });
        }
        continue;
      }
      const std::size_t i = random() % kMembers;
      Session& session = members[i]->session;
      if (random() % 30 == 0) ids.push_back(session.spawn("ball", {}));
      const SharedId any = ids.empty() ? SharedId{} : ids[random() % ids.size()];
      if (random() % 40 == 0 && members[i]->has(any)) session.despawn(any);
      // Whatever the others remove, a hand that held it goes on without an error.
      if (random() % 40 == 0 && members[i]->has(any)) grabs[i] = session.grab({.body = any});
      session.move(grabs[i], Vec3(0.1, 0.0, 0.0));
      if (random() % 40 == 0) session.release(grabs[i]);
      if (random() % 300 == 0) with_all_others(i, [&](PeerId a, PeerId b) { f.cut(a, b); });
      if (random() % 200 == 0) with_all_others(i, [&](PeerId a, PeerId b) { f.heal(a, b); });
      if (random() % 500 == 0) start(i);
    }
    INFO("seed " << seed);
    std::size_t there = 0;
    for (const SharedId& id : ids) {
      const bool has = members[0]->has(id);
      there += has ? 1 : 0;
      CHECK(members[1]->has(id) == has);
      CHECK(members[2]->has(id) == has);
    }
    CHECK(there > 5);
    for (const auto& member : members) {
      CHECK(member->made.size() == there);
      CHECK(member->session.spawns_refused() == 0);
    }
  }
}

TEST_CASE("spawn: an invalid spawn is refused and leaves nothing", "[session][fault]") {
  Fixture f(3);
  Member one(f.transport(1), {.max_of_one = 3});
  Session& session = one.session;
  const auto bodies = [&] { return one.world.body_count(); };
  CHECK(names(refusal([&] { session.spawn("cube", {}); }), "no such thing", "", ""));
  CHECK(names(refusal([&] { session.spawn("nothing", {}); }), "SpawnOptions::make",
              "a body of the world", ""));
  CHECK(names(refusal([&] { session.spawn("ball", {.position = Vec3(NAN, 0.0, 0.0)}); }),
              "position", "finite", ""));
  const std::string longest = "ball" + std::string(SpawnOptions::kMaxBytes - 4, '.');
  CHECK(names(refusal([&] { session.spawn(longest + ".", {}); }), "what", "513", "kMaxBytes"));
  CHECK(bodies() == 0);
  for (int i = 0; i < 3; ++i) session.spawn("ball", {});
  CHECK(names(refusal([&] { session.spawn("ball", {}); }), "number of bodies", "max_of_one", ""));
  CHECK(bodies() == 3);
  Member few(f.transport(3), {.max_bodies = 1});
  few.session.spawn("ball", {});
  CHECK(
      names(refusal([&] { few.session.spawn("ball", {}); }), "number of bodies", "max_bodies", ""));

  pbd::World world;
  pbd::Solver solver;
  Session plain({world, solver}, f.transport(2));
  CHECK(names(refusal([&] { plain.spawn("ball", {}); }), "spawning.make", "set", ""));
  CHECK(
      names(refusal([&] { plain.share("", world.add_body({})); }), "name", "empty", "1 character"));
  pbd::World other;
  SessionOptions half;
  half.spawning.make = [](std::string_view) { return pbd::BodyId{}; };
  CHECK(names(refusal([&] {
                Session third({other, solver}, f.transport(2), half);
              }),
              "make and remove", "make alone", "both set"));
}

/// The payload of a "tandem.spawn".
std::vector<std::byte> spawn_bytes(const SharedId& id, std::string_view what) {
  const consensus::StateUpdate state{.id = id, .stamp = 1};
  std::vector<std::byte> bytes;
  consensus::encode({&state, 1}, bytes);
  for (const char c : what) bytes.push_back(static_cast<std::byte>(c));
  return bytes;
}

TEST_CASE("spawn: a member that floods gets its share of bodies at most", "[session][fault]") {
  Fixture f(3);
  Member one(f.transport(1), {.max_of_one = 8}), two(f.transport(2), {.max_of_one = 8});
  pbd::World world{testing::weightless()};
  pbd::Solver solver;
  Session liar({world, solver}, f.transport(3));
  const auto advance = [&](int steps, const Session::BeforeStep& lie) {
    for (int i = 0; i < steps; ++i) {
      f.network.advance_to(f.network.now() + kStep);
      for (Member* const member : {&one, &two}) member->session.advance(f.network.now());
      liar.advance(f.network.now(), lie);
    }
  };
  advance(30, [&](SessionTime) { liar.events().send("tandem.told", {}); });
  const SharedId honest = one.session.spawn("ball", {});
  advance(30, {});
  REQUIRE(two.has(honest));
  const auto honest_id = [&](std::uint64_t number) {
    return SharedId{.high = 3, .low = honest.low + number};
  };

  std::mt19937_64 random(5);
  std::vector<std::byte> mutated;
  advance(600, [&](SessionTime) {
    for (int i = 0; i < 8; ++i) {
      mutated = spawn_bytes(honest_id(random() % 64), "ball");
      for (std::uint64_t k = random() % 4; k-- > 0;) {
        mutated[random() % mutated.size()] = static_cast<std::byte>(random());
      }
      if (random() % 4 == 0) mutated.resize(random() % mutated.size());
      liar.events().send("tandem.spawn", mutated);
      mutated.resize(random() % 40);
      for (std::byte& byte : mutated) byte = static_cast<std::byte>(random());
      liar.events().send("tandem.despawn", mutated);
      liar.events().send("tandem.ask", {});
    }
    // In another's name, and of the name of what is shared later.
    liar.events().send("tandem.spawn", spawn_bytes({.high = 2, .low = honest.low + 1}, "ball"));
    liar.events().send("tandem.spawn", spawn_bytes(SharedId::from_name("door"), "ball"));
    liar.events().send("tandem.spawn", spawn_bytes(honest_id(100), "bomb"));
  });
  for (Member* const member : {&one, &two}) {
    CHECK(member->has(honest));
    CHECK(member->made.size() >= 2);
    CHECK(member->made.size() <= 1 + 2 * 8);
    CHECK(member->session.spawns_refused() > 1000);
    CHECK_FALSE(member->has({.high = 2, .low = honest.low + 1}));
    CHECK_NOTHROW(member->session.share("door", member->world.add_body({})));
  }
  // Honest members go on as if nothing were.
  const SharedId next = two.session.spawn("ball", {});
  advance(30, {});
  CHECK(one.has(next));
}

TEST_CASE("spawn: an exception of a function loses no other spawn", "[session][fault]") {
  Fixture f(3);
  Member one(f.transport(1)), two(f.transport(2));
  bool fails = true;
  pbd::World world{testing::weightless()};
  pbd::Solver solver;
  SessionOptions options;
  options.spawning = two.options({});
  options.spawning.make = [&](std::string_view) {
    if (std::exchange(fails, false)) throw std::runtime_error("mine");
    return world.add_body({});
  };
  options.spawning.remove = [&](pbd::BodyId body) { world.remove_body(body); };
  Session three({world, solver}, f.transport(3), options);
  const auto advance = [&](int steps) {
    int thrown = 0;
    for (int i = 0; i < steps; ++i) {
      f.advance(1, {&one, &two});
      try {
        three.advance(f.network.now());
      } catch (const std::runtime_error&) {
        ++thrown;
      }
    }
    return thrown;
  };
  CHECK(advance(30) == 0);
  for (int i = 0; i < 3; ++i) one.session.spawn("ball", {});
  CHECK(advance(30) == 1);
  CHECK(two.made.size() == 3);
  CHECK(world.body_count() == 2);
}

TEST_CASE("spawn: a step is no place for another one", "[session][fault]") {
  Fixture f(2);
  Member one(f.transport(1)), two(f.transport(2));
  one.session.on_join([&](PeerId) { one.session.advance(f.network.now() + kStep); });
  two.session.on_join([&](PeerId id) {  // it may take itself away
    two.session.on_join({});
    two.joined.push_back(id);
  });
  f.network.advance_to(f.network.now() + kStep);
  one.session.advance(f.network.now());
  f.network.advance_to(f.network.now() + kStep);
  CHECK(names(refusal([&] { one.session.advance(f.network.now()); }), "Session::advance",
              "none of the functions", ""));
  one.session.on_join({});
  f.advance(10, {&one, &two});
  CHECK(two.joined == std::vector<PeerId>{1});
}

TEST_CASE("spawn: a body removed before it arrives is gone at its maker too", "[session][fault]") {
  Fixture f(3);
  Member one(f.transport(1)), two(f.transport(2));
  pbd::World world{testing::weightless()};
  pbd::Solver solver;
  Session liar({world, solver}, f.transport(3));
  const auto advance = [&](int steps) {
    for (int i = 0; i < steps; ++i) {
      f.advance(1, {&one, &two});
      liar.advance(f.network.now());
    }
  };
  advance(30);
  const SharedId first = one.session.spawn("ball", {});
  // Ids go by time, so that one can be guessed.
  const SessionTime then = f.network.now() + 60 * kStep;
  const auto passed = static_cast<std::uint64_t>(then / 1000 - f.network.now() / 1000);
  const SharedId guess{.high = first.high, .low = first.low + passed};
  std::vector<std::byte> bytes;
  for (const std::uint64_t half : {guess.high, guess.low}) {
    for (int shift = 0; shift < 64; shift += 8) {
      bytes.push_back(static_cast<std::byte>(half >> shift));
    }
  }
  liar.events().send("tandem.despawn", bytes, 2);
  advance(60);
  CHECK(one.session.spawn("ball", {}) == guess);
  advance(30);
  CHECK(two.has(first));
  CHECK_FALSE(two.has(guess));
  CHECK_FALSE(one.has(guess));
}

TEST_CASE("spawn: members are called as they come and go, once each", "[session]") {
  Fixture f(2);
  Member one(f.transport(1));
  f.cut(1, 2);
  f.advance(30, {&one});
  CHECK(one.joined.empty());
  for (int i = 1; i <= 3; ++i) {
    f.heal(1, 2);
    f.advance(30, {&one});
    CHECK(one.joined.size() == static_cast<std::size_t>(i));
    f.cut(2, 1);
    f.advance(30, {&one});
    CHECK(one.left == one.joined);
  }
}

}  // namespace spawn_test
