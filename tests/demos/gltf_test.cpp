// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "recording/gltf.h"

#include <tiny_gltf.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "runner/virtual_runner.h"
#include "runs.h"
#include "scenes/cubes.h"
#include "support/catch.h"

namespace tandem::demos::gltf_test {
namespace {

std::vector<float> floats(const tinygltf::Model& model, int accessor) {
  const auto& made = model.accessors[static_cast<std::size_t>(accessor)];
  const auto& view = model.bufferViews[static_cast<std::size_t>(made.bufferView)];
  const std::size_t width = made.type == TINYGLTF_TYPE_SCALAR ? 1
                            : made.type == TINYGLTF_TYPE_VEC3 ? 3
                                                              : 4;
  std::vector<float> values(made.count * width);
  std::memcpy(values.data(), model.buffers[0].data.data() + view.byteOffset,
              values.size() * sizeof(float));
  return values;
}

/// A sampler's value at a time, as a viewer interpolates translations.
pbd::Vec3 translation(const tinygltf::Model& model, const tinygltf::AnimationSampler& sampler,
                      double time) {
  const std::vector<float> times = floats(model, sampler.input);
  const std::vector<float> values = floats(model, sampler.output);
  std::size_t next = 1;
  while (next + 1 < times.size() && static_cast<double>(times[next]) < time) ++next;
  const double f = std::clamp((time - static_cast<double>(times[next - 1])) /
                                  static_cast<double>(times[next] - times[next - 1]),
                              0.0, 1.0);
  pbd::Vec3 result;
  for (int k = 0; k < 3; ++k) {
    const auto i = static_cast<std::size_t>(k);
    const double a = static_cast<double>(values[3 * (next - 1) + i]);
    result[k] = a + f * (static_cast<double>(values[3 * next + i]) - a);
  }
  return result;
}

TEST_CASE("gltf: a recording shows each body of each peer where it was", "[demos]") {
  const CubesScenario scenario({.stacks = 2, .height = 3, .plate = pbd::Vec3(0.8, 0.8, 0.04)});
  const RunResult run = run_virtual(scenario, quiet(4, 4.0));
  const Scene scene = scenario.build({});
  const auto file = std::filesystem::temp_directory_path() / "tandem-gltf-test.glb";
  write_glb(file.string(), scene, run.peers);

  tinygltf::Model model;
  tinygltf::TinyGLTF in;
  std::string fault, warning;
  REQUIRE(in.LoadBinaryFromFile(&model, &fault, &warning, file.string()));
  std::filesystem::remove(file);
  CHECK(fault.empty());
  CHECK(warning.empty());
  REQUIRE(model.animations.size() == 1);

  const consensus::SessionTime start = run.peers[0].tracks[0].samples().front().time;
  std::size_t moved = 0;
  for (const auto& channel : model.animations[0].channels) {
    if (channel.target_path != "translation") continue;
    const std::string& name = model.nodes[static_cast<std::size_t>(channel.target_node)].name;
    for (const PeerRecord& peer : run.peers) {
      const std::string prefix = "peer " + std::to_string(peer.id) + " ";
      if (!name.starts_with(prefix)) continue;
      const Track& track = peer.tracks[scene.index_of(name.substr(prefix.size()))];
      const auto& sampler = model.animations[0].samplers[static_cast<std::size_t>(channel.sampler)];
      ++moved;
      for (const TrackSample& sample : track.samples()) {
        const double time = 1e-9 * static_cast<double>(sample.time - start);
        // Omitted samples are within 0.1 mm; times have 24 bits.
        REQUIRE((translation(model, sampler, time) - sample.position).norm() < 1.2e-4);
      }
    }
  }
  CHECK(moved == 2 * scene.bodies.size());
}

TEST_CASE("gltf: a file that cannot be written is named", "[demos]") {
  const CubesScenario scenario;
  CHECK_THROWS_WITH(write_glb("/nowhere/at/all.glb", scenario.build({}), {}),
                    Catch::Contains("/nowhere/at/all.glb"));
}

}  // namespace
}  // namespace tandem::demos::gltf_test
