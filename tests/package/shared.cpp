// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// What goes through the walls between shared libraries: types made from templates on both sides,
// casts, exceptions, virtual calls into an application's classes. Compiled with hidden visibility,
// as plug-ins are.
#include <cstdio>
#include <stdexcept>
#include <string>
#include <typeinfo>
#include <vector>

#include "support/bodies.h"
#include "tandem/collision/contact_source.h"
#include "tandem/consensus/peer.h"
#include "tandem/consensus/virtual_network.h"
#include "tandem/net/tcp.h"
#include "tandem/obj/load_obj.h"
#include "tandem/pbd/distance_joint.h"
#include "tandem/pbd/solver.h"
#include "tandem/pbd/tether.h"

using namespace tandem;
using tandem::testing::refusal;

namespace {

int failures = 0;
void check(bool holds, const char* what) {
  if (holds) return;
  std::printf("shared: does not hold: %s\n", what);
  ++failures;
}

/// One type on both sides of a wall. ELF libraries share its typeinfo, by address; each DLL has its
/// own, which are equal by name.
bool is_one(const std::type_info& a, const std::type_info& b) {
#ifdef _WIN32
  return a == b;
#else
  return &a == &b;
#endif
}

/// An exception that no library has heard of.
struct Mine : std::runtime_error {
  Mine() : std::runtime_error("mine") {}
};

/// A transport of the application's, whose insides fail.
class Broken final : public consensus::Transport {
 public:
  consensus::PeerId self() const override { return 1; }
  bool post(consensus::PeerId, std::span<const std::byte>, consensus::Delivery) override {
    return true;
  }
  void drain(std::vector<consensus::Packet>&) override { throw Mine(); }
  void drop(consensus::PeerId, const std::string&) override {}
  std::vector<consensus::PeerStatus> peers() const override { return {}; }
};

/// A source of contacts on top of the library's own.
class Counting final : public collision::CollisionScene {
 public:
  void collect(const pbd::World& world, double dt, pbd::Workers& workers,
               std::vector<pbd::Manifold>& out) override {
    ++collected;
    collision::CollisionScene::collect(world, dt, workers, out);
  }
  int collected = 0;
};

}  // namespace

int main() {
  pbd::World world;
  pbd::Solver solver;

  // Blocks made from a template here and in two libraries are of one type each.
  world.add_block<pbd::DistanceJoints>();
  consensus::VirtualNetwork network;
  consensus::Peer peer(world, network.transport(1));  // adds a block of tethers
  int tethers = 0;
  int rods = 0;
  for (const auto& block : world.blocks()) {
    const pbd::ConstraintBlock& any = *block;
    if (dynamic_cast<const pbd::Tethers*>(&any) != nullptr) ++tethers;
    if (dynamic_cast<const pbd::DistanceJoints*>(&any) != nullptr) ++rods;
    if (is_one(typeid(any), typeid(pbd::Tethers))) tethers += 10;
  }
  check(tethers == 11,
        "the peer's block of tethers is the application's type, by typeinfo as well");
  check(rods == 1, "a block that the application made is its type");
  check(dynamic_cast<consensus::Peer*>(world.target_source()) == &peer, "a peer is what it was");
  const pbd::TargetSource& source = *world.target_source();
  check(is_one(typeid(source), typeid(consensus::Peer)), "one type, one typeinfo");

  // A class of the application's, called by the libraries.
  Counting scene;
  world.set_contact_source(&scene);
  const pbd::BodyId ground = world.add_body({.type = pbd::BodyType::Static});
  const pbd::BodyId ball = world.add_body({.pose = {.position = pbd::Vec3(0.0, 0.0, 0.1)}});
  scene.add(world, {.body = ground, .shape = collision::HalfSpace{}});
  scene.add(world, {.body = ball, .shape = collision::Sphere{0.1}});
  for (int i = 0; i < 30; ++i) {
    if (solver.step(world, 1.0 / 60.0).status != pbd::StepStatus::Ok) return 1;
  }
  check(scene.collected == 30, "the solver calls the application's contact source");
  check(world.in_contact(ball), "which calls the library's");
  check(dynamic_cast<collision::CollisionScene*>(world.contact_source()) == &scene,
        "a derived contact source is a collision scene");

  // Exceptions of each library, as what they are.
  check(!refusal([&] { world.add_body({.mass = -1.0}); }).empty(), "pbd throws invalid_argument");
  check(
      !refusal([&] { scene.add(world, {.body = ball, .shape = collision::Sphere{-1.0}}); }).empty(),
      "collision throws invalid_argument");
  check(!refusal([&] { peer.share({}); }).empty(), "consensus throws invalid_argument");
  check(!refusal([] { net::TcpOptions{}.validate(); }).empty(), "net throws invalid_argument");
  bool refused = false;
  try {
    obj::parse_obj("f 1 2 3\n", "nothing");
  } catch (const std::exception&) {
    refused = true;
  }
  check(refused, "obj throws a std::exception");

  // And of the application's own, through a library.
  pbd::World other;
  Broken broken;
  consensus::Peer lost(other, broken);
  bool mine = false;
  try {
    lost.before_step(1'000'000'000);
  } catch (const Mine& error) {
    mine = std::string(error.what()) == "mine";
  }
  check(mine, "an application's exception passes through a library");
  if (failures == 0) std::puts("shared: types, casts and exceptions are one on both sides");
  return failures == 0 ? 0 : 1;
}
