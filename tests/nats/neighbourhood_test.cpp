// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Who connects to whom, in a crowd that walks, without a network.
#include "neighbourhood.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "support/catch.h"
#include "tandem/pbd/random.h"

namespace tandem::nats::neighbourhood_test {
namespace {

using consensus::PeerId;
using pbd::Vec3;

constexpr std::int64_t kTick = 100'000'000;

/// People who hear of each other what they say ten times a second, wherever they are.
class Crowd {
 public:
  Crowd(std::size_t count, double side, const CellOptions& options)
      : options_(options), side_(side) {
    for (std::size_t i = 0; i < count; ++i) {
      const PeerId id = i + 1;
      places_[id] = {dice_.uniform(0.0, side), dice_.uniform(0.0, side), 0.0};
      hoods_.emplace(id, Neighbourhood(options, id));
    }
  }

  void step(double speed) {
    now_ += kTick;
    for (auto& [id, place] : places_) {
      heading_[id] += dice_.uniform(-0.3, 0.3);
      place += 0.1 * speed * Vec3(std::cos(heading_[id]), std::sin(heading_[id]), 0.0);
      place.x() = std::clamp(place.x(), 0.0, side_);
      place.y() = std::clamp(place.y(), 0.0, side_);
      hoods_.at(id).move(place);
    }
    for (auto& [id, hood] : hoods_) {
      for (const auto& [other, place] : places_) {
        if (!hood.listens_to(cell_at(options_, place))) continue;
        hood.hear(other, {.position = place, .hears = hoods_.at(other).hears()}, now_);
      }
    }
    for (auto& [id, hood] : hoods_) {
      const auto& changes = hood.update(true, now_);
      for (const PeerId peer : changes.meet) {
        CHECK(met_[id].insert(peer).second);
        ++meetings_;
      }
      for (const PeerId peer : changes.part) CHECK(met_[id].erase(peer) == 1);
      listened_ += changes.listen.size();
    }
  }

  CellOptions options_;
  double side_;
  std::int64_t now_ = 0;
  std::map<PeerId, Vec3> places_;
  std::map<PeerId, double> heading_;
  std::map<PeerId, Neighbourhood> hoods_;
  std::map<PeerId, std::set<PeerId>> met_;
  std::size_t meetings_ = 0;
  std::size_t listened_ = 0;
  pbd::SplitMix64 dice_{5};
};

TEST_CASE("neighbourhood: near peers alone are met, from both ends", "[nats]") {
  const CellOptions options{.edge = 4.0, .levels = 3, .near = 5.0, .slack = 0.5, .max_near = 64};
  Crowd crowd(120, 40.0, options);
  for (int i = 0; i < 300; ++i) crowd.step(1.4);
  std::size_t pairs = 0;
  for (const auto& [id, place] : crowd.places_) {
    for (const auto& [other, there] : crowd.places_) {
      if (other == id) continue;
      const double apart = (place - there).norm();
      const bool met = crowd.met_[id].contains(other);
      // A step of one tick is heard in the next one.
      if (apart < options.near - 0.3) CHECK(met);
      if (apart > options.near + options.slack + 0.3) CHECK_FALSE(met);
      pairs += met ? 1 : 0;
    }
  }
  CHECK(pairs > 500);
}

TEST_CASE("neighbourhood: at most about as many as the limit are met, the nearest", "[nats]") {
  const CellOptions options{.edge = 4.0, .levels = 2, .near = 8.0, .slack = 0.5, .max_near = 8};
  Crowd crowd(150, 20.0, options);  // seventy of them within hearing
  for (int i = 0; i < 200; ++i) crowd.step(1.4);
  std::size_t sum = 0;
  for (const auto& [id, met] : crowd.met_) {
    CHECK(met.size() <= options.max_near + 8);
    sum += met.size();
    double nearest = 1e9;
    PeerId who = 0;
    for (const auto& [other, there] : crowd.places_) {
      const double apart = (there - crowd.places_[id]).norm();
      if (other != id && apart < nearest) nearest = apart, who = other;
    }
    const double heard = std::min(crowd.hoods_.at(id).hears(), crowd.hoods_.at(who).hears());
    if (nearest < heard - 0.3) CHECK(met.contains(who));
  }
  const double mean = static_cast<double>(sum) / 150.0;
  CHECK(mean > 4.0);
  CHECK(mean < 11.0);
}

TEST_CASE("neighbourhood: hysteresis keeps walkers along a border from coming and going",
          "[nats]") {
  const CellOptions options{.edge = 4.0, .levels = 3, .near = 4.0, .slack = 1.0};
  Neighbourhood hood(options, 1);
  std::int64_t now = 0;
  std::size_t listened = 0;
  std::size_t met = 0;
  for (int i = 0; i < 400; ++i) {
    now += kTick;
    // Half a metre to and fro over an edge of cells, and over the edge of hearing.
    hood.move(Vec3(i % 2 == 0 ? -0.25 : 0.25, 0.0, 0.0));
    hood.hear(2, {.position = Vec3(4.0, 0.0, 0.0), .hears = 100.0}, now);
    const auto& changes = hood.update(true, now);
    if (i > 1) listened += changes.listen.size() + changes.unlisten.size();
    met += changes.meet.size() + changes.part.size();
  }
  CHECK(listened == 0);
  CHECK(met == 1);
}

TEST_CASE("neighbourhood: silent peers are gone, but none while there is no server", "[nats]") {
  const CellOptions options{.edge = 4.0, .near = 4.0};
  Neighbourhood hood(options, 1);
  std::int64_t now = kTick;
  hood.hear(2, {.position = Vec3(1.0, 0.0, 0.0), .hears = 10.0}, now);
  hood.hear(3, {.position = Vec3(5.5, 0.0, 0.0), .hears = 10.0}, now);
  CHECK(hood.update(true, now).meet == std::vector<PeerId>{2});
  CHECK(hood.contacts() == 2);
  for (; now < 60'000'000'000; now += kTick) CHECK(hood.update(false, now).empty());
  CHECK(hood.contacts() == 2);
  const std::int64_t back = now;
  bool parted = false;
  for (; now < back + Neighbourhood::kForget + 2 * kTick; now += kTick) {
    parted = parted || !hood.update(true, now).part.empty();
  }
  CHECK(parted);
  CHECK(hood.contacts() == 0);
}

TEST_CASE("neighbourhood: a slow peer hears fewer, and never nobody", "[nats]") {
  const CellOptions options{.edge = 4.0, .near = 8.0, .slack = 0.5, .max_near = 16, .min_near = 3};
  Neighbourhood hood(options, 1);
  std::int64_t now = 0;
  const auto run = [&](int ticks) {
    for (int i = 0; i < ticks; ++i) {
      now += kTick;
      for (PeerId id = 2; id < 14; ++id) {
        hood.hear(id,
                  {.position = Vec3(0.6 * static_cast<double>(id - 1), 0.0, 0.0), .hears = 100.0},
                  now);
      }
      hood.update(true, now);
    }
  };
  run(3);
  CHECK(hood.met() == 12);
  for (int i = 0; i < 20; ++i) hood.lower_limit();
  run(3);
  CHECK(hood.limit() == 3);
  CHECK(hood.met() >= 3);
  CHECK(hood.met() <= 5);
  for (int i = 0; i < 20; ++i) hood.raise_limit();
  run(3);
  CHECK(hood.met() == 12);
}

TEST_CASE("neighbourhood: memory for contacts has an end, and the near stay", "[nats][fault]") {
  Neighbourhood hood({.edge = 4.0, .near = 4.0}, 1);
  hood.hear(2, {.position = Vec3(1.0, 0.0, 0.0), .hears = 10.0}, 1);
  hood.update(true, 1);
  for (PeerId id = 10; id < 10000; ++id) {
    hood.hear(id, {.position = Vec3(static_cast<double>(id), 0.0, 0.0), .hears = 10.0}, 2);
  }
  CHECK(hood.contacts() == Neighbourhood::kMaxContacts);
  CHECK(hood.met() == 1);
}

}  // namespace
}  // namespace tandem::nats::neighbourhood_test
