// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// glTF's binary container: what it holds, and lengths that lie.
#include <cstring>
#include <string>

#include "support/bodies.h"
#include "support/catch.h"
#include "support/folder.h"
#include "tandem/pbd/random.h"
#include "tandem/scene_files.h"

namespace glb_test {

using namespace tandem;
using tandem::testing::names;
using tandem::testing::refusal;

std::string number(std::uint32_t value) {
  std::string out;
  for (int i = 0; i < 4; ++i) out += static_cast<char>(value >> 8 * i & 0xff);
  return out;
}
std::string chunk(const std::string& type, std::string bytes, char filling) {
  while (bytes.size() % 4 != 0) bytes += filling;
  return number(static_cast<std::uint32_t>(bytes.size())) + type + bytes;
}
std::string container(const std::string& chunks) {
  return "glTF" + number(2) + number(static_cast<std::uint32_t>(12 + chunks.size())) + chunks;
}

/// A stone whose hull is a box of 0.2 x 0.4 x 0.6 m about (1, 0, 0), of 9 kg.
const std::string kJson = R"({"asset": {"version": "2.0"}, "buffers": [{"byteLength": 108}],
 "bufferViews": [{"buffer": 0, "byteLength": 108}],
 "accessors": [{"bufferView": 0, "componentType": 5126, "count": 9, "type": "VEC3"}],
 "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
 "extensions": {"KHR_physics_rigid_bodies": {}},
 "nodes": [{"name": "stone", "mesh": 0, "extensions": {"KHR_physics_rigid_bodies": {
   "motion": {"mass": 9}, "collider": {"geometry": {"node": 0, "convexHull": true}}}}}]})";

std::string corners() {
  std::string out;
  for (const int i : {0, 1, 2, 3, 4, 5, 6, 7, 7}) {
    const float at[] = {(i & 1) != 0 ? 1.1f : 0.9f, (i & 2) != 0 ? 0.2f : -0.2f,
                        (i & 4) != 0 ? 0.3f : -0.3f};
    out.append(reinterpret_cast<const char*>(at), sizeof at);
  }
  return out;
}
std::string good() {
  return container(chunk("JSON", kJson, ' ') + chunk(std::string("BIN\0", 4), corners(), '\0'));
}

TEST_CASE("glb: buffers come from the container, and files may stand beside it", "[gltf]") {
  const auto check = [](SceneFile file) {
    const pbd::BodyProps& props = file.scene.world().props(file.find("stone"));
    CHECK(props.mass == Approx(9.0));
    // About the file's y, which is the world's z.
    const Vec3 up =
        file.scene.world().pose(file.find("stone")).orientation.conjugate() * Vec3::UnitZ();
    CHECK(up.dot(props.inertia * up) == Approx(9.0 / 12.0 * (0.04 + 0.36)).epsilon(1e-6));
    CHECK(file.scene.world().pose(file.find("stone")).position.x() == Approx(1.0).epsilon(1e-6));
  };
  check(parse_gltf(good(), {}));
  const tandem::testing::Folder folder;
  folder.write("stone.glb", good());
  check(load_scene(folder.file("stone.glb")));
  // Other chunks are passed over.
  check(parse_gltf(
      container(chunk("JSON", kJson, ' ') + chunk(std::string("BIN\0", 4), corners(), '\0') +
                chunk("ELSE", "12345678", ' ')),
      {}));
  folder.write("stone.bin", corners());
  std::string apart = kJson;
  apart.replace(apart.find("{\"byteLength\": 108}"), 1, "{\"uri\": \"stone.bin\", ");
  check(parse_gltf(container(chunk("JSON", apart, ' ')), folder.file("")));
}

TEST_CASE("glb: lengths that differ from the content's are refused", "[gltf][errors]") {
  const auto with = [](std::size_t at, std::uint32_t value) {
    std::string bytes = good();
    bytes.replace(at, 4, number(value));
    return refusal([&] { parse_gltf(bytes, {}, {}, "x.glb"); });
  };
  CHECK(names(with(4, 1), "x.glb: container's version", "1", "2"));
  CHECK(names(with(8, 0xffffffffu), "container's length", "4294967295", "that of the file"));
  CHECK(names(with(8, 12), "container's length", "12", "that of the file"));
  CHECK(names(with(12, 0xfffffff8u), "chunk's length", "4294967288", "within the file"));
  CHECK(names(with(12, 3), "chunk's length", "3", "multiple of 4"));
  CHECK(names(with(16, 7), "first chunk's type", "7", "JSON"));
  CHECK(names(refusal([] { parse_gltf("glTF", {}); }), "container", "4", "12 bytes"));
  CHECK(names(refusal([] { parse_gltf(container("1234"), {}); }), "chunk", "4", "8 bytes"));
  CHECK_THROWS_AS(parse_gltf(container(""), {}), SceneFileError);
  // Without the binary, and with less of it than the views say.
  CHECK(names(refusal([] { parse_gltf(container(chunk("JSON", kJson, ' ')), {}); }), "/buffers/0",
              "uri", "uri"));
  CHECK(names(refusal([] {
                parse_gltf(
                    container(chunk("JSON", kJson, ' ') +
                              chunk(std::string("BIN\0", 4), corners().substr(0, 104), '\0')),
                    {});
              }),
              "/bufferViews/", "{...}", "within its buffer"));
}

TEST_CASE("glb: any changed bytes are read or refused", "[gltf][errors]") {
  pbd::SplitMix64 random(11);
  int refused = 0;
  for (int i = 0; i < 4000; ++i) {
    std::string bytes = good();
    for (int k = 0; k < 1 + i % 3; ++k) {
      const std::size_t most = i % 2 == 0 ? 24 : bytes.size();
      bytes[random.below(most)] = static_cast<char>(random.below(256));
    }
    if (i % 5 == 0) bytes.resize(random.below(bytes.size()));
    try {
      parse_gltf(bytes, {});
    } catch (const SceneFileError&) {
      ++refused;
    }
  }
  CHECK(refused > 1000);
  CHECK(refused < 4000);
}

}  // namespace glb_test
