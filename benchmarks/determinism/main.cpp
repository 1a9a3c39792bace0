// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Runs ten scenes and prints the hash of all motion, one line each: name, steps, hash. Every
// machine and compiler gives the same (docs/determinism.md).
//   determinism [--steps N] [--lanes 2|4] [--seconds] [SCENE...]
// --seconds adds the processor time of each scene.
#include <cinttypes>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <string>
#include <vector>

#include "determinism/case.h"
#include "engine/tandem_joints.h"

namespace tandem::determinism {

SceneOptions scene_options(const Run& run) {
  pbd::SolverOptions solver{.contact = {.lanes = run.lanes}, .measure_stages = false};
  if (!run.sleeping) solver.sleep_after = 0.0;
  return {.solver = solver};
}

namespace {

constexpr double kStep = 1.0 / 60.0;  // s

/// A scene of the comparison between engines, built in a world of Tandem.
struct ToShape {
  template <class Other>
  collision::Shape operator()(const Other&) const {
    return Sphere{};
  }
  collision::Shape operator()(const bench::BoxShape& s) const { return Box{s.half_extents}; }
  collision::Shape operator()(const bench::SphereShape& s) const { return Sphere{s.radius}; }
  collision::Shape operator()(const bench::MeshShape& s) const {
    return collision::TriangleMesh::make(s->vertices, s->triangles);
  }
};

void build(Scene& scene, const bench::Scene& data) {
  std::vector<BodyId> ids;
  for (const bench::SceneBody& body : data.bodies) {
    pbd::BodyDef def{.type = body.type, .pose = body.pose, .twist = body.twist};
    if (body.type == BodyType::Dynamic) {
      def.mass = body.mass;
      def.inertia = body.inertia.asDiagonal();
    }
    ids.push_back(scene.world().add_body(def));
    if (!body.collides) continue;
    scene.shapes().add(scene.world(),
                       {.body = ids.back(),
                        .shape = std::visit(ToShape{}, body.shape),
                        .material = {.friction = body.friction, .restitution = body.restitution}});
  }
  bench::add_joints(scene.world(), data, ids);
}

using Build = std::function<void(Scene&)>;

std::uint64_t run_scene(const Run& run, const Build& make) {
  Scene scene(scene_options(run));
  make(scene);
  for (int i = 0; i < run.steps; ++i) scene.step(kStep);
  return scene.world().hash();
}

/// Half of the steps in one world, half in another restored from its snapshot.
std::uint64_t run_restored(const Run& run, const Build& make) {
  Scene first(scene_options(run));
  Scene second(scene_options(run));
  make(first);
  make(second);
  for (int i = 0; i < run.steps / 2; ++i) first.step(kStep);
  second.world().restore(first.world().snapshot());
  for (int i = run.steps / 2; i < run.steps; ++i) second.step(kStep);
  return second.world().hash();
}

struct Case {
  const char* name;
  int share_of_steps;  ///< 1: all; 10: a tenth, for slow scenes
  bool sleeping;       ///< false: keep solving bodies at rest, for a stricter test
  std::function<std::uint64_t(const Run&)> run;
};

std::vector<Case> cases() {
  std::vector<Case> all;
  for (const std::string_view name : bench::kPeerScenes) {
    const int share = name == "heap" ? 20 : 1;
    all.push_back({name.data(), share, false, [name](const Run& run) {
                     return run_scene(
                         run, [name](Scene& scene) { build(scene, bench::peer_scene(name)); });
                   }});
  }
  all.push_back({"machine", 1, true, [](const Run& run) { return run_scene(run, build_machine); }});
  all.push_back({"shapes", 1, true, [](const Run& run) { return run_scene(run, build_shapes); }});
  all.push_back(
      {"restored", 1, true, [](const Run& run) { return run_restored(run, build_shapes); }});
  all.push_back({"session", 1, true, run_session});
  return all;
}

}  // namespace

int run_all(const Run& run, bool seconds, const std::vector<std::string>& names) {
  for (const Case& one : cases()) {
    bool wanted = names.empty();
    for (const std::string& name : names) wanted = wanted || name == one.name;
    if (!wanted) continue;
    Run own = run;
    own.steps = run.steps / one.share_of_steps;
    own.sleeping = one.sleeping;
    const std::clock_t start = std::clock();
    const std::uint64_t hash = one.run(own);
    std::printf("%-9s %4d %016" PRIx64, one.name, own.steps, hash);
    if (seconds) std::printf(" %8.3f", static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
    std::printf("\n");
    std::fflush(stdout);
  }
  return 0;
}

}  // namespace tandem::determinism

int main(int count, char** arguments) {
  tandem::determinism::Run run;
  bool seconds = false;
  std::vector<std::string> names;
  for (int i = 1; i < count; ++i) {
    const std::string argument = arguments[i];
    if (argument == "--seconds") {
      seconds = true;
    } else if (argument == "--steps" && i + 1 < count) {
      run.steps = std::atoi(arguments[++i]);
    } else if (argument == "--lanes" && i + 1 < count) {
      run.lanes = std::atoi(arguments[++i]);
    } else if (argument.starts_with("--")) {
      std::fprintf(stderr,
                   "determinism: [--steps N] [--lanes 2|4] [--seconds] [SCENE...], not %s\n",
                   arguments[i]);
      return 2;
    } else {
      names.push_back(argument);
    }
  }
  return tandem::determinism::run_all(run, seconds, names);
}
