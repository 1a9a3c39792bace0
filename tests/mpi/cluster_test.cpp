// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Each case runs on all ranks that mpirun has started, whatever their number: on one it says what a
// cluster of one rank does, on several what holds between them.
#include "tandem/mpi/cluster.h"

#include <mpi.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "support/catch.h"
#include "tandem/collision/contact_source.h"
#include "tandem/collision/convex_hull.h"
#include "tandem/pbd/bytes.h"

namespace tandem::mpi {
namespace {

using pbd::Vec3;

constexpr double kFrame = 1.0 / 60.0;  // s

struct Plan {
  pbd::BodyDef def;
  collision::Shape shape;
  Vec3 com = Vec3::Zero();  ///< m, of the shape, in its frame
};

struct Plans {
  std::vector<Plan> bodies;
  Vec3 gravity = Vec3(0.0, 0.0, -9.81);
  bool ground = true;

  void ball(double radius, const Vec3& at, const Vec3& speed = Vec3::Zero()) {
    add(collision::Sphere{radius}, at, speed);
  }
  void cube(double edge, const Vec3& at, const Vec3& speed = Vec3::Zero()) {
    add(collision::Box{Vec3::Constant(0.5 * edge)}, at, speed);
  }
  void crystal(const Vec3& at, const Vec3& speed) { add(hull, at, speed); }

  /// Eight corners, no two alike.
  collision::Hull hull = collision::ConvexHull::make(std::vector<Vec3>{{0.1, 0.0, 0.02},
                                                                       {-0.1, 0.01, 0.0},
                                                                       {0.0, 0.11, 0.0},
                                                                       {0.01, -0.09, 0.0},
                                                                       {0.0, 0.0, 0.1},
                                                                       {0.02, 0.0, -0.1},
                                                                       {0.06, 0.06, 0.06},
                                                                       {-0.06, -0.05, -0.06}});

 private:
  void add(const collision::Shape& shape, const Vec3& at, const Vec3& speed) {
    const collision::MassProperties mass = collision::mass_properties(shape, 1000.0);
    Plan plan{.def = {}, .shape = shape};
    plan.def.mass = mass.mass;
    plan.def.inertia = mass.inertia;
    plan.com = mass.com;
    plan.def.pose.position = at;
    plan.def.twist.linear = speed;
    plan.def.stable_id = bodies.size();
    bodies.push_back(plan);
  }
};

collision::ColliderDef collider_of(const collision::Shape& shape, const Vec3& com = Vec3::Zero()) {
  return {.body = {}, .shape = shape, .local = {.position = -com}, .material = {}, .filter = {}};
}

/// On all ranks: the sum, and the largest.
std::uint64_t sum_of(std::uint64_t own) {
  MPI_Allreduce(MPI_IN_PLACE, &own, 1, MPI_UINT64_T, MPI_SUM, MPI_COMM_WORLD);
  return own;
}
double most_of(double own) {
  MPI_Allreduce(MPI_IN_PLACE, &own, 1, MPI_DOUBLE, MPI_MAX, MPI_COMM_WORLD);
  return own;
}

void fill(Cluster& cluster, const Plans& plans, bool with_bodies = true) {
  cluster.use(plans.hull);
  if (plans.ground) {
    const collision::ColliderDef ground[] = {collider_of(collision::HalfSpace{})};
    cluster.add({.type = pbd::BodyType::Static}, ground);
  }
  if (!with_bodies) return;
  for (std::size_t i = 0; i < plans.bodies.size(); ++i) {
    // The rank that has it first, not its later owner.
    if (i % static_cast<std::size_t>(cluster.count()) != static_cast<std::size_t>(cluster.rank())) {
      continue;
    }
    const collision::ColliderDef colliders[] = {
        collider_of(plans.bodies[i].shape, plans.bodies[i].com)};
    cluster.add(plans.bodies[i].def, colliders);
  }
  cluster.start();
}

/// The same without MPI.
class Whole {
 public:
  explicit Whole(const Plans& plans) : world({.gravity = plans.gravity}) {
    world.set_contact_source(&shapes);
    if (plans.ground) add({.type = pbd::BodyType::Static}, collision::HalfSpace{});
    for (const Plan& plan : plans.bodies) bodies.push_back(add(plan.def, plan.shape, plan.com));
  }
  void step() { solver.step(world, kFrame); }
  /// As Totals::hash.
  std::uint64_t hash() const {
    std::uint64_t sum = 0;
    for (const pbd::BodyId body : bodies) {
      std::vector<std::byte> bytes;
      pbd::ByteWriter out(bytes);
      const pbd::BodyState& state = world.state(body);
      out.u64(*world.props(body).stable_id);
      out.vec3(state.pose.position);
      for (int i = 0; i < 4; ++i) out.f64(state.pose.orientation.coeffs()[i]);
      out.vec3(state.twist.linear);
      out.vec3(state.twist.angular);
      sum += pbd::hash_bytes(bytes);
    }
    return sum;
  }

  pbd::World world;
  collision::CollisionScene shapes;
  pbd::Solver solver;
  std::vector<pbd::BodyId> bodies;

 private:
  pbd::BodyId add(const pbd::BodyDef& def, const collision::Shape& shape,
                  const Vec3& com = Vec3::Zero()) {
    const pbd::BodyId body = world.add_body(def);
    collision::ColliderDef collider = collider_of(shape, com);
    collider.body = body;
    shapes.add(world, collider);
    return body;
  }
};

/// By name, on all ranks: the states of own bodies alone.
std::map<std::uint64_t, pbd::BodyState> own_states(const Cluster& cluster) {
  std::map<std::uint64_t, pbd::BodyState> states;
  const pbd::World& world = cluster.world();
  for (std::uint32_t slot = 0; slot < world.slot_count(); ++slot) {
    const pbd::BodyId body = world.body_at(slot);
    if (body.valid() && cluster.owns(body))
      states[*world.props(body).stable_id] = world.state(body);
  }
  return states;
}

/// m: the longest way along the ground from where the bodies began, over all ranks.
double drift_of(const Cluster& cluster, const Plans& plans) {
  double most = 0.0;
  for (const auto& [id, state] : own_states(cluster)) {
    Vec3 way = state.pose.position - plans.bodies[id].def.pose.position;
    way.z() = 0.0;
    most = std::max(most, way.norm());
  }
  return most_of(most);
}

ClusterOptions with_gravity(const Vec3& gravity) {
  ClusterOptions options;
  options.gravity = gravity;
  return options;
}

/// Whole islands change hands as often as they can.
ClusterOptions restless() {
  ClusterOptions options;
  options.balance_every = 1;
  options.balance_above = 1.0;
  options.cut_above = 1.0;
  return options;
}

/// A heap of balls and cubes that fall on each other.
Plans heap() {
  Plans plans;
  for (int i = 0; i < 120; ++i) {
    const Vec3 at(0.21 * (i % 5) + 0.01 * (i % 3), 0.21 * (i / 5 % 4) + 0.013 * (i % 2),
                  0.15 + 0.22 * (i / 20));
    if (i % 2 == 0) {
      plans.ball(0.1, at);
    } else {
      plans.cube(0.18, at);
    }
  }
  return plans;
}

std::string folder() {
  // Set by the ranks' common parent.
  const char* given = std::getenv("TANDEM_TEST_FOLDER");
  return given != nullptr ? given : std::filesystem::temp_directory_path().string();
}

std::string refusal(const std::function<void()>& act) {
  try {
    act();
  } catch (const std::exception& error) {
    return error.what();
  }
  return "";
}

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

/// Others see a body of this rank's further along x than it is, in each step.
class Ahead final : public pbd::TargetSource {
 public:
  Ahead(const Cluster& cluster, double by) : cluster_(cluster), by_(by) {}
  void collect(const pbd::World& world, double, const pbd::SolverOptions&,
               std::vector<pbd::PoseTarget>& out) override {
    const pbd::BodyId body = cluster_.own_body(0);
    if (!body.valid()) return;
    pbd::PoseTarget& target = out.emplace_back();
    target = {.body = body, .pose = world.pose(body), .twist = world.twist(body), .share = 0.5};
    target.pose.position.x() += by_;
  }

 private:
  const Cluster& cluster_;
  double by_;
};

TEST_CASE("cluster: a target pulls no body into another rank's", "[mpi]") {
  Plans plans;
  plans.ground = false;
  plans.gravity = Vec3::Zero();
  for (int i = 0; i < 4; ++i) plans.cube(0.2, Vec3(0.2 * i, 0.0, 0.0));
  Cluster cluster(with_gravity(plans.gravity));
  fill(cluster, plans);
  Ahead ahead(cluster, 0.1);
  cluster.world().set_target_source(&ahead);
  double deepest = 0.0;
  for (int k = 0; k < 30; ++k) {
    cluster.step(kFrame);
    std::vector<double> x(4, -1e9);
    for (const auto& [id, state] : own_states(cluster)) x[id] = state.pose.position.x();
    for (double& each : x) each = most_of(each);
    for (std::size_t i = 1; i < 4; ++i) deepest = std::max(deepest, 0.2 - (x[i] - x[i - 1]));
  }
  cluster.world().set_target_source(nullptr);
  INFO(cluster.count() << " ranks: " << 1e3 * deepest << " mm deep");
  // 50 mm are asked for in each step.
  CHECK(deepest < 0.01);
}

TEST_CASE("cluster: one rank has the bits of the world without MPI", "[mpi]") {
  const Plans plans = heap();
  Cluster cluster;
  if (cluster.count() > 1) return;
  fill(cluster, plans);
  Whole whole(plans);
  for (int k = 0; k < 120; ++k) {
    cluster.step(kFrame);
    whole.step();
  }
  CHECK(cluster.totals().hash == whole.hash());
}

TEST_CASE("cluster: equal runs have equal bits", "[mpi]") {
  const Plans plans = heap();
  std::uint64_t hash[2] = {};
  std::uint64_t migrated = 0;
  std::size_t seams = 0;
  for (std::uint64_t& each : hash) {
    Cluster cluster;
    fill(cluster, plans);
    for (int k = 0; k < 90; ++k) {
      cluster.step(kFrame);
      seams += cluster.state().seam_rows;
    }
    each = cluster.totals().hash;
    migrated += cluster.state().migrated;
    CHECK(cluster.totals().bodies == plans.bodies.size());
  }
  CHECK(hash[0] == hash[1]);
  int count = 1;
  MPI_Comm_size(MPI_COMM_WORLD, &count);
  // There was something to be equal.
  CHECK((sum_of(migrated) > 0) == (count > 1));
  CHECK((sum_of(seams) > 0) == (count > 1));
}

TEST_CASE("cluster: islands that stay whole move as without MPI, wherever they go", "[mpi]") {
  // Pairs of balls that roll and meet, each pair on its own lane, some fast and some slow, so that
  // the cuts move.
  Plans plans;
  for (int lane = 0; lane < 24; ++lane) {
    const double speed = 0.5 + 0.4 * (lane % 7);
    plans.ball(0.1, Vec3(-1.0, 1.0 * lane, 0.1), Vec3(speed, 0.0, 0.0));
    plans.ball(0.1, Vec3(0.5, 1.0 * lane + 0.05, 0.3 + 0.1 * (lane % 5)), Vec3(-speed, 0.0, 0.0));
  }
  Cluster cluster(restless());
  fill(cluster, plans);
  Whole whole(plans);
  for (int k = 0; k < 120; ++k) {
    cluster.step(kFrame);
    whole.step();
    REQUIRE(cluster.totals().hash == whole.hash());
  }
  const std::uint64_t migrated = sum_of(cluster.state().migrated);
  CHECK((migrated > 8) == (cluster.count() > 1));
}

TEST_CASE("cluster: hulls go from rank to rank as their numbers", "[mpi]") {
  Plans plans;
  for (int lane = 0; lane < 12; ++lane) {
    plans.crystal(Vec3(-1.0, 1.0 * lane, 0.3), Vec3(0.5 + 0.4 * (lane % 7), 0.0, 0.0));
    plans.crystal(Vec3(0.0, 1.0 * lane, 0.2), Vec3::Zero());
  }
  Cluster cluster(restless());
  fill(cluster, plans);
  for (int k = 0; k < 180; ++k) cluster.step(kFrame);
  const std::uint64_t migrated = sum_of(cluster.state().migrated);
  CHECK((migrated > 4) == (cluster.count() > 1));
  CHECK(cluster.totals().bodies == plans.bodies.size());
  // They have come to rest on the ground, none of them in it.
  for (const auto& [id, state] : own_states(cluster)) {
    CAPTURE(id);
    CHECK(state.pose.position.z() > 0.04);
    CHECK(state.pose.position.z() < 0.3);
  }
  Cluster none;
  if (none.rank() == 0) {
    const collision::ColliderDef unknown[] = {collider_of(plans.hull)};
    CHECK(has(refusal([&] { none.add(plans.bodies[0].def, unknown); }), "a hull of use()"));
  }
  none.start();
  CHECK(has(refusal([&] { none.use(plans.hull); }), "before start()"));
}

TEST_CASE("cluster: a body that comes later meets those of other ranks", "[mpi]") {
  // A row of cubes over all ranks; a ball on each of them, all from the last rank.
  Plans plans;
  for (int i = 0; i < 8; ++i) plans.cube(0.2, Vec3(0.5 * i, 0.0, 0.1));
  const std::size_t cubes = plans.bodies.size();
  Cluster cluster;
  fill(cluster, plans);
  for (int k = 0; k < 30; ++k) cluster.step(kFrame);
  for (std::size_t i = 0; i < cubes; ++i) {
    plans.ball(0.1, Vec3(0.5 * static_cast<double>(i), 0.0, 0.6));
    if (cluster.rank() != cluster.count() - 1) continue;
    const collision::ColliderDef colliders[] = {collider_of(plans.bodies.back().shape)};
    cluster.add(plans.bodies.back().def, colliders);
  }
  for (int k = 0; k < 120; ++k) cluster.step(kFrame);
  CHECK(cluster.totals().bodies == 2 * cubes);
  for (const auto& [id, state] : own_states(cluster)) {
    CAPTURE(id);
    const double expected = id < cubes ? 0.1 : 0.3;
    CHECK(std::abs(state.pose.position.z() - expected) < 2e-3);
  }
  const collision::ColliderDef floor[] = {collider_of(collision::HalfSpace{})};
  CHECK(
      has(refusal([&] { cluster.add({.type = pbd::BodyType::Static}, floor); }), "before start()"));
}

TEST_CASE("cluster: a blow between ranks keeps momentum and is as without MPI", "[mpi]") {
  // Four runs in which the blow has its middle elsewhere; light on heavy.
  for (const double place : {-0.15, 0.0, 0.1, 0.4}) {
    Plans plans;
    plans.gravity = Vec3::Zero();
    plans.ground = false;
    plans.ball(0.1, Vec3(place - 1.1, 0.0, 0.0), Vec3(2.0, 0.0, 0.0));
    plans.ball(0.2, Vec3(place + 0.1, 0.03, 0.0));
    ClusterOptions options = with_gravity(plans.gravity);
    options.balance_every = 1000;
    Cluster cluster(options);
    fill(cluster, plans);
    Whole whole(plans);
    const Vec3 before = cluster.totals().momentum;
    std::size_t seams = 0;
    for (int k = 0; k < 60; ++k) {
      cluster.step(kFrame);
      whole.step();
      seams += cluster.state().seam_rows;
    }
    CHECK((sum_of(seams) > 0) == (cluster.count() > 1));
    const Totals after = cluster.totals();
    CHECK((after.momentum - before).norm() < 1e-12 * before.norm());
    CHECK(after.kinetic_energy == Approx(whole.world.kinetic_energy()).epsilon(1e-9));
    for (const auto& [id, state] : own_states(cluster)) {
      const pbd::Twist& twist = whole.world.twist(whole.bodies[id]);
      CHECK((state.twist.linear - twist.linear).norm() < 1e-9);
    }
  }
}

TEST_CASE("cluster: a pyramid that is cut stands as one that is not", "[mpi]") {
  Plans plans;
  constexpr int kRow = 10;
  for (int level = 0; level < kRow; ++level) {
    for (int i = 0; i < kRow - level; ++i) {
      plans.cube(0.1, Vec3(0.105 * (i + 0.5 * level), 0.0, 0.1 * (level + 0.5)));
    }
  }
  ClusterOptions options;
  options.cut_above = 0.0;
  options.solver.sleep_after = 0.0;
  Cluster cluster(options);
  fill(cluster, plans);
  std::size_t seams = 0;
  for (int k = 0; k < 180; ++k) {
    cluster.step(kFrame);
    seams += cluster.state().seam_rows;
  }
  CHECK((sum_of(seams) > 0) == (cluster.count() > 1));
  // No cube has moved by a hundredth of its edge.
  CHECK(drift_of(cluster, plans) < 1e-3);
  CHECK(cluster.totals().kinetic_energy < 1e-4);
}

TEST_CASE("cluster: bodies at rest sleep, cut or not, and send nothing", "[mpi]") {
  Plans plans;
  for (int stack = 0; stack < 8; ++stack) {
    for (int level = 0; level < 3; ++level) {
      // Neighbours touch: one island.
      plans.cube(0.2, Vec3(0.2 * stack, 0.0, 0.2 * (level + 0.5)));
    }
  }
  ClusterOptions options;
  options.cut_above = 0.0;
  Cluster cluster(options);
  fill(cluster, plans);
  for (int k = 0; k < 90; ++k) cluster.step(kFrame);
  CHECK(cluster.totals().awake == 0);
  const std::uint64_t hash = cluster.totals().hash;
  std::size_t bytes = 0;
  for (int k = 0; k < 40; ++k) {
    cluster.step(kFrame);
    bytes = std::max(bytes, cluster.cost().bytes);
  }
  CHECK(cluster.totals().awake == 0);
  CHECK(cluster.totals().hash == hash);
  // Less than the state of one body for each neighbour, and what is told of islands.
  CHECK(bytes < 1500);
}

TEST_CASE("cluster: a ball wakes sleeping bodies of another rank", "[mpi]") {
  Plans plans;
  for (int i = 0; i < 6; ++i) plans.ball(0.1, Vec3(0.2 * i, 0.0, 0.1));
  plans.ball(0.1, Vec3(-4.0, 0.0, 0.1), Vec3(4.0, 0.0, 0.0));
  ClusterOptions options;
  options.cut_above = 0.0;
  options.balance_every = 1000;
  Cluster cluster(options);
  fill(cluster, plans);
  bool slept = false;
  for (int k = 0; k < 50; ++k) {
    cluster.step(kFrame);
    slept = slept || cluster.totals().awake == 1;
  }
  CHECK(slept);
  for (int k = 0; k < 50; ++k) cluster.step(kFrame);
  // The last of the row has felt it.
  double speed = 0.0;
  for (const auto& [id, state] : own_states(cluster)) {
    if (id == 5) speed = state.twist.linear.norm();
  }
  CHECK(most_of(speed) > 0.05);
}

TEST_CASE("cluster: a checkpoint is gone on from as it was", "[mpi]") {
  const std::string path = folder() + "/cluster_test.checkpoint";
  const Plans plans = heap();
  std::uint64_t hash = 0;
  double energy = 0.0;
  {
    Cluster cluster;
    fill(cluster, plans);
    for (int k = 0; k < 40; ++k) cluster.step(kFrame);
    cluster.save(path);
    hash = cluster.totals().hash;
    for (int k = 0; k < 60; ++k) cluster.step(kFrame);
    energy = cluster.totals().mechanical_energy;
  }
  std::uint64_t after[2] = {};
  for (std::uint64_t& each : after) {
    Cluster cluster;
    fill(cluster, plans, false);
    cluster.load(path);
    CHECK(cluster.steps() == 40);
    CHECK(cluster.totals().hash == hash);
    CHECK(cluster.totals().bodies == plans.bodies.size());
    for (int k = 0; k < 60; ++k) cluster.step(kFrame);
    each = cluster.totals().hash;
    CHECK(cluster.totals().mechanical_energy == Approx(energy).epsilon(0.01));
  }
  CHECK(after[0] == after[1]);
  // Damaged anywhere it is refused, by all ranks.
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  const auto size = static_cast<std::streamoff>(std::filesystem::file_size(path));
  for (const std::streamoff at : {std::streamoff{3}, std::streamoff{20}, size / 2, size - 1}) {
    MPI_Barrier(MPI_COMM_WORLD);
    const auto flip = [&] {
      std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
      file.seekg(at);
      const char byte = static_cast<char>(file.get());
      file.seekp(at);
      file.put(static_cast<char>(byte ^ 0x10));
    };
    if (rank == 0) flip();
    MPI_Barrier(MPI_COMM_WORLD);
    Cluster cluster;
    fill(cluster, plans, false);
    CHECK(has(refusal([&] { cluster.load(path); }), "damaged"));
    MPI_Barrier(MPI_COMM_WORLD);
    if (rank == 0) flip();
  }
  MPI_Barrier(MPI_COMM_WORLD);
  Cluster cluster;
  fill(cluster, plans, false);
  CHECK(has(refusal([&] { cluster.load(path + ".none"); }), "cannot be opened"));
  CHECK(has(refusal([&] { cluster.save(folder() + "/no/such/folder"); }), "cannot be written"));
  MPI_Barrier(MPI_COMM_WORLD);
  if (rank == 0) std::filesystem::remove(path);
}

TEST_CASE("cluster: nonsense is refused by name", "[mpi]") {
  const auto options = [](const std::function<void(ClusterOptions&)>& set) {
    ClusterOptions result;
    set(result);
    return refusal([&] { Cluster cluster(result); });
  };
  CHECK(has(options([](auto& o) { o.balance_every = 0; }), "balance_every must be at least 1"));
  CHECK(has(options([](auto& o) { o.refresh_every = 0; }), "refresh_every"));
  CHECK(has(options([](auto& o) { o.cut_above = 2.0; }), "cut_above must be from 0 to 1"));
  CHECK(has(options([](auto& o) { o.balance_above = std::nan(""); }), "balance_above"));
  CHECK(has(options([](auto& o) { o.network.bandwidth = 0.0; }), "bandwidth"));
  Cluster cluster;
  const collision::ColliderDef ball[] = {collider_of(collision::Sphere{0.1})};
  CHECK(has(refusal([&] { cluster.add({}, ball); }), "stable_id"));
  CHECK(has(refusal([&] { cluster.add({.stable_id = ~std::uint64_t{0}}, ball); }), "2^63"));
  const std::vector<Vec3> corners = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)};
  const collision::ColliderDef hull[] = {collider_of(collision::ConvexHull::make(corners))};
  CHECK(has(refusal([&] { cluster.add({.stable_id = 1}, hull); }), "shape"));
  CHECK(has(refusal([&] { cluster.step(kFrame); }), "start()"));
  cluster.start();
  CHECK(has(refusal([&] { cluster.add({.type = pbd::BodyType::Static}, ball); }), "start()"));
  CHECK(has(refusal([&] { cluster.start(); }), "once"));
  CHECK_FALSE(cluster.owns({}));
  CHECK(cluster.shapes().slot_count() == 0);
}

}  // namespace
}  // namespace tandem::mpi
