// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors

// One world on all ranks: mpirun -n 4 tandem-cluster cliff. Rank 0 prints one JSON object.

#include <cstdio>
#include <exception>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <string>

#include "arguments/arguments.h"
#include "measures.h"
#include "measures/json.h"
#include "scenes.h"
#include "tandem/mpi/cluster.h"

namespace {

using namespace tandem;
using namespace tandem::cluster_tool;

constexpr double kStep = 1.0 / 60.0;  // s

constexpr std::string_view kUsage =
    "usage: mpirun -n RANKS tandem-cluster SCENE [--size N] [--seconds S] [--sample-every STEPS]\n"
    "           [--balance-every STEPS] [--refresh-every STEPS] [--cut-above SHARE]\n"
    "           [--checkpoint FILE] [--checkpoint-every STEPS] [--resume FILE] [--die RANK:STEP]\n"
    "       ... --record PREFIX, then for each rank\n"
    "       tandem-cluster SCENE ... --replay PREFIX.RANK\n"
    "SCENE is cliff, cubes, edge, heap or pyramid. Steps 1/60 s, without waiting for the clock; "
    "rank 0\n"
    "prints the results. --size is the scene's: balls, stacks, bodies, cubes in a row.\n"
    "--checkpoint writes FILE every STEPS (600) and at the end; --resume continues from one, on "
    "any\n"
    "number of ranks. --die is for tests: that rank ends before that step. --record writes the\n"
    "input of each rank; --replay runs that rank alone, without mpirun, with otherwise the same\n"
    "options, and prints the processor time of each step.\n";

struct Options {
  std::string scene;
  std::size_t size = 0;
  double seconds = 6.0;
  int sample_every = 6;  ///< steps; 0 = never
  mpi::ClusterOptions cluster;
  std::string checkpoint;
  int checkpoint_every = 600;
  std::string resume;
  int die_rank = -1;
  std::uint64_t die_step = 0;
};

Options parse(std::span<const std::string_view> words) {
  Options options;
  const auto steps = [](int& into, int least) {
    return [&into, least](demos::Argument& in) {
      into = in.number(least, 1'000'000, "a number of steps");
    };
  };
  demos::read_arguments(
      words,
      {{"--size",
        [&](demos::Argument& in) {
          options.size = in.number(std::size_t{1}, std::size_t{100'000'000}, "an integer above 0");
        }},
       {"--seconds",
        [&](demos::Argument& in) { options.seconds = in.number(0.0, 1e6, "from 0 to 1e6 s"); }},
       {"--sample-every", steps(options.sample_every, 0)},
       {"--balance-every", steps(options.cluster.balance_every, 1)},
       {"--refresh-every", steps(options.cluster.refresh_every, 1)},
       {"--cut-above",
        [&](demos::Argument& in) { options.cluster.cut_above = in.number(0.0, 1.0, "0 to 1"); }},
       {"--checkpoint", [&](demos::Argument& in) { options.checkpoint = in.text(); }},
       {"--checkpoint-every", steps(options.checkpoint_every, 1)},
       {"--resume", [&](demos::Argument& in) { options.resume = in.text(); }},
       {"--record", [&](demos::Argument& in) { options.cluster.record = in.text(); }},
       {"--replay", [&](demos::Argument& in) { options.cluster.replay = in.text(); }},
       {"--die",
        [&](demos::Argument& in) {
          const std::string_view value = in.value();
          const std::size_t colon = value.find(':');
          if (colon == value.npos) demos::refuse("--die", value, "RANK:STEP");
          options.die_rank = demos::number("--die", value.substr(0, colon), 0, 1'000'000, "a rank");
          options.die_step = demos::number("--die", value.substr(colon + 1), std::uint64_t{0},
                                           ~std::uint64_t{0}, "a step");
        }}},
      [&](std::string_view word) {
        if (!options.scene.empty()) demos::refuse("SCENE", word, "one");
        options.scene = word;
      });
  const auto names = scene_names();
  if (std::find(names.begin(), names.end(), options.scene) == names.end()) {
    throw demos::UsageError(demos::unknown("scene", options.scene, names));
  }
  return options;
}

void fill(mpi::Cluster& cluster, const Scene& scene, bool with_bodies) {
  for (const SceneBody& body : scene.fixed) cluster.add(body.def, body.colliders);
  if (!with_bodies) return;
  const auto rank = static_cast<std::size_t>(cluster.rank());
  const auto count = static_cast<std::size_t>(cluster.count());
  for (std::size_t i = scene.bodies * rank / count; i < scene.bodies * (rank + 1) / count; ++i) {
    const SceneBody body = scene.body(i);
    cluster.add(body.def, body.colliders);
  }
  cluster.start();
}

mpi::ClusterOptions options_for(const Options& options, const Scene& scene) {
  mpi::ClusterOptions result = options.cluster;
  // The default suits about a thousand bodies.
  pbd::ContactOptions& contact = result.solver.contact;
  contact.extra_rows *= static_cast<int>(std::max<std::size_t>(1, scene.bodies / 1000));
  return result;
}

std::uint64_t step_count(const Options& options) {
  return static_cast<std::uint64_t>(options.seconds / kStep + 0.5);
}

/// Replays one rank of a run recorded without samples and checkpoints.
int replay(const Options& options) {
  const Scene scene = make_scene(options.scene, options.size);
  mpi::Cluster cluster(options_for(options, scene));
  fill(cluster, scene, true);
  cluster.totals();
  demos::JsonWriter json;
  json.begin_object().field("rank", cluster.rank()).field("ranks", cluster.count());
  json.key("step_s").begin_array();
  while (cluster.steps() < step_count(options)) {
    cluster.step(kStep);
    json.value(cluster.cost().cpu);
  }
  json.end_array().field("last_hash", std::to_string(cluster.totals().hash)).end_object();
  std::cout << json.text() << '\n';
  return 0;
}

int run(const Options& options) {
  const Scene scene = make_scene(options.scene, options.size);
  mpi::Cluster cluster(options_for(options, scene));
  fill(cluster, scene, options.resume.empty());
  if (!options.resume.empty()) cluster.load(options.resume);
  if (cluster.rank() == 0 && !options.checkpoint.empty()) {
    demos::require_writable_file("--checkpoint", options.checkpoint);
  }
  Measures measures(cluster, scene);
  const mpi::Totals first = cluster.totals();
  const std::uint64_t steps = step_count(options);
  std::uint64_t saved = 0;
  const auto save = [&] {
    if (options.checkpoint.empty() || saved == cluster.steps()) return;
    cluster.save(options.checkpoint);
    saved = cluster.steps();
    if (cluster.rank() == 0) {
      std::fprintf(stderr, "tandem-cluster: %s has step %llu\n", options.checkpoint.c_str(),
                   static_cast<unsigned long long>(saved));
    }
  };
  while (cluster.steps() < steps) {
    if (cluster.rank() == options.die_rank && cluster.steps() == options.die_step) std::_Exit(7);
    cluster.step(kStep);
    measures.note_step();
    const std::uint64_t at = cluster.steps();
    if (options.sample_every > 0 && at % static_cast<unsigned>(options.sample_every) == 0) {
      measures.sample(kStep * static_cast<double>(at));
    }
    if (at % static_cast<unsigned>(options.checkpoint_every) == 0) save();
  }
  save();
  const mpi::Totals last = cluster.totals();
  if (cluster.rank() != 0) return 0;
  demos::JsonWriter json;
  json.begin_object().field("scene", scene.name).field("bodies", scene.bodies);
  json.field("ranks", cluster.count());
  measures.write(json);
  const mpi::ClusterState& state = cluster.state();
  json.field("counted_imbalance", state.imbalance).field("balanced", state.balanced);
  json.field("first_hash", std::to_string(first.hash));
  json.field("last_hash", std::to_string(last.hash)).end_object();
  std::cout << json.text() << '\n';
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  // Errors of the command line are printed by one process, without MPI.
  std::unique_ptr<mpi::Environment> environment;
  return demos::program_main(argc, argv, kUsage, [&](std::span<const std::string_view> words) {
    const Options options = parse(words);
    if (!options.cluster.replay.empty()) return replay(options);
    environment = std::make_unique<mpi::Environment>(argc, argv);
    try {
      return run(options);
    } catch (const std::exception& error) {
      mpi::Environment::abort(std::string("tandem-cluster: ") + error.what());
    }
  });
}
