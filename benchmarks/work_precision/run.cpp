// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "work_precision/run.h"

#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <fstream>
#include <map>

#include "arguments/arguments.h"
#include "measure/clock.h"
#include "measure/quality.h"
#include "scenes/joint_scenes.h"
#include "work_precision/options.h"

namespace tandem::bench {
namespace {

struct Times {
  std::vector<double> wall_s, cpu_s;  ///< per frame with an awake body
  std::map<std::string, std::vector<double>> stage_s;
  int substeps = 0;
};

Measures summary(const Times& times) {
  Measures out;
  const auto add = [&](const std::string& name, double s) { out.emplace_back(name, 1e3 * s); };
  add("cpu_ms_p50", quantile(times.cpu_s, 0.5));
  add("cpu_ms_mean", mean(times.cpu_s));
  add("cpu_ms_p99", quantile(times.cpu_s, 0.99));
  add("cpu_ms_max", quantile(times.cpu_s, 1.0));
  add("cpu_ms_first", times.cpu_s.front());
  add("wall_ms_p50", quantile(times.wall_s, 0.5));
  add("wall_ms_mean", mean(times.wall_s));
  add("wall_ms_p99", quantile(times.wall_s, 0.99));
  const std::size_t last = std::min<std::size_t>(120, times.cpu_s.size());
  add("cpu_ms_last_2s",
      mean({times.cpu_s.end() - static_cast<std::ptrdiff_t>(last), times.cpu_s.end()}));
  out.emplace_back("substeps", times.substeps);
  // Setup in the first two frames does not count as a late outlier.
  const double slow_s = 4.0 * quantile(times.cpu_s, 0.5);
  const auto late = times.cpu_s.begin() + std::min<std::ptrdiff_t>(2, std::ssize(times.cpu_s));
  out.emplace_back("slow_frames", std::count_if(late, times.cpu_s.end(),
                                                [slow_s](double s) { return s > slow_s; }));
  return out;
}

/// FNV-1a over the bits of all states: equal bits, equal hash.
std::string hash_of(const Scene& scene, const Engine& engine) {
  std::uint64_t hash = 0xcbf29ce484222325ull;
  const auto mix = [&](const double* values, int count) {
    for (int i = 0; i < count; ++i) {
      hash = (hash ^ std::bit_cast<std::uint64_t>(values[i])) * 0x100000001b3ull;
    }
  };
  for (int i = 0; i < static_cast<int>(scene.bodies.size()); ++i) {
    const pbd::BodyState s = engine.state(i);
    mix(s.pose.position.data(), 3);
    mix(s.pose.orientation.coeffs().data(), 4);
    mix(s.twist.linear.data(), 3);
    mix(s.twist.angular.data(), 3);
  }
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash));
  return text;
}

/// KB of resident memory; 0 if unknown.
double resident_kb() {
  std::ifstream file("/proc/self/statm");
  double all = 0.0;
  double resident = 0.0;
  file >> all >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1024.0;
}

void print_json(const std::string& engine, const RunOptions& options, const Measures& measures,
                const std::string& hash) {
  std::printf("{\"engine\": \"%s\", \"scene\": \"%s\", \"hash\": \"%s\"", engine.c_str(),
              options.scene.c_str(), hash.c_str());
  for (const auto& [name, value] : measures) {
    if (std::isfinite(value)) {
      std::printf(", \"%s\": %.9g", name.c_str(), value);
    } else {
      std::printf(", \"%s\": null", name.c_str());
    }
  }
  std::printf("}\n");
}

void print_text(const std::string& engine, const RunOptions& options, const Measures& measures,
                const std::string& hash) {
  std::printf("%s %s, hash %s\n", engine.c_str(), options.scene.c_str(), hash.c_str());
  for (const auto& [name, value] : measures) std::printf("  %-26s %.6g\n", name.c_str(), value);
}

void print_frames(const Times& times) {
  for (std::size_t i = 0; i < times.cpu_s.size(); ++i) {
    std::printf("frame %zu cpu_ms %.4f wall_ms %.4f\n", i, 1e3 * times.cpu_s[i],
                1e3 * times.wall_s[i]);
  }
}

bool something_awake(const Scene& scene, const Engine& engine) {
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const bool moves = scene.bodies[i].type == BodyType::Dynamic;
    if (moves && engine.awake(static_cast<int>(i))) return true;
  }
  return false;
}

void run(const RunOptions& options, const MakeEngine& make) {
  Scene scene = is_joint_scene(options.scene) ? joint_scene(options.scene, options.size)
                                              : peer_scene(options.scene);
  if (options.frames > 0) scene.seconds = options.frames * scene.dt;
  const double memory_kb = resident_kb();
  const std::unique_ptr<Engine> engine = make(scene, options.settings);
  Quality quality(
      scene, *engine,
      options.reference.empty() ? std::vector<Vec3>{} : read_reference(options.reference));
  Times times;
  for (int frame = 0; frame < scene.frames(); ++frame) {
    const bool awake = !options.settings.sleeping || something_awake(scene, *engine);
    const double wall = wall_seconds();
    const double cpu = thread_seconds();
    engine->step(scene.dt);
    if (awake) {
      times.cpu_s.push_back(thread_seconds() - cpu);
      times.wall_s.push_back(wall_seconds() - wall);
    }
    const EngineStats stats = engine->stats();
    times.substeps = std::max(times.substeps, stats.substeps);
    if (options.stages) {
      for (const auto& [name, s] : stats.stage_s) times.stage_s[name].push_back(s);
    }
    quality.after_frame(frame, *engine);
  }
  Measures measures = summary(times);
  measures.emplace_back("memory_kb_per_body",
                        (resident_kb() - memory_kb) / static_cast<double>(scene.bodies.size()));
  for (const auto& m : quality.finish(*engine)) measures.push_back(m);
  for (const auto& [name, s] : times.stage_s) {
    measures.emplace_back("stage_" + name + "_ms_mean", 1e3 * mean(s));
  }
  if (options.per_frame) print_frames(times);
  (options.json ? print_json : print_text)(engine->name(), options, measures,
                                           hash_of(scene, *engine));
}

}  // namespace

int work_precision_main(int argc, char** argv, const MakeEngine& make) {
  constexpr std::string_view kUsage =
      "usage: work_precision_<engine> --scene NAME [--size N] [--substeps N] [--iterations N]\n"
      "         [--velocity-iterations N] [--threads N] [--frames N | --seconds S] [--json]\n"
      "         [--stages] [--per-frame] [--sleeping] [--reference FILE]\n"
      "Scenes: cliff, stacks, katamari, chain, heap, ratio, pyramid; of joints, which have a "
      "size:\n"
      "human, rain, wedge, joint_grid, ball_and_chain, bridge, crane, doors.\n"
      "Unset options keep the engine's defaults.\n";
  return demos::program_main(argc, argv, kUsage, [&](std::span<const std::string_view> words) {
    run(parse_arguments(words), make);
    return 0;
  });
}

}  // namespace tandem::bench
