// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "consensus/peer_fixture.h"

/// Some peers with some bodies each, who come, go, fall silent and come back, in virtual time.
namespace tandem::consensus::testing {

inline constexpr double kTick = 1.0 / 60.0;  ///< s

/// One peer, and all that dies with it.
struct Member {
  struct Body {
    SharedId id;
    pbd::BodyId body;
  };
  Member(Transport& line, const PeerOptions& chosen) : transport(line), options(chosen) {
    restart();
  }
  void restart() {
    peer.reset();
    world = std::make_unique<pbd::World>();
    contacts = std::make_unique<tandem::testing::ToyContacts>();
    bodies.clear();
    peer = std::make_unique<Peer>(*world, transport, options);
    inside = false;
    alive = true;
  }
  pbd::BodyId share(const std::string& name, const pbd::BodyDef& def) {
    const pbd::BodyId body = world->add_body(def);
    bodies.push_back({SharedId::from_name(name), body});
    peer->share({.id = bodies.back().id, .body = body});
    return body;
  }
  const Vec3& x(std::size_t body) const { return world->pose(bodies[body].body).position; }
  const Vec3& v(std::size_t body) const { return world->twist(bodies[body].body).linear; }
  int tethers() const {
    for (const auto& block : world->blocks()) {
      if (const auto* found = dynamic_cast<const pbd::Tethers*>(block.get())) return found->size();
    }
    return 0;
  }

  Transport& transport;
  PeerOptions options;
  std::unique_ptr<pbd::World> world;
  std::unique_ptr<tandem::testing::ToyContacts> contacts;
  std::unique_ptr<Peer> peer;
  pbd::Solver solver{without_clock()};
  std::vector<Body> bodies;
  std::function<void(Member&, SessionTime)> user;           ///< acts before each step
  std::function<SessionTime(SessionTime)> clock = nullptr;  ///< session time as it is believed here
  double dt = kTick;                                        ///< s, of a step
  double pace = 1.0;                                        ///< of its world's time in session time
  SessionTime next = 0;  ///< of the world's state, and of the step to come
  SessionTime told = 0;  ///< begin of the last step by its own clock
  bool inside = false;
  bool alive = true;
};

class Crowd {
 public:
  explicit Crowd(const LinkOptions& link = {}, std::uint64_t seed = 1)
      : network(link, seed, kStart), end_(kStart), next_tick_(kStart) {}

  VirtualNetwork network;
  std::vector<std::unique_ptr<Member>> members;
  std::function<void(Member&)> build;     ///< shares the bodies of a new world
  std::function<void(SessionTime)> tick;  ///< each 1/60 s
  std::function<void(Member&)> after;     ///< after each step of each peer

  Member& add(PeerId id, const PeerOptions& options = {}) {
    Member& member =
        *members.emplace_back(std::make_unique<Member>(network.transport(id), options));
    begin(member);
    return member;
  }
  void crash(Member& member) { member.alive = false; }
  void restart(Member& member) {
    member.restart();
    begin(member);
  }
  Member& operator[](std::size_t i) { return *members[i]; }
  SessionTime now() const { return end_; }

  void run(double seconds) {
    end_ += ns(seconds);
    while (true) {
      Member* first = nullptr;
      for (const auto& m : members) {
        if (m->alive && (first == nullptr || m->next < first->next)) first = m.get();
      }
      const SessionTime turn = first != nullptr ? std::min(first->next, next_tick_) : next_tick_;
      if (turn > end_) break;
      network.advance_to(turn);
      if (turn == next_tick_) {
        next_tick_ += ns(kTick);
        if (tick) tick(turn);
      } else {
        act(*first);
      }
    }
    network.advance_to(end_);
  }

 private:
  void begin(Member& member) {
    build(member);
    // Peers' steps do not begin together.
    member.next = network.now() + ns(0.0011 * static_cast<double>(member.transport.self()));
  }
  void act(Member& member) {
    if (member.inside) {
      member.peer->after_step(member.told + ns(member.dt));
      if (after) after(member);
    }
    const SessionTime now = member.clock ? member.clock(member.next) : member.next;
    member.told = now;
    if (member.user) member.user(member, now);
    member.peer->before_step(now);
    member.solver.step(*member.world, member.dt);
    member.inside = true;
    member.next += ns(member.dt / member.pace);
  }

  SessionTime end_;
  SessionTime next_tick_;
};

/// m, largest distance between two living members' copies at the same time.
inline double spread(const Crowd& crowd, std::size_t body) {
  double most = 0.0;
  for (const auto& a : crowd.members) {
    for (const auto& b : crowd.members) {
      if (!a->alive || !b->alive || !a->inside || !b->inside) continue;
      const double ahead = 1e-9 * static_cast<double>(a->next - b->next);
      most = std::max(most, (a->x(body) - (b->x(body) + ahead * b->v(body))).norm());
    }
  }
  return most;
}

// A table with three things: a cube that rests on the ground, a ball that nothing holds, not even
// gravity, and one that somebody may carry.

inline constexpr std::size_t kCube = 0;
inline constexpr std::size_t kFree = 1;
inline constexpr std::size_t kCarried = 2;

inline void build_table(Member& member) {
  const pbd::BodyId ground = member.world->add_body({.type = pbd::BodyType::Static});
  const pbd::BodyId box = member.share("cube", cube({0.0, 0.0, kHalf.z()}));
  member.contacts->box_on_plane(ground, Vec3::UnitZ(), 0.0, box, kHalf, {});
  pbd::BodyDef free = ball({2.0, 0.0, 1.0});
  free.gravity_scale = 0.0;
  member.share("free", free);
  const pbd::BodyId carried = member.share("carried", ball({4.0, 0.0, kBallRadius}));
  member.world->set_damping(carried, 0.0, 3.0);  // it does not roll away
  member.contacts->ball_on_plane(ground, Vec3::UnitZ(), 0.0, carried, kBallRadius, {});
  member.world->set_contact_source(member.contacts.get());
}

/// Carries the third body around from `from` (s) on, on a circle half a metre up.
struct Carrier {
  double from = 0.5;
  GrabId grab = {};
  void operator()(Member& member, SessionTime now) {
    const double t = 1e-9 * static_cast<double>(now - kStart) - from;
    if (t < 0.0) return;
    const double angle = 3.0 * t;
    const double up = std::min(0.5 * t, 0.5);
    const Vec3 at(4.0 + 0.3 * std::sin(angle), 0.3 * (1.0 - std::cos(angle)), kBallRadius + up);
    if (grab == GrabId{}) {
      grab = member.peer->grab({.body = member.bodies[kCarried].id,
                                .anchor_w = at,
                                .stiffness = 300.0,
                                .damping = 25.0,
                                .max_force = 50.0});
    }
    member.peer->move(grab, at, now);
  }
};

}  // namespace tandem::consensus::testing
