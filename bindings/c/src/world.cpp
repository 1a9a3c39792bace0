// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <algorithm>
#include <cstring>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "convert.h"
#include "guard.h"
#include "tandem/pbd/bytes.h"
#include "tandem/pbd/validate.h"
#include "world_impl.h"

using namespace tandem;
using namespace tandem::c;

uint32_t tandem_c_version(void) { return TANDEM_C_VERSION; }

void tandem_world_def_init(tandem_world_def* def) {
  if (def == nullptr) return;
  const pbd::SolverOptions defaults;
  *def = {.gravity = to_c(pbd::WorldDef{}.gravity),
          .substeps = defaults.substeps,
          .threads = defaults.threads,
          .sleep_after = defaults.sleep_after,
          .events = 0};
}

tandem_world* tandem_world_create(const tandem_world_def* def, tandem_error* error) {
  return made_by(error, [&] {
    const tandem_world_def& d = required(def, "def");
    return new tandem_world(std::make_shared<Scene>(options_of(d)), d.events != 0);
  });
}

void tandem_world_destroy(tandem_world* world) { delete world; }

tandem_result tandem_world_step(tandem_world* world, double dt, tandem_step_report* report,
                                tandem_error* error) {
  return guarded(error, [&] {
    tandem_world& w = required(world, "world");
    pbd::detail::require(dt >= pbd::kShortestStep && dt <= 1e6, "tandem_world_step", "dt", dt,
                         "1e-5 to 1e6 s");
    const pbd::StepReport& done = w.step(dt);
    if (report != nullptr) {
      *report = {.finite = done.status != pbd::StepStatus::NonFinite ? 1 : 0,
                 .bodies = done.bodies,
                 .awake = done.awake,
                 .targets = done.targets};
    }
  });
}

tandem_result tandem_world_set_gravity(tandem_world* world, tandem_vec3 gravity,
                                       tandem_error* error) {
  return guarded(error, [&] { required(world, "world").world.set_gravity(from_c(gravity)); });
}

uint64_t tandem_world_hash(const tandem_world* world) {
  return world != nullptr ? world->world.hash() : 0;
}

namespace {

/// The snapshot, followed by the events and their offset, so that contacts that began and ended
/// after it are reported again after restore().
std::vector<std::byte> snapshot_of(const tandem_world& w) {
  std::vector<std::byte> bytes = w.world.snapshot();
  if (!w.events) return bytes;
  const std::size_t begin = bytes.size();
  pbd::ByteWriter out(bytes);
  w.events->save(out);
  out.u64(begin);
  return bytes;
}

void restore(tandem_world& w, std::span<const std::byte> bytes) {
  if (!w.events) {
    w.world.restore(bytes);
    return;
  }
  constexpr std::size_t kTail = 8;
  const std::size_t most = bytes.size() - std::min(bytes.size(), kTail);
  const auto begin = static_cast<std::size_t>(
      std::min<std::uint64_t>(pbd::ByteReader(bytes.subspan(most)).u64(), most));
  pbd::ByteReader in(begin < most ? bytes.subspan(begin, most - begin) : bytes.first(0));
  collision::ContactEvents events;
  events.load(in);
  if (in.failed() || in.remaining() > 0) {
    pbd::detail::refuse("bytes", "a snapshot of a world that collects events");
  }
  w.world.restore(bytes.first(begin));
  w.events = std::move(events);
}

}  // namespace

tandem_result tandem_world_snapshot(const tandem_world* world, void* buffer, size_t* size,
                                    tandem_error* error) {
  bool fits = true;
  const tandem_result result = guarded(error, [&] {
    size_t& room = required(size, "size");
    const std::vector<std::byte> bytes = snapshot_of(required(world, "world"));
    fits = buffer != nullptr && bytes.size() <= room;
    if (fits) std::memcpy(buffer, bytes.data(), bytes.size());
    room = bytes.size();
  });
  if (result != TANDEM_OK || fits) return result;
  return c::report(error, TANDEM_TOO_SMALL, "buffer: must hold as many bytes as size says now");
}

tandem_result tandem_world_restore(tandem_world* world, const void* bytes, size_t size,
                                   tandem_error* error) {
  return guarded(error, [&] {
    const auto& first = required(static_cast<const std::byte*>(bytes), "bytes");
    restore(required(world, "world"), std::span(&first, size));
  });
}

namespace {

template <class Pair, class Make>
size_t copied(std::span<const Pair> from, tandem_contact* to, size_t capacity, Make&& make) {
  for (size_t i = 0; i < from.size() && i < capacity && to != nullptr; ++i) to[i] = make(from[i]);
  return from.size();
}

tandem_contact contact_of(const collision::ContactPair& pair) {
  return {to_c(pair.a), to_c(pair.b), to_c(pair.body_a), to_c(pair.body_b)};
}

tandem_contact visit_of(const collision::SensorPair& pair) {
  return {to_c(pair.sensor), to_c(pair.visitor), to_c(pair.sensor_body), to_c(pair.visitor_body)};
}

}  // namespace

size_t tandem_world_contacts(const tandem_world* world, tandem_contact_list list,
                             tandem_contact* contacts, size_t capacity) {
  if (world == nullptr || !world->events) return 0;
  const collision::ContactEvents& events = *world->events;
  switch (list) {
    case TANDEM_BEGUN:
      return copied(events.begun(), contacts, capacity, contact_of);
    case TANDEM_ENDED:
      return copied(events.ended(), contacts, capacity, contact_of);
    case TANDEM_TOUCHING:
      return copied(events.touching(), contacts, capacity, contact_of);
    case TANDEM_SENSOR_BEGUN:
      return copied(events.sensor_begun(), contacts, capacity, visit_of);
    case TANDEM_SENSOR_ENDED:
      return copied(events.sensor_ended(), contacts, capacity, visit_of);
    case TANDEM_IN_SENSOR:
      return copied(events.in_sensors(), contacts, capacity, visit_of);
  }
  return 0;
}

size_t tandem_world_hits(const tandem_world* world, tandem_hit* hits, size_t capacity) {
  if (world == nullptr || !world->events) return 0;
  const auto all = world->events->hits();
  for (size_t i = 0; i < all.size() && i < capacity && hits != nullptr; ++i) {
    hits[i] = {.contact = contact_of(all[i].pair),
               .point = to_c(all[i].point),
               .normal = to_c(all[i].normal),
               .speed = all[i].speed,
               .impulse = all[i].impulse};
  }
  return all.size();
}
