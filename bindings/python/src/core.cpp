// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "core.h"

#include <algorithm>
#include <cstring>
#include <stdexcept>
#include <string>

#include "tandem/pbd/validate.h"

namespace tandem::python {
namespace {

void check_row(const pbd::World& world, std::uint32_t slot, const pbd::BodyState& row) {
  const std::string name = "state[" + std::to_string(slot) + "]";
  pbd::detail::require_finite(row.pose.position, name, "position");
  pbd::detail::require_unit(row.pose.orientation, name, "orientation");
  pbd::detail::require_finite(row.twist.linear, name, "velocity");
  pbd::detail::require_finite(row.twist.angular, name, "angular velocity");
  const bool still = row.twist.linear.isZero(0.0) && row.twist.angular.isZero(0.0);
  const bool fixed = world.all_props()[slot].type == BodyType::Static;
  pbd::detail::require(still || !fixed, name, "speed", row.twist.linear.norm(),
                       "zero for a static body");
}

}  // namespace

bool same_bits(std::span<const pbd::BodyState> l, std::span<const pbd::BodyState> r) {
  return std::memcmp(l.data(), r.data(), l.size_bytes()) == 0;
}

void set_rows(pbd::World& world, std::span<const pbd::BodyState> known,
              std::span<const pbd::BodyState> wanted) {
  if (same_bits(known, wanted)) return;
  const auto each_changed = [&](auto&& visit) {
    for (std::uint32_t slot = 0; slot < known.size(); ++slot) {
      if (!same_bits(known.subspan(slot, 1), wanted.subspan(slot, 1)) &&
          world.body_at(slot).valid())
        visit(slot);
    }
  };
  each_changed([&](std::uint32_t slot) { check_row(world, slot, wanted[slot]); });
  each_changed([&](std::uint32_t slot) {
    // A copy, as `wanted` may be the world's own storage.
    const pbd::BodyState row = wanted[slot];
    const BodyId id = world.body_at(slot);
    const bool moved = std::memcmp(&known[slot].pose, &row.pose, sizeof row.pose) != 0;
    const bool pushed = std::memcmp(&known[slot].twist, &row.twist, sizeof row.twist) != 0;
    if (pushed) world.set_twist(id, row.twist);
    if (moved) world.set_pose(id, row.pose);
  });
}

tandem::Scene& Core::scene() {
  if (busy_ > 0) throw std::runtime_error("the scene is being stepped by another thread");
  return file_.scene;
}

SceneFile& Core::file() {
  scene();
  return file_;
}

std::span<pbd::BodyState> Core::storage() {
  // The world's own vector, which is not const. Only arrays write to it, and set_rows() passes the
  // changes on to the world.
  const auto states = file_.scene.world().states();
  return {const_cast<pbd::BodyState*>(states.data()), states.size()};
}

py::array Core::state() {
  scene();
  const auto rows = storage();
  const auto count = static_cast<py::ssize_t>(rows.size());
  if (count == 0) return py::array_t<double>(std::vector<py::ssize_t>{0, kStateSize});
  auto owner = std::make_unique<CorePtr>(shared_from_this());
  const py::capsule base(owner.get(), [](void* pointer) {
    const std::unique_ptr<CorePtr> core(static_cast<CorePtr*>(pointer));
    --(*core)->arrays_;
  });
  static_cast<void>(owner.release());
  ++arrays_;
  if (!watched_) {
    watched_ = true;
    remember();
  }
  return py::array_t<double>(std::vector<py::ssize_t>{count, kStateSize},
                             reinterpret_cast<double*>(rows.data()), base);
}

void Core::let_in(const std::function<void()>& use) {
  struct Back {
    ~Back() { ++core.busy_; }
    Core& core;
  };
  const Back back{*this};
  --busy_;
  remember();
  use();
  scene();  // refuses if another thread has begun
  take_writes();
}

void Core::require_room(std::size_t slots) const {
  if (arrays_ == 0 || slots == this->slots()) return;
  throw py::buffer_error(
      "the number of bodies cannot change while an array of their states is alive (" +
      std::to_string(arrays_) + " of them): delete it, or copy() it, before");
}

void Core::require_room_for(std::size_t bodies) const {
  require_room(std::max(slots(), file_.scene.world().body_count() + bodies));
}

void Core::take_writes() {
  if (!watched_) return;
  const auto rows = storage();
  try {
    set_rows(file_.scene.world(), known_, rows);
  } catch (...) {
    std::copy(known_.begin(), known_.end(), rows.begin());
    throw;
  }
  for (std::uint32_t slot = 0; slot < rows.size(); ++slot) {
    if (!file_.scene.world().body_at(slot).valid()) rows[slot] = known_[slot];
  }
  watched_ = arrays_ > 0;
}

void Core::remember() {
  if (!watched_) return;
  const auto rows = storage();
  known_.assign(rows.begin(), rows.end());
}

}  // namespace tandem::python
