// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "rollback/replica.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "session/actor.h"
#include "tandem/pbd/math.h"
#include "tandem/pbd/portable.h"

namespace tandem::rollback_bench {

namespace {

using demos::Input;
using pbd::Vec3;

constexpr double kHandFilter = 0.025;  // s, of the low-pass on a hand's velocity

Vec3 vec3(std::span<const double> v, std::size_t at) { return {v[at], v[at + 1], v[at + 2]}; }

pbd::Pose pose(std::span<const double> v) {
  // Normalised only here: writing and reading again must not change the value.
  return {vec3(v, 0), pbd::Quat(v[6], v[3], v[4], v[5]).normalized()};
}

struct Put {
  void operator()(std::uint32_t value) { out.u32(value); }
  void operator()(std::int64_t value) { out.i64(value); }
  void operator()(double value) { out.f64(value); }
  void operator()(const Vec3& value) { out.vec3(value); }
  template <class T>
  void count(std::vector<T>& list) {
    out.u32(static_cast<std::uint32_t>(list.size()));
  }
  pbd::ByteWriter& out;
};

struct Take {
  void operator()(std::uint32_t& value) { value = in.u32(); }
  void operator()(std::int64_t& value) { value = in.i64(); }
  void operator()(double& value) { value = in.f64(); }
  void operator()(Vec3& value) { value = in.vec3(); }
  template <class T>
  void count(std::vector<T>& list) {
    list.assign(in.u32(), {});
  }
  pbd::ByteReader& in;
};

/// For writing and reading.
template <class Io>
void fields(Io io, Replica::Carried& carried) {
  const auto all = [&](auto&... values) { (io(values), ...); };
  io.count(carried.springs);
  for (Replica::Carried::Spring& s : carried.springs) {
    all(s.peer, s.user, s.number, s.row.index, s.row.generation, s.velocity, s.anchor, s.moved);
  }
  io.count(carried.driven);
  for (Replica::Carried::Driven& d : carried.driven) {
    all(d.peer, d.user, d.body, d.moved);
    for (double& value : d.values) io(value);
  }
  io.count(carried.pending);
  for (demos::Signal& signal : carried.pending) all(signal.code, signal.time);
}

}  // namespace

consensus::SessionTime frame_time(std::int64_t frame) {
  return demos::kVirtualStart + std::llround(static_cast<double>(frame) * 1e9 / kFrameHz);
}

double frame_duration(std::int64_t frame) {
  return 1e-9 * static_cast<double>(frame_time(frame + 1) - frame_time(frame));
}

Replica::Replica(const demos::Scenario& scenario, const pbd::SolverOptions& options)
    : scenario_(scenario),
      scene_(scenario.build({})),
      tethers_(&scene_.world->add_block<pbd::Tethers>()),
      solver_(options) {}

void Replica::save(Saved& out) const {
  out.world.assign(*scene_.world);
  out.carried = carried_;
}

void Replica::restore(const Saved& saved) {
  saved.world.restore(*scene_.world);
  carried_ = saved.carried;
}

std::vector<std::byte> Replica::snapshot() const {
  std::vector<std::byte> bytes;
  pbd::ByteWriter out(bytes);
  Carried carried = carried_;
  fields(Put{out}, carried);
  out.bytes(scene_.world->snapshot());
  return bytes;
}

void Replica::restore(pbd::ByteReader& in) {
  fields(Take{in}, carried_);
  scene_.world->restore(in.bytes(in.remaining()));
}

Replica::Carried::Spring* Replica::find(std::uint32_t peer, const Input& input) {
  for (Carried::Spring& s : carried_.springs) {
    if (s.peer == peer && s.user == input.user && s.number == input.object) return &s;
  }
  return nullptr;
}

Inputs Replica::predict(std::uint32_t peer, std::int64_t frame, bool go_on) const {
  const double dt = go_on ? frame_duration(frame) : 0.0;
  Inputs inputs;
  for (const Carried::Spring& spring : carried_.springs) {
    if (spring.peer != peer || spring.moved != frame - 1) continue;
    const Vec3 to = spring.anchor + dt * spring.velocity;
    inputs.push_back({.user = spring.user,
                      .kind = Input::Kind::Move,
                      .object = spring.number,
                      .values = {to.x(), to.y(), to.z()}});
  }
  for (const Carried::Driven& driven : carried_.driven) {
    if (driven.peer != peer || driven.moved != frame - 1) continue;
    Input& input =
        inputs.emplace_back(Input{.user = driven.user,
                                  .kind = Input::Kind::Drive,
                                  .object = driven.body,
                                  .body = driven.body,
                                  .values = {driven.values.begin(), driven.values.end()}});
    if (!go_on) continue;
    const pbd::Pose at = pose(driven.values);
    const pbd::Twist& twist = scene_.world->state(scene_.bodies[driven.body].body).twist;
    const Vec3 to = at.position + dt * twist.linear;
    const pbd::Quat turned = pbd::rotated(at.orientation, dt * twist.angular);
    input.values = {to.x(), to.y(), to.z(), turned.x(), turned.y(), turned.z(), turned.w()};
  }
  return rounded(inputs);
}

void Replica::apply(std::uint32_t peer, std::int64_t frame, const Inputs& inputs) {
  for (const Input& input : inputs) play(peer, frame, input);
  // Hands without input stand still.
  for (const Carried::Spring& spring : carried_.springs) {
    if (spring.peer != peer || spring.moved == frame) continue;
    pbd::Tether::Def def = tethers_->def(spring.row);
    if (def.anchor_velocity.isZero(0.0)) continue;
    def.anchor_velocity.setZero();
    tethers_->set(*scene_.world, spring.row, def);
  }
  for (const Carried::Driven& driven : carried_.driven) {
    if (driven.peer != peer || driven.moved == frame) continue;
    scene_.world->set_twist(scene_.bodies[driven.body].body, {});
  }
}

void Replica::play(std::uint32_t peer, std::int64_t frame, const Input& input) {
  const std::vector<double>& v = input.values;
  Carried::Spring* const spring = find(peer, input);
  switch (input.kind) {
    case Input::Kind::Grab:
    case Input::Kind::Hold: {
      const pbd::Tether::Def def{.body = body(input),
                                 .anchor_l = vec3(v, 0),
                                 .anchor_w = vec3(v, 3),
                                 .stiffness = v[6],
                                 .damping = v[7],
                                 .max_force = v[8]};
      carried_.springs.push_back({.peer = peer,
                                  .user = input.user,
                                  .number = input.object,
                                  .row = tethers_->add(*scene_.world, def),
                                  .anchor = def.anchor_w,
                                  .moved = frame});
      return;
    }
    case Input::Kind::Move: {
      if (spring == nullptr) return;
      pbd::Tether::Def def = tethers_->def(spring->row);
      if (spring->moved < frame) {
        const double passed =
            1e-9 * static_cast<double>(frame_time(frame) - frame_time(spring->moved));
        const double blend = 1.0 - pbd::portable::exp(-passed / kHandFilter);
        spring->velocity += blend * ((vec3(v, 0) - spring->anchor) / passed - spring->velocity);
      }
      spring->anchor = vec3(v, 0);
      spring->moved = frame;
      def.anchor_w = spring->anchor;
      def.anchor_velocity = spring->velocity;
      tethers_->set(*scene_.world, spring->row, def);
      return;
    }
    case Input::Kind::Release:
      if (spring == nullptr) return;
      tethers_->remove(spring->row);
      carried_.springs.erase(carried_.springs.begin() + (spring - carried_.springs.data()));
      return;
    case Input::Kind::Drive: {
      const double dt = frame_duration(frame);
      const pbd::Pose to = pose(v);
      const pbd::Pose& from = scene_.world->pose(body(input));
      scene_.world->set_twist(body(input),
                              {(to.position - from.position) / dt,
                               pbd::rotation_between(from.orientation, to.orientation) / dt});
      const auto known =
          std::find_if(carried_.driven.begin(), carried_.driven.end(),
                       [&](const Carried::Driven& driven) { return driven.body == input.body; });
      Carried::Driven& driven =
          known != carried_.driven.end() ? *known : carried_.driven.emplace_back();
      driven = {.peer = peer, .user = input.user, .body = input.body, .moved = frame};
      std::copy(v.begin(), v.end(), driven.values.begin());
      return;
    }
    case Input::Kind::Jump:
      scene_.world->set_pose(body(input), pose(v));
      scene_.world->set_twist(body(input), {});
      return;
    case Input::Kind::Signal:
      carried_.pending.push_back({input.object, frame_time(frame) + std::llround(1e9 * v[0])});
      return;
  }
}

void Replica::step(std::int64_t frame) {
  const consensus::SessionTime now = frame_time(frame);
  std::erase_if(carried_.pending, [&](const demos::Signal& signal) {
    if (signal.time > now) return false;
    scenario_.on_signal(scene_, signal, now);
    return true;
  });
  solver_.step(*scene_.world, frame_duration(frame));
}

}  // namespace tandem::rollback_bench
