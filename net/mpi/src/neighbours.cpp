// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "neighbours.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

namespace tandem::mpi {
namespace {

/// m: contacts are reported from this distance on, and motion is not exactly predictable.
constexpr double kMargin = 0.05;

template <class Box>
void write_box(const Box& box, MessageWriter& out) {
  out.vec3(box.min);
  out.vec3(box.max);
}

}  // namespace

std::size_t Neighbours::copy_count() const {
  std::size_t count = 0;
  for (const Neighbour& neighbour : all_) count += neighbour.solves ? neighbour.bodies.size() : 0;
  return count;
}

void Neighbours::clear() {
  for (Neighbour& neighbour : all_) {
    if (!neighbour.solves) continue;
    for (const std::uint32_t slot : neighbour.bodies) part_.remove(slot);
  }
  all_.clear();
}

void Neighbours::set_boxes(double dt) {
  const pbd::World& world = part_.world();
  const double ahead = dt * refresh_every_;
  const double fall = 0.5 * world.gravity().norm() * ahead * ahead;
  boxes_.resize(world.slot_count());
  for (const std::uint32_t slot : part_.own()) {
    const pbd::BodyState& state = world.states()[slot];
    const pbd::Vec3 way = ahead * state.twist.linear;
    const bool awake = world.awake_at(slot);
    const double around = part_.radius(slot) + kMargin + (awake ? fall : 0.0);
    const pbd::Vec3& at = state.pose.position;
    boxes_[slot].min = at.cwiseMin(at + way) - pbd::Vec3::Constant(around);
    boxes_[slot].max = at.cwiseMax(at + way) + pbd::Vec3::Constant(around);
  }
}

void Neighbours::note_motion(std::span<const pbd::SolverBody> bodies) {
  for (const std::uint32_t slot : part_.own()) {
    if (outdated_) return;
    const pbd::SolverBody& body = bodies[slot];
    if (body.group == pbd::SolverBody::kNoGroup) continue;
    const pbd::Vec3 around = pbd::Vec3::Constant(part_.radius(slot) + 0.5 * kMargin);
    const Box& box = boxes_[slot];
    outdated_ = ((body.x - around).array() < box.min.array()).any() ||
                ((body.x + around).array() > box.max.array()).any();
  }
}

std::vector<Neighbours::Box> Neighbours::gather_bounds() {
  Box bounds;
  bounds.min.setConstant(std::numeric_limits<double>::max());
  bounds.max.setConstant(std::numeric_limits<double>::lowest());
  for (const std::uint32_t slot : part_.own()) {
    bounds.min = bounds.min.cwiseMin(boxes_[slot].min);
    bounds.max = bounds.max.cwiseMax(boxes_[slot].max);
  }
  Bytes bytes;
  MessageWriter out(bytes);
  write_box(bounds, out);
  std::vector<Box> all;
  for (MessageReader& in : ranks_.gather(bytes)) {
    Box& box = all.emplace_back();
    box.min = in.vec3();
    box.max = in.vec3();
  }
  return all;
}

std::vector<std::uint8_t> Neighbours::find_wanted(const std::vector<Candidate>& candidates) const {
  std::vector<std::uint8_t> wanted(candidates.size(), 0);
  if (candidates.empty()) return wanted;
  Box around = candidates[0].box;
  for (const Candidate& candidate : candidates) {
    around.min = around.min.cwiseMin(candidate.box.min);
    around.max = around.max.cwiseMax(candidate.box.max);
  }
  // Sweep along x: both lists sorted by the minima of their boxes.
  std::vector<std::uint32_t> own;
  for (const std::uint32_t slot : part_.own()) {
    if (boxes_[slot].meets(around)) own.push_back(slot);
  }
  const auto begins = [&](std::uint32_t l, std::uint32_t r) {
    return boxes_[l].min.x() < boxes_[r].min.x();
  };
  std::sort(own.begin(), own.end(), begins);
  std::vector<std::uint32_t> order(candidates.size());
  for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = i;
  std::sort(order.begin(), order.end(), [&](std::uint32_t l, std::uint32_t r) {
    return candidates[l].box.min.x() < candidates[r].box.min.x();
  });
  std::vector<std::uint32_t> open;
  std::size_t next = 0;
  for (const std::uint32_t i : order) {
    const Box& box = candidates[i].box;
    while (next < own.size() && boxes_[own[next]].min.x() <= box.max.x()) {
      open.push_back(own[next++]);
    }
    std::erase_if(open, [&](std::uint32_t slot) { return boxes_[slot].max.x() < box.min.x(); });
    wanted[i] = std::any_of(open.begin(), open.end(),
                            [&](std::uint32_t slot) { return boxes_[slot].meets(box); });
  }
  return wanted;
}

/// To the solving rank: own bodies near its bodies.
void Neighbours::offer(int to, const Box& theirs) {
  Bytes& bytes = ranks_.outgoing();
  MessageWriter out(bytes);
  for (const std::uint32_t slot : part_.own()) {
    if (!boxes_[slot].meets(theirs)) continue;
    out.put(part_.name(slot));
    write_box(boxes_[slot], out);
  }
  ranks_.send(to, Topic::Boxes);
}

/// To the offering rank: which bodies are wanted, and which are here already.
void Neighbours::answer(int from) {
  MessageReader in = ranks_.receive(from, Topic::Boxes);
  std::vector<Candidate> candidates;
  while (in.remaining() > 0 && !in.failed()) {
    Candidate& candidate = candidates.emplace_back();
    candidate.name = in.get<BodyName>();
    candidate.box.min = in.vec3();
    candidate.box.max = in.vec3();
  }
  const std::vector<std::uint8_t> wanted = find_wanted(candidates);
  Bytes& bytes = ranks_.outgoing();
  MessageWriter out(bytes);
  Neighbour neighbour{.rank = from, .bodies = {}, .told_asleep = {}, .touched = {}, .solves = true};
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    if (wanted[i] == 0) continue;
    const std::uint32_t slot = part_.slot_of(candidates[i].name);
    out.put(candidates[i].name);
    out.put<std::uint8_t>(slot != pbd::BodyId::kNone ? 1 : 0);
    neighbour.bodies.push_back(slot);
  }
  ranks_.send(from, Topic::Wanted);
  all_.push_back(std::move(neighbour));
}

/// Sends the bodies that the other rank wants and lacks.
void Neighbours::lend(Neighbour& neighbour, const std::vector<NamedContact>& carried) {
  MessageReader in = ranks_.receive(neighbour.rank, Topic::Wanted);
  Bytes records;
  std::map<BodyName, std::uint8_t> sent;
  while (in.remaining() > 0 && !in.failed()) {
    const auto name = in.get<BodyName>();
    const bool known = in.get<std::uint8_t>() != 0;
    const std::uint32_t slot = part_.slot_of(name);
    neighbour.bodies.push_back(slot);
    neighbour.told_asleep.push_back(0);
    if (known) continue;
    part_.write(slot, records);
    sent.emplace(name, std::uint8_t{1});
  }
  Bytes& bytes = ranks_.outgoing();
  MessageWriter out(bytes);
  out.put(static_cast<std::uint64_t>(sent.size()));
  bytes.insert(bytes.end(), records.begin(), records.end());
  for (const NamedContact& contact : carried) {
    if (sent.contains(contact.a) || sent.contains(contact.b)) write_contact(contact, out);
  }
  ranks_.send(neighbour.rank, Topic::Copies);
}

void Neighbours::borrow(Neighbour& neighbour, std::vector<NamedContact>& carried) {
  MessageReader in = ranks_.receive(neighbour.rank, Topic::Copies);
  auto missing = in.get<std::uint64_t>();
  for (std::uint32_t& slot : neighbour.bodies) {
    if (slot != pbd::BodyId::kNone) continue;
    slot = missing-- > 0 ? part_.read(in, true) : pbd::BodyId::kNone;
    if (slot == pbd::BodyId::kNone) Environment::abort("another rank's body cannot be copied");
  }
  while (in.remaining() > 0 && !in.failed()) carried.push_back(read_contact(in));
}

void Neighbours::refresh(double dt, std::vector<NamedContact>& carried) {
  outdated_ = false;
  set_boxes(dt);
  const std::vector<Box> bounds = gather_bounds();
  const Box& own = bounds[static_cast<std::size_t>(ranks_.rank())];
  const std::vector<Neighbour> before = std::exchange(all_, {});
  std::vector<int> near;
  for (int r = 0; r < ranks_.count(); ++r) {
    if (r != ranks_.rank() && bounds[static_cast<std::size_t>(r)].meets(own)) near.push_back(r);
  }
  for (const int r : near) {
    if (solver_of(ranks_.rank(), r) == r) offer(r, bounds[static_cast<std::size_t>(r)]);
  }
  for (const int r : near) {
    if (solver_of(ranks_.rank(), r) == r) {
      all_.push_back({.rank = r, .bodies = {}, .told_asleep = {}, .touched = {}, .solves = false});
    } else {
      answer(r);
    }
  }
  // Unwanted copies are removed before others are added, so that their memory is reused.
  std::vector<std::uint8_t> kept(part_.world().slot_count(), 0);
  for (const Neighbour& neighbour : all_) {
    for (const std::uint32_t slot : neighbour.bodies) {
      if (slot != pbd::BodyId::kNone) kept[slot] = 1;
    }
  }
  for (const Neighbour& neighbour : before) {
    if (!neighbour.solves) continue;
    for (const std::uint32_t slot : neighbour.bodies) {
      if (kept[slot] == 0) part_.remove(slot);
    }
  }
  const std::vector<NamedContact> own_carried = carried;
  for (Neighbour& neighbour : all_) {
    if (!neighbour.solves) lend(neighbour, own_carried);
  }
  for (Neighbour& neighbour : all_) {
    if (neighbour.solves) borrow(neighbour, carried);
  }
  std::erase_if(all_, [](const Neighbour& neighbour) { return neighbour.bodies.empty(); });
  boxes_.resize(part_.world().slot_count());
}

void Neighbours::update() {
  const pbd::World& world = part_.world();
  for (Neighbour& neighbour : all_) {
    if (neighbour.solves) continue;
    Bytes& bytes = ranks_.outgoing();
    MessageWriter out(bytes);
    for (std::uint32_t i = 0; i < neighbour.bodies.size(); ++i) {
      const std::uint32_t slot = neighbour.bodies[i];
      const bool asleep = !world.awake_at(slot);
      if (asleep && neighbour.told_asleep[i] != 0) continue;
      neighbour.told_asleep[i] = asleep ? 1 : 0;
      out.put(i);
      write_state(world.states()[slot], out);
      write_activity(world.activities()[slot], out);
    }
    ranks_.send(neighbour.rank, Topic::States);
  }
  for (Neighbour& neighbour : all_) {
    if (!neighbour.solves) continue;
    MessageReader in = ranks_.receive(neighbour.rank, Topic::States);
    while (in.remaining() > 0) {
      const auto i = in.get<std::uint32_t>();
      const pbd::BodyState state = read_state(in);
      const pbd::BodyActivity activity = read_activity(in);
      if (in.failed() || i >= neighbour.bodies.size()) {
        Environment::abort("another rank's message ends early");
      }
      part_.world().resume(part_.world().body_at(neighbour.bodies[i]), state, activity);
    }
  }
}

}  // namespace tandem::mpi
