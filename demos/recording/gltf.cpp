// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "recording/gltf.h"

#include <tiny_gltf.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <map>
#include <optional>
#include <stdexcept>
#include <utility>

#include "recording/shape_mesh.h"

namespace tandem::demos {
namespace {

constexpr double kPositionTolerance = 1e-4;  // m
constexpr double kAngleTolerance = 2e-3;     // rad
constexpr double kGhost = 0.35;              // opacity of peers after the first

// Red, green, blue; distinguishable for the colour-blind.
constexpr std::array<std::array<double, 3>, 6> kPalette = {{{0.90, 0.62, 0.00},
                                                            {0.34, 0.71, 0.91},
                                                            {0.00, 0.62, 0.45},
                                                            {0.94, 0.89, 0.26},
                                                            {0.84, 0.37, 0.00},
                                                            {0.80, 0.47, 0.65}}};

std::vector<double> position_of(const pbd::Vec3& v) { return {v.x(), v.y(), v.z()}; }
std::vector<double> rotation_of(const pbd::Quat& q) { return {q.x(), q.y(), q.z(), q.w()}; }

/// Indices of samples to keep; linear interpolation covers the rest.
std::vector<std::size_t> needed(const std::vector<TrackSample>& samples) {
  std::vector<std::size_t> kept;
  const auto near = [&](std::size_t from, std::size_t to) {
    const TrackSample& a = samples[from];
    const TrackSample& b = samples[to];
    for (std::size_t i = from + 1; i < to; ++i) {
      const TrackSample& s = samples[i];
      const double f = static_cast<double>(s.time - a.time) / static_cast<double>(b.time - a.time);
      const pbd::Vec3 position = a.position + f * (b.position - a.position);
      if ((position - s.position).norm() > kPositionTolerance) return false;
      const pbd::Quat turned = a.orientation.slerp(f, b.orientation);
      if (turned.angularDistance(s.orientation) > kAngleTolerance) return false;
    }
    return true;
  };
  constexpr std::size_t kMaxSkipped = 64;
  for (std::size_t at = 0; at < samples.size();) {
    kept.push_back(at);
    std::size_t next = at + 1;
    while (next + 1 < samples.size() && next - at < kMaxSkipped && near(at, next + 1)) ++next;
    at = next;
  }
  return kept;
}

class Writer {
 public:
  Writer() {
    model_.asset.version = "2.0";
    model_.asset.generator = "tandem";
    model_.buffers.emplace_back();
    // z is up here, y in glTF.
    root_ = add_node("tandem", {});
    model_.nodes[at(root_)].rotation = {-std::sqrt(0.5), 0.0, 0.0, std::sqrt(0.5)};
    model_.scenes.emplace_back();
    model_.scenes[0].nodes.push_back(root_);
    model_.defaultScene = 0;
  }

  void add_fixed(const Scene& scene) {
    const int group = add_node("fixed", root_);
    const int material = add_material("fixed", {0.62, 0.62, 0.60}, 1.0);
    for (std::size_t i = 0; i < scene.fixed.size(); ++i) {
      const FixedPart& part = scene.fixed[i];
      const int node = add_node("fixed " + std::to_string(i), group);
      place(node, part.pose);
      model_.nodes[at(node)].mesh = add_mesh(part.shape, material);
    }
  }

  void add_peer(const Scene& scene, const PeerRecord& peer, bool first,
                consensus::SessionTime start) {
    const std::string name = "peer " + std::to_string(peer.id);
    const int group = add_node(name, root_);
    std::vector<int> materials;
    for (std::size_t i = 0; i < kPalette.size(); ++i) {
      materials.push_back(
          add_material(name + " " + std::to_string(i), kPalette[i], first ? 1.0 : kGhost));
    }
    for (std::size_t i = 0; i < scene.bodies.size() && i < peer.tracks.size(); ++i) {
      const std::vector<TrackSample>& samples = peer.tracks[i].samples();
      if (samples.empty()) continue;
      const SceneBody& body = scene.bodies[i];
      const int node = add_node(name + " " + body.name, group);
      place(node, {samples[0].position, samples[0].orientation});
      for (const ScenePart& part : body.parts) {
        const int child = add_node(body.name, node);
        place(child, part.local);
        model_.nodes[at(child)].mesh = add_mesh(part.shape, materials[i % materials.size()]);
      }
      animate(node, samples, start);
    }
  }

  void write(const std::string& file) {
    if (!animation_.channels.empty()) {
      animation_.name = "run";
      model_.animations.push_back(std::move(animation_));
    }
    // Through our own stream: tinygltf does not report failed writes to files.
    std::ofstream out(file, std::ios::binary);
    if (!out || !tinygltf::TinyGLTF().WriteGltfSceneToStream(&model_, out, false, true) ||
        !out.flush()) {
      throw std::runtime_error("cannot write " + file);
    }
  }

 private:
  static std::size_t at(int index) { return static_cast<std::size_t>(index); }

  int add_node(const std::string& name, std::optional<int> parent) {
    tinygltf::Node node;
    node.name = name;
    model_.nodes.push_back(std::move(node));
    const int index = static_cast<int>(model_.nodes.size()) - 1;
    if (parent) model_.nodes[at(*parent)].children.push_back(index);
    return index;
  }

  void place(int node, const pbd::Pose& pose) {
    model_.nodes[at(node)].translation = position_of(pose.position);
    model_.nodes[at(node)].rotation = rotation_of(pose.orientation.normalized());
  }

  int add_material(const std::string& name, const std::array<double, 3>& colour, double opacity) {
    tinygltf::Material material;
    material.name = name;
    material.pbrMetallicRoughness.baseColorFactor = {colour[0], colour[1], colour[2], opacity};
    material.pbrMetallicRoughness.metallicFactor = 0.0;
    material.pbrMetallicRoughness.roughnessFactor = 0.8;
    if (opacity < 1.0) material.alphaMode = "BLEND";
    model_.materials.push_back(std::move(material));
    return static_cast<int>(model_.materials.size()) - 1;
  }

  /// The existing mesh of equal shape and material, or a new one.
  int add_mesh(const collision::Shape& shape, int material) {
    ShapeMesh mesh = shape_mesh(shape);
    const auto found = meshes_.find({mesh, material});
    if (found != meshes_.end()) return found->second;
    auto geometry = geometries_.find(mesh);
    if (geometry == geometries_.end()) {
      const std::array<int, 3> accessors = {
          floats(mesh.positions, TINYGLTF_TYPE_VEC3, TINYGLTF_TARGET_ARRAY_BUFFER),
          floats(mesh.normals, TINYGLTF_TYPE_VEC3, TINYGLTF_TARGET_ARRAY_BUFFER),
          indices(mesh.indices)};
      geometry = geometries_.emplace(mesh, accessors).first;
    }
    tinygltf::Primitive primitive;
    primitive.attributes["POSITION"] = geometry->second[0];
    primitive.attributes["NORMAL"] = geometry->second[1];
    primitive.indices = geometry->second[2];
    primitive.material = material;
    primitive.mode = TINYGLTF_MODE_TRIANGLES;
    tinygltf::Mesh made;
    made.primitives.push_back(std::move(primitive));
    model_.meshes.push_back(std::move(made));
    const int index = static_cast<int>(model_.meshes.size()) - 1;
    meshes_.emplace(std::pair{std::move(mesh), material}, index);
    return index;
  }

  void animate(int node, const std::vector<TrackSample>& samples, consensus::SessionTime start) {
    const std::vector<std::size_t> keys = needed(samples);
    if (keys.size() < 2) return;
    std::vector<float> times, positions, rotations;
    pbd::Quat last = pbd::Quat::Identity();
    for (const std::size_t k : keys) {
      const TrackSample& sample = samples[k];
      const auto time = static_cast<float>(1e-9 * static_cast<double>(sample.time - start));
      // Times must increase in 32 bits too.
      if (!times.empty() && !(time > times.back())) continue;
      times.push_back(time);
      for (const double x : position_of(sample.position))
        positions.push_back(static_cast<float>(x));
      // The shorter arc, as slerp expects.
      pbd::Quat turn = sample.orientation.normalized();
      if (turn.dot(last) < 0.0) turn.coeffs() = -turn.coeffs();
      last = turn;
      for (const double x : rotation_of(turn)) rotations.push_back(static_cast<float>(x));
    }
    const int input = floats(times, TINYGLTF_TYPE_SCALAR, 0);
    add_channel(node, "translation", input, floats(positions, TINYGLTF_TYPE_VEC3, 0));
    add_channel(node, "rotation", input, floats(rotations, TINYGLTF_TYPE_VEC4, 0));
  }

  void add_channel(int node, const char* path, int input, int output) {
    tinygltf::AnimationSampler sampler;
    sampler.input = input;
    sampler.output = output;
    sampler.interpolation = "LINEAR";
    tinygltf::AnimationChannel channel;
    channel.sampler = static_cast<int>(animation_.samplers.size());
    channel.target_node = node;
    channel.target_path = path;
    animation_.samplers.push_back(std::move(sampler));
    animation_.channels.push_back(std::move(channel));
  }

  template <class Value>
  int view(const std::vector<Value>& values, int target) {
    std::vector<unsigned char>& bytes = model_.buffers[0].data;
    tinygltf::BufferView made;
    made.buffer = 0;
    made.byteOffset = bytes.size();
    made.byteLength = values.size() * sizeof(Value);
    made.target = target;
    bytes.resize(bytes.size() + made.byteLength);  // a multiple of four
    std::memcpy(bytes.data() + made.byteOffset, values.data(), made.byteLength);
    model_.bufferViews.push_back(std::move(made));
    return static_cast<int>(model_.bufferViews.size()) - 1;
  }

  int floats(const std::vector<float>& values, int type, int target) {
    const auto width = static_cast<std::size_t>(
        tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(type)));
    tinygltf::Accessor accessor;
    accessor.bufferView = view(values, target);
    accessor.componentType = TINYGLTF_COMPONENT_TYPE_FLOAT;
    accessor.count = values.size() / width;
    accessor.type = type;
    accessor.minValues.assign(width, std::numeric_limits<double>::max());
    accessor.maxValues.assign(width, std::numeric_limits<double>::lowest());
    for (std::size_t i = 0; i < values.size(); ++i) {
      double& low = accessor.minValues[i % width];
      double& high = accessor.maxValues[i % width];
      low = std::min(low, static_cast<double>(values[i]));
      high = std::max(high, static_cast<double>(values[i]));
    }
    model_.accessors.push_back(std::move(accessor));
    return static_cast<int>(model_.accessors.size()) - 1;
  }

  int indices(const std::vector<std::uint32_t>& values) {
    tinygltf::Accessor accessor;
    accessor.bufferView = view(values, TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER);
    accessor.componentType = TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
    accessor.count = values.size();
    accessor.type = TINYGLTF_TYPE_SCALAR;
    model_.accessors.push_back(std::move(accessor));
    return static_cast<int>(model_.accessors.size()) - 1;
  }

  tinygltf::Model model_;
  tinygltf::Animation animation_;
  std::map<ShapeMesh, std::array<int, 3>> geometries_;
  std::map<std::pair<ShapeMesh, int>, int> meshes_;
  int root_ = 0;
};

}  // namespace

void write_glb(const std::string& file, const Scene& scene, const std::vector<PeerRecord>& peers) {
  consensus::SessionTime start = std::numeric_limits<consensus::SessionTime>::max();
  for (const PeerRecord& peer : peers) {
    for (const Track& track : peer.tracks) {
      if (!track.empty()) start = std::min(start, track.samples().front().time);
    }
  }
  Writer writer;
  writer.add_fixed(scene);
  for (std::size_t i = 0; i < peers.size(); ++i) {
    writer.add_peer(scene, peers[i], i == 0, start);
  }
  writer.write(file);
}

}  // namespace tandem::demos
