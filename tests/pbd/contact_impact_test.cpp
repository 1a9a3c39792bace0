// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "support/bodies.h"
#include "support/catch.h"
#include "support/toy_contacts.h"
#include "tandem/pbd/contact.h"
#include "tandem/pbd/workers.h"

namespace contact_impact_test {

using namespace tandem::pbd;
using namespace tandem::testing;

namespace {

const Vec3 kHalf(0.5, 0.5, 0.5);

/// A ball above a plane.
struct Drop {
  World world;
  ToyContacts contacts;
  BodyId ball;
  static constexpr double kRadius = 0.2;

  Drop(double height, double restitution, bool swapped = false) {
    world.set_contact_source(&contacts);
    const BodyId ground = add_ground(world);
    ball = world.add_body(ball_def(1.0, kRadius, Vec3(0.0, 0.0, kRadius + height)));
    contacts.ball_on_plane(ground, Vec3::UnitZ(), 0.0, ball, kRadius,
                           {.restitution = restitution, .swapped = swapped});
  }
  double height() const { return world.pose(ball).position.z() - kRadius; }
  double speed() const { return world.twist(ball).linear.z(); }
};

/// Two free boxes, face against face, that meet while they tumble.
struct Collision {
  World world{weightless()};
  ToyContacts contacts;
  BodyId lower, upper;

  Collision(double restitution, double friction, bool swapped, const Vec3& spin) {
    world.set_contact_source(&contacts);
    BodyDef def = box_def(2.0, kHalf, Vec3(0.0, 0.0, 0.0));
    def.twist = {Vec3(0.3, 0.1, 0.5), spin};
    lower = world.add_body(def);
    def = box_def(1.0, Vec3(0.3, 0.4, 0.3), Vec3(0.1, 0.15, 0.9), turn(Vec3(0.05, -0.08, 0.2)));
    def.twist = {Vec3(-0.2, 0.0, -1.5), -spin};
    upper = world.add_body(def);
    contacts.box_on_box(lower, kHalf, upper, Vec3(0.3, 0.4, 0.3),
                        {.friction = friction, .restitution = restitution, .swapped = swapped});
  }
};

}  // namespace

TEST_CASE("contact: a ball bounces to e^2 of its height and never higher", "[pbd][analytic]") {
  for (const double e : {0.5, 0.8}) {
    for (const bool swapped : {false, true}) {
      Drop drop(1.0, e, swapped);
      Solver solver({.sleep_after = 0.0});
      std::vector<double> peaks;
      double before = drop.speed();
      double ceiling = drop.world.mechanical_energy();
      run(drop.world, solver, 2.5, [&] {
        // Normals sink in by micrometres under a load and give that back: below 1e-8 J.
        REQUIRE(drop.world.mechanical_energy() <= ceiling + 1e-8);
        ceiling = drop.world.mechanical_energy();
        const double v = drop.speed();
        // Height that the ball still has to go: free of the sampling of frames.
        if (before <= 0.0 && v > 0.0) peaks.push_back(drop.height() + v * v / (2.0 * kGravity));
        before = v;
      });
      REQUIRE(peaks.size() >= 2);
      INFO("e " << e << ": " << peaks[0] << ", " << peaks[1]);
      CHECK(peaks[0] == Approx(e * e).epsilon(0.02));
      CHECK(peaks[1] == Approx(e * e * e * e).epsilon(0.04));
      CHECK(peaks[1] < peaks[0]);
    }
  }
}

TEST_CASE("contact: without restitution a ball stays down", "[pbd][unit]") {
  Drop drop(1.0, 0.0);
  Solver solver({.sleep_after = 0.0});
  run(drop.world, solver, 0.6);  // it lands after 0.45 s
  double highest = 0.0;
  run(drop.world, solver, 1.0, [&] { highest = std::max(highest, drop.height()); });
  CHECK(highest < 1e-4);
  CHECK(std::abs(drop.height()) < 1e-4);
}

TEST_CASE("contact: a fully elastic ball keeps the invariant of its free fall", "[pbd][analytic]") {
  // Semi-implicit Euler conserves v^2 / 2 + g z - g h v / 2 in free fall; a bounce must not add.
  for (const int substeps : {4, 40}) {
    Drop drop(0.5, 1.0);
    Solver solver({.substeps = substeps, .sleep_after = 0.0});
    const double h = kFrame / substeps;
    const auto energy = [&] {
      return drop.world.mechanical_energy() -
             0.5 * kGravity * h * drop.world.twist(drop.ball).linear.z();
    };
    const double start = energy();
    double worst = 0.0;
    run(drop.world, solver, 5.0,
        [&] { worst = std::max(worst, std::abs(energy() / start - 1.0)); });
    INFO(substeps << " substeps: " << worst);
    CHECK(worst < 1e-9);
  }
}

TEST_CASE("contact: impacts slower than the threshold do not bounce", "[pbd][unit]") {
  const auto rebound = [](double impact_speed, double threshold) {
    Drop drop(impact_speed * impact_speed / (2.0 * kGravity), 1.0);
    Solver solver({.contact = {.restitution_threshold = threshold}});
    double fastest = 0.0;
    run(drop.world, solver, 0.5, [&] { fastest = std::max(fastest, drop.speed()); });
    return fastest;
  };
  // Two times |g| h is 0.033 m/s at 10 substeps.
  CHECK(rebound(0.02, 2.0) < 1e-3);
  CHECK(rebound(0.4, 2.0) > 0.2);
  CHECK(rebound(0.4, 50.0) < 1e-3);  // 0.82 m/s
}

TEST_CASE("contact: a ball at 30 m/s does not pass the plane", "[pbd][fault]") {
  for (const double e : {0.0, 0.8}) {
    Drop drop(5.0, e);
    drop.world.set_twist(drop.ball, {Vec3(0.0, 0.0, -30.0), Vec3::Zero()});
    Solver solver({.sleep_after = 0.0});
    double lowest = 1.0;
    run(drop.world, solver, 1.0, [&] { lowest = std::min(lowest, drop.height()); });
    CHECK(lowest > -1e-3);
  }
}

TEST_CASE("contact: boxes that overlap by 0.3 m part at less than 0.1 m/s", "[pbd][regression]") {
  World world(weightless());
  ToyContacts contacts;
  world.set_contact_source(&contacts);
  const BodyId lower = world.add_body(box_def(1.0, kHalf, Vec3::Zero()));
  const BodyId upper = world.add_body(box_def(1.0, kHalf, Vec3(0.0, 0.0, 0.7)));
  contacts.box_on_box(lower, kHalf, upper, kHalf, {});
  Solver solver({.sleep_after = 0.0});
  run(world, solver, 2.0);
  const double gap = world.pose(upper).position.z() - world.pose(lower).position.z() - 1.0;
  CHECK(gap > -1e-3);
  CHECK(world.twist(upper).linear.norm() < 0.1);
  CHECK(world.twist(lower).linear.norm() < 0.1);
  CHECK(linear_momentum(world).norm() < 1e-12);
}

TEST_CASE("contact: a box that starts 0.3 m deep in the floor is let out gently",
          "[pbd][regression]") {
  World world;
  ToyContacts contacts;
  world.set_contact_source(&contacts);
  const BodyId ground = add_ground(world);
  const BodyId box = world.add_body(box_def(1.0, kHalf, Vec3(0.0, 0.0, 0.2)));
  contacts.box_on_plane(ground, Vec3::UnitZ(), 0.0, box, kHalf, {});
  Solver solver({.sleep_after = 0.0});
  double highest = 0.0;
  double deepest_after = 0.0;
  double time = 0.0;
  run(world, solver, 2.0, [&] {
    highest = std::max(highest, world.pose(box).position.z() - 0.5);
    time += kFrame;
    if (time > 0.5) deepest_after = std::max(deepest_after, 0.5 - world.pose(box).position.z());
  });
  // A leap of v^2 / 2g for v = 0.1 m/s is 0.5 mm.
  CHECK(highest < 5.1e-4);
  CHECK(deepest_after < 1e-3);
  CHECK(world.twist(box).linear.norm() < 1e-4);
}

TEST_CASE("contact: two free boxes keep linear momentum in a collision", "[pbd][analytic]") {
  for (const double restitution : {0.0, 0.7}) {
    for (const double friction : {0.0, 0.5}) {
      Collision scene(restitution, friction, false, Vec3(0.4, -0.3, 0.5));
      const Vec3 p = linear_momentum(scene.world);
      const double energy = scene.world.kinetic_energy();
      Solver solver({.sleep_after = 0.0});
      run(scene.world, solver, 1.0);
      CHECK((linear_momentum(scene.world) - p).norm() < 1e-12);
      CHECK(scene.world.kinetic_energy() < energy);
      // They met: the upper one no longer falls on the lower one.
      const double closing =
          (scene.world.twist(scene.upper).linear - scene.world.twist(scene.lower).linear).z();
      CHECK(closing > -0.5);
    }
  }
}

TEST_CASE("contact: two free boxes keep angular momentum to first order in the step",
          "[pbd][analytic]") {
  // A contact's lever arms stand for the whole step, so its moment is exact to v dt only.
  for (const double friction : {0.0, 0.5}) {
    std::vector<double> errors;
    for (const double dt : {kFrame, kFrame / 8.0}) {
      Collision scene(0.5, friction, false, Vec3(0.4, -0.3, 0.5));
      const Vec3 l = angular_momentum(scene.world);
      const Vec3 p = scene.world.twist(scene.upper).linear;
      Solver solver({.sleep_after = 0.0});
      for (int i = 0; i * dt < 1.0; ++i) solver.step(scene.world, dt);
      // Against the moment that the impulse has at the arm of half a metre.
      const double moment = 0.5 * (scene.world.twist(scene.upper).linear - p).norm();
      errors.push_back((angular_momentum(scene.world) - l).norm() / moment);
    }
    INFO("friction " << friction << ": " << errors[0] << " " << errors[1]);
    CHECK(errors[0] < 1e-2);
    CHECK(errors[1] < errors[0] / 2.0);
  }
}

TEST_CASE("contact: a central collision exchanges velocities as the textbook says",
          "[pbd][analytic]") {
  for (const double e : {0.0, 0.5, 1.0}) {
    World world(weightless());
    ToyContacts contacts;
    world.set_contact_source(&contacts);
    const BodyId a = world.add_body(ball_def(2.0, 0.3, Vec3(-1.0, 0.0, 0.0)));
    const BodyId b = world.add_body(ball_def(1.0, 0.2, Vec3(1.0, 0.0, 0.0)));
    contacts.ball_on_ball(a, 0.3, b, 0.2, {.restitution = e});
    world.set_twist(a, {Vec3(2.0, 0.0, 0.0), Vec3::Zero()});
    world.set_twist(b, {Vec3(-1.0, 0.0, 0.0), Vec3::Zero()});
    Solver solver({.sleep_after = 0.0});
    run(world, solver, 2.0);
    const double centre = (2.0 * 2.0 - 1.0 * 1.0) / 3.0;
    CHECK(world.twist(a).linear.x() == Approx(centre - e * 3.0 / 3.0).margin(1e-9));
    CHECK(world.twist(b).linear.x() == Approx(centre + e * 3.0 * 2.0 / 3.0).margin(1e-9));
  }
}

TEST_CASE("contact: the order of the two bodies does not matter", "[pbd][unit]") {
  Collision one(0.5, 0.4, false, Vec3(0.4, -0.3, 0.5));
  Collision two(0.5, 0.4, true, Vec3(0.4, -0.3, 0.5));
  Solver solver({.sleep_after = 0.0});
  run(one.world, solver, 1.0);
  run(two.world, solver, 1.0);
  for (const BodyId id : {one.lower, one.upper}) {
    CHECK((one.world.pose(id).position - two.world.pose(id).position).norm() < 1e-9);
    CHECK(angle_between(one.world.pose(id).orientation, two.world.pose(id).orientation) < 1e-9);
  }
}

TEST_CASE("contact: forces follow their feature, else the nearest anchor", "[pbd][unit]") {
  const auto manifold = [](std::initializer_list<ManifoldPoint> points) {
    Manifold m;
    m.key = 7;
    m.body_a = 0;
    m.body_b = 1;
    for (const ManifoldPoint& p : points) m.points[static_cast<std::size_t>(m.count++)] = p;
    return m;
  };
  const auto point = [](double x, std::uint32_t feature) {
    return ManifoldPoint{.anchor_b_l = Vec3(x, 0.0, 0.0), .feature = feature};
  };
  // A row with the forces 1, 2, 3, as a snapshot would bring it back.
  Workers workers;
  const auto block_with_rows = [&] {
    auto block = std::make_unique<ContactBlock>();
    std::vector<Manifold> first{manifold({point(0.0, 10), point(1.0, 11), point(2.0, 12)})};
    block->set_manifolds(first, workers);
    std::vector<std::byte> bytes;
    ByteWriter out(bytes);
    block->save(out);
    // Per point: anchors (6 doubles), feature, force; the points come last.
    const std::size_t per_point = 6 * 8 + 4 + 8;
    for (std::size_t i = 0; i < 3; ++i) {
      std::vector<std::byte> force;
      ByteWriter(force).f64(static_cast<double>(i + 1));
      std::copy(force.begin(), force.end(),
                bytes.end() - static_cast<std::ptrdiff_t>((3 - i) * per_point - 6 * 8 - 4));
    }
    ByteReader in(bytes);
    block->load(in);
    REQUIRE_FALSE(in.failed());
    REQUIRE(block->contacts()[0].force[2] == 3.0);
    return block;
  };

  SECTION("by feature, wherever the point has moved") {
    const auto kept = block_with_rows();
    ContactBlock& block = *kept;
    std::vector<Manifold> next{manifold({point(5.0, 12), point(0.0, 11)})};
    block.set_manifolds(next, workers);
    CHECK(block.contacts()[0].force[0] == 3.0);
    CHECK(block.contacts()[0].force[1] == 2.0);
  }
  SECTION("by anchor, where the feature is new and the anchor near") {
    const auto kept = block_with_rows();
    ContactBlock& block = *kept;
    std::vector<Manifold> next{manifold({point(1.01, 90), point(2.5, 91), point(0.0, 10)})};
    block.set_manifolds(next, workers);
    CHECK(block.contacts()[0].force[0] == 2.0);
    CHECK(block.contacts()[0].force[1] == 0.0);
    CHECK(block.contacts()[0].force[2] == 1.0);
  }
  SECTION("one by one where several have the same key") {
    const auto kept = block_with_rows();
    ContactBlock& block = *kept;
    std::vector<Manifold> next(2, manifold({point(0.0, 11)}));
    block.set_manifolds(next, workers);
    REQUIRE(block.contacts().size() == 2);
    CHECK(block.contacts()[0].force[0] == 2.0);
    CHECK(block.contacts()[1].force[0] == 0.0);
  }
  SECTION("not across pairs") {
    const auto kept = block_with_rows();
    ContactBlock& block = *kept;
    std::vector<Manifold> next{manifold({point(0.0, 10)})};
    next[0].key = 8;
    block.set_manifolds(next, workers);
    CHECK(block.contacts()[0].force[0] == 0.0);
  }
  SECTION("manifolds come sorted by key for any order of detection") {
    const auto kept = block_with_rows();
    ContactBlock& block = *kept;
    std::vector<Manifold> next{manifold({point(0.0, 10)}), manifold({point(0.0, 10)})};
    next[0].key = 9;
    block.set_manifolds(next, workers);
    REQUIRE(block.contacts().size() == 2);
    CHECK(block.contacts()[0].manifold.key == 7);
    CHECK(block.contacts()[0].force[0] == 1.0);
  }
}

TEST_CASE("contact: a resting box does not notice that its features are named anew",
          "[pbd][unit]") {
  World world;
  ToyContacts contacts;
  world.set_contact_source(&contacts);
  const BodyId ground = add_ground(world);
  const BodyId box = world.add_body(box_def(1.0, kHalf, Vec3(0.0, 0.0, 0.5)));
  contacts.box_on_plane(ground, Vec3::UnitZ(), 0.0, box, kHalf, {});
  contacts.forget_features(true);
  Solver solver({.sleep_after = 0.0});
  run(world, solver, 1.0);
  const double height = world.pose(box).position.z();
  run(world, solver, 1.0, [&] { REQUIRE(world.in_contact(box)); });
  CHECK(std::abs(world.pose(box).position.z() - height) < 1e-9);
}

TEST_CASE("contact: a body that lands on a stack without restitution stays there",
          "[pbd][contact]") {
  for (const int substeps : {1, 4, 8}) {
    World world;
    ToyContacts contacts;
    world.set_contact_source(&contacts);
    const BodyId ground = add_ground(world);
    const BodyId lower = world.add_body(box_def(1.0, kHalf, Vec3(0.0, 0.0, 0.5)));
    const BodyId upper = world.add_body(box_def(1.0, kHalf, Vec3(0.02, 0.0, 1.6)));
    contacts.box_on_plane(ground, Vec3::UnitZ(), 0.0, lower, kHalf, {});
    contacts.box_on_box(lower, kHalf, upper, kHalf, {});
    Solver solver({.substeps = substeps, .sleep_after = 0.0});
    const double impact = std::sqrt(2.0 * 9.81 * 0.1);  // m/s
    double rise = 0.0;
    for (int i = 0; i < 60; ++i) {
      solver.step(world, 1.0 / 60.0);
      rise = std::max({rise, world.twist(lower).linear.z(), world.twist(upper).linear.z()});
    }
    CAPTURE(substeps);
    CHECK(rise <= 0.05 * impact);  // 0.25 % of the energy
    CHECK(world.pose(upper).position.z() == Approx(1.5).margin(1e-3));
  }
}

}  // namespace contact_impact_test
