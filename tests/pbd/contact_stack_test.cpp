// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "support/bodies.h"
#include "support/catch.h"
#include "support/toy_contacts.h"

namespace contact_stack_test {

using namespace tandem::pbd;
using namespace tandem::testing;

namespace {

const Vec3 kHalf(0.5, 0.5, 0.5);

/// Cubes of 1 m and 1 kg on a plane, one on another, each with four face points.
struct Stack {
  World world;
  ToyContacts contacts;
  std::vector<BodyId> boxes;
  std::vector<Vec3> start;

  Stack(int count, double offset, bool swapped = false) {
    world.set_contact_source(&contacts);
    const BodyId ground = add_ground(world);
    for (int i = 0; i < count; ++i) {
      start.emplace_back(i % 2 == 1 ? offset : 0.0, i % 3 != 0 ? offset : 0.0, 0.5 + i);
      boxes.push_back(world.add_body(box_def(1.0, kHalf, start.back())));
      if (i == 0) {
        contacts.box_on_plane(ground, Vec3::UnitZ(), 0.0, boxes[0], kHalf, {.swapped = swapped});
      } else {
        contacts.box_on_box(boxes[static_cast<std::size_t>(i - 1)], kHalf, boxes.back(), kHalf,
                            {.swapped = swapped});
      }
    }
  }
  /// Largest sideways move of any box, m.
  double drift() const {
    double largest = 0.0;
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      largest = std::max(largest, (world.pose(boxes[i]).position - start[i]).head<2>().norm());
    }
    return largest;
  }
  /// How far the top has come down, m.
  double sunk() const { return start.back().z() - world.pose(boxes.back()).position.z(); }
  /// Mean square speed, (m/s)^2.
  double speed2() const {
    double sum = 0.0;
    for (const BodyId id : boxes) sum += world.twist(id).linear.squaredNorm();
    return sum / static_cast<double>(boxes.size());
  }
};

}  // namespace

TEST_CASE("contact stack: ten cubes stand for 20 s without drift or jitter",
          "[pbd][contact][regression]") {
  for (const double offset : {0.0, 0.01}) {
    for (const bool swapped : {false, true}) {
      Stack stack(10, offset, swapped);
      Solver solver({.sleep_after = 0.0});
      run(stack.world, solver, 19.0);
      double sum = 0.0;
      run(stack.world, solver, 1.0, [&] { sum += stack.speed2(); });
      INFO("offset " << offset << ": drift " << stack.drift() << " m, sunk " << stack.sunk()
                     << " m, rms speed " << std::sqrt(sum / 60.0) << " m/s");
      CHECK(stack.drift() < 1e-3);
      CHECK(std::abs(stack.sunk()) < 1e-3);
      CHECK(std::sqrt(sum / 60.0) < 1e-4);
    }
  }
}

TEST_CASE("contact stack: five cubes stand with four substeps", "[pbd][contact][regression]") {
  Stack stack(5, 0.01);
  Solver solver({.substeps = 4, .sleep_after = 0.0});
  run(stack.world, solver, 9.0);
  double sum = 0.0;
  run(stack.world, solver, 1.0, [&] { sum += stack.speed2(); });
  INFO("drift " << stack.drift() << " m, rms speed " << std::sqrt(sum / 60.0) << " m/s");
  CHECK(stack.drift() < 1e-3);
  CHECK(std::sqrt(sum / 60.0) < 1e-4);
}

TEST_CASE("contact stack: ten cubes stand while the length of the steps changes",
          "[pbd][contact][regression]") {
  // A loaded contact sinks in by an amount that goes with the square of the substep, so boxes move
  // by some 0.1 mm at each change; they must not walk or fall.
  Stack stack(10, 0.01);
  Solver solver({.sleep_after = 0.0});
  const std::array<double, 4> lengths{0.016, 0.016, 0.016, 0.024};
  double fastest = 0.0;
  for (std::size_t k = 0; k < 600; ++k) {
    solver.step(stack.world, lengths[k % lengths.size()]);
    if (k >= 100) fastest = std::max(fastest, std::sqrt(stack.speed2()));
  }
  INFO("drift " << stack.drift() << " m, sunk " << stack.sunk() << " m, fastest " << fastest);
  CHECK(stack.drift() < 1e-3);
  CHECK(std::abs(stack.sunk()) < 1e-3);
  CHECK(fastest < 2e-2);
}

TEST_CASE("contact stack: each contact carries the weight above it", "[pbd][contact][analytic]") {
  Stack stack(6, 0.0);
  Solver solver({.sleep_after = 0.0});
  run(stack.world, solver, 5.0);
  const auto contacts = stack.world.contacts()->contacts();
  REQUIRE(contacts.size() == 6);
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    double sum = 0.0;
    for (const double force : contacts[i].force) sum += force;
    CHECK(sum == Approx(kGravity * static_cast<double>(6 - i)).epsilon(1e-3));
  }
}

}  // namespace contact_stack_test
