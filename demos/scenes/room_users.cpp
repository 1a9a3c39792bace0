// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "scenes/room_users.h"

#include <algorithm>
#include <memory>

#include "scenes/room.h"

namespace tandem::demos {

namespace {

using pbd::Vec3;

constexpr int kRight = 1;
const Vec3 kHandOver(0.0, 0.2, 1.15);
const Vec3 kStack(1.05, 0.45, RoomScenario::kTable);
const Vec3 kSpread(0.03, 0.03, 0.0);

/// True once `condition` has held for `duration` s without a break.
Person::Act steadily(std::function<bool(Person&)> condition, double duration) {
  auto since = std::make_shared<double>(-1.0);
  return [condition = std::move(condition), duration, since](Person& me) {
    if (!condition(me)) *since = -1.0;
    if (condition(me) && *since < 0.0) *since = me.time();
    return *since >= 0.0 && me.time() >= *since + duration;
  };
}

Person::Act pause(double duration) {
  return [duration](Person& me) { return me.acting() >= duration; };
}

void until(Person& me, double time) {
  const double late = me.random().uniform(0.0, 0.15);
  me.then([time, late](Person& p) { return p.time() >= time + late; }, 60.0);
}

void walk(Person& me, const Vec3& feet) {
  me.then([feet](Person& p) {
    p.teleport(feet);
    return true;
  });
  me.then(pause(0.3));
}

/// Moves the right hand to the result of `where` at the start of the motion.
void reach(Person& me, std::function<Vec3(Person&)> where, double duration) {
  auto set_out = std::make_shared<bool>(false);
  me.then([where = std::move(where), duration, set_out](Person& p) {
    if (!*set_out) p.reach(kRight, where(p), duration);
    *set_out = true;
    return p.arrived(kRight);
  });
}

void reach_to(Person& me, const Vec3& where, double duration) {
  reach(
      me, [where](Person&) { return where; }, duration);
}

void grasp(Person& me, const std::string& name, double share_of_load, const Vec3& spread) {
  const std::size_t body = me.scene().index_of(name);
  me.then([body, share_of_load, spread](Person& p) {
    p.grasp(kRight, body, share_of_load * p.scene().mass(body), spread);
    return true;
  });
  me.then(pause(0.25));
}

void let_go(Person& me) {
  me.then([](Person& p) {
    p.let_go(kRight);
    return true;
  });
}

std::function<Vec3(Person&)> place_of(Person& me, const std::string& name) {
  const std::size_t body = me.scene().index_of(name);
  return [body](Person& p) { return p.seen(body).pose.position; };
}

std::function<Vec3(Person&)> raised(double height) {
  return [height](Person& p) { return Vec3(p.hand(kRight) + Vec3(0.0, 0.0, height)); };
}

/// Grasps a body, lifts it over, and sets it down with its centre at `place`.
void carry(Person& me, const std::string& name, const Vec3& place) {
  reach(me, place_of(me, name), 0.5);
  grasp(me, name, 1.0, kSpread);
  reach(me, raised(0.2), 0.4);
  const Vec3 sag(0.0, 0.0, GripSpec::kSag);
  reach_to(me, place + sag + Vec3(0.0, 0.0, 0.12), 0.7);
  reach_to(me, place + sag, 0.5);
  reach_to(me, place - 0.3 * sag, 0.3);  // until it stands
  me.then(pause(0.2));
  let_go(me);
  reach(me, raised(0.2), 0.3);
}

/// True if the right hand of user `whose` is seen near `place`.
bool hand_near(Person& me, std::size_t whose, const Vec3& place, double distance) {
  const std::size_t hand = me.scene().index_of("hand/" + std::to_string(whose) + "/1");
  return (me.seen(hand).pose.position - place).norm() < distance;
}

void hand_over(Person& me) {
  reach(me, place_of(me, "toy/box"), 0.7);
  grasp(me, "toy/box", 1.0, kSpread);
  reach(me, raised(0.3), 0.5);
  reach_to(me, kHandOver, 0.9);
  const auto taken = [](Person& p) { return hand_near(p, 1, p.hand(kRight), 0.12); };
  me.then(steadily(taken, 0.5), 8.0);
  let_go(me);
  reach_to(me, Vec3(-0.7, 0.0, 1.1), 0.7);
}

void take_over(Person& me) {
  const std::size_t box = me.scene().index_of("toy/box");
  const auto offered = [box](Person& p) {
    const pbd::BodyState& seen = p.seen(box);
    return (seen.pose.position - kHandOver).norm() < 0.15 && seen.twist.linear.norm() < 0.15;
  };
  me.then(steadily(offered, 0.1), 8.0);
  reach(me, place_of(me, "toy/box"), 0.6);
  grasp(me, "toy/box", 1.0, kSpread);
  const auto alone = [](Person& p) { return !hand_near(p, 0, p.hand(kRight), 0.2); };
  me.then(steadily(alone, 0.1), 8.0);
  me.then([](Person& p) {
    p.add_score("hand_overs", p.holds(kRight) ? 1.0 : 0.0);
    return true;
  });
  const Vec3 place = kStack + Vec3(0.0, 0.0, 0.5 * RoomScenario::kBox);
  const Vec3 sag(0.0, 0.0, GripSpec::kSag);
  reach_to(me, place + Vec3(0.0, 0.0, 0.25), 1.0);
  reach_to(me, place + sag, 0.6);
  reach_to(me, place - 0.3 * sag, 0.3);
  me.then(pause(0.2));
  let_go(me);
  reach(me, raised(0.2), 0.5);
}

/// Both grasp an end of the bench, wait for each other, lift it, carry it and set it down.
void carry_bench(Person& me) {
  const double side = me.user() == 0 ? -1.0 : 1.0;
  const std::size_t bench = me.scene().index_of("bench");
  // The bench's centre of mass is below its seat.
  const double seat = RoomScenario::kBench - me.scene().bodies[bench].start.z();
  const auto end_of = [bench, seat](double which) {
    return [bench, seat, which](Person& p) {
      return p.seen(bench).pose.to_world(Vec3(0.55 * which, 0.0, seat));
    };
  };
  reach(me, end_of(side), 0.7);
  const auto both = [end_of, side](Person& p) {
    return hand_near(p, 1 - p.user(), end_of(-side)(p), 0.12);
  };
  me.then(steadily(both, 0.3), 8.0);
  grasp(me, "bench", 0.5, Vec3(0.04, 0.12, 0.0));
  reach(me, raised(0.3), 1.0);
  reach(
      me, [](Person& p) { return Vec3(p.hand(kRight) + Vec3(0.0, 0.5, 0.0)); }, 1.2);
  reach(me, raised(-0.31), 1.1);
  me.then(pause(0.3));
  let_go(me);
  reach(me, raised(0.4), 0.5);
}

/// Swings the cylinder and releases it towards +x.
void throw_cylinder(Person& me) {
  reach(me, place_of(me, "toy/cylinder"), 0.8);
  grasp(me, "toy/cylinder", 1.0, kSpread);
  reach_to(me, Vec3(-1.2, 0.6, 1.2), 0.8);
  auto swung = std::make_shared<bool>(false);
  me.then([swung](Person& p) {
    if (!*swung) p.swing(kRight, Vec3(-0.5, 0.3, 1.4), Vec3(3.0, -1.5, 1.5), 0.45);
    *swung = true;
    if (!p.arrived(kRight)) return false;
    p.let_go(kRight);
    return true;
  });
  reach_to(me, Vec3(-0.8, 0.4, 1.1), 0.5);
}

}  // namespace

void room_script(Person& me) {
  if (me.user() == 0) {
    until(me, 0.8);
    walk(me, Vec3(-0.7, 0.2, 0.0));
    hand_over(me);
    until(me, 6.8);
    walk(me, Vec3(-0.8, -0.9, 0.0));
    carry_bench(me);
    walk(me, Vec3(-0.7, 0.6, 0.0));
    throw_cylinder(me);
    walk(me, Vec3(-0.5, 1.2, 0.0));
    carry(me, "toy/hull", Vec3(-0.2, 2.3, RoomScenario::kShelf + 0.04));
    return;
  }
  until(me, 1.2);
  walk(me, Vec3(0.7, 0.2, 0.0));
  take_over(me);
  until(me, 6.8);
  walk(me, Vec3(0.8, -0.9, 0.0));
  carry_bench(me);
  walk(me, Vec3(0.7, 0.4, 0.0));
  for (int k = 0; k < 4; ++k) {
    const double z = RoomScenario::kBox + (k + 0.5) * RoomScenario::kBlock;
    carry(me, "block/" + std::to_string(k), kStack + Vec3(0.0, 0.0, z));
  }
}

}  // namespace tandem::demos
