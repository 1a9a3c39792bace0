// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <cmath>
#include <cstring>
#include <filesystem>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include "support/bodies.h"
#include "support/catch.h"
#include "support/folder.h"
#include "tandem/pbd/random.h"
#include "tandem/scene_files.h"

namespace gltf_test {

using namespace tandem;
using tandem::testing::names;
using tandem::testing::refusal;

/// Bytes of floats, then of indices.
std::string bytes_of(const std::vector<float>& points, const std::vector<std::uint16_t>& corners) {
  std::string out(points.size() * 4 + corners.size() * 2, '\0');
  std::memcpy(out.data(), points.data(), points.size() * 4);
  std::memcpy(out.data() + points.size() * 4, corners.data(), corners.size() * 2);
  return out;
}

std::string base64(const std::string& bytes) {
  const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t held = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      held = held << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    }
    for (int k = 0; k < 4; ++k) {
      out +=
          i + static_cast<std::size_t>(k) > bytes.size() ? '=' : digits[held >> (18 - 6 * k) & 63];
    }
  }
  return out;
}

// A square of 20 m at y = 0, seen from above, and an octahedron of 0.3 m.
const std::vector<float> kPoints{-10, 0,   -10,   -10, 0, 10,    10,   0, 10, 10,
                                 0,   -10, 0.3f,  0,   0, -0.3f, 0,    0, 0,  0.3f,
                                 0,   0,   -0.3f, 0,   0, 0,     0.3f, 0, 0,  -0.3f};
const std::vector<std::uint16_t> kCorners{0, 1, 2, 0, 2, 3};

std::string document(const std::string& uri) {
  return R"({"asset": {"version": "2.0"}, "buffers": [{"uri": ")" + uri + R"(", "byteLength": 132}],
 "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 72},
   {"buffer": 0, "byteOffset": 120, "byteLength": 12}],
 "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
   {"bufferView": 1, "componentType": 5126, "count": 6, "type": "VEC3"},
   {"bufferView": 2, "componentType": 5123, "count": 6, "type": "SCALAR"}],
 "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 2}]}, {"primitives": [{"attributes": {"POSITION": 1}}]}],
 "extensions": {"KHR_implicit_shapes": {"shapes": [{"type": "box", "box": {"size": [0.4, 0.2, 0.6]}},
     {"type": "capsule", "capsule": {"height": 1, "radiusTop": 0.1, "radiusBottom": 0.1}}]},
   "KHR_physics_rigid_bodies": {"physicsMaterials": [{"staticFriction": 0.9, "dynamicFriction": 0.7, "restitution": 0}],
     "collisionFilters": [{"collisionSystems": ["rods"], "collideWithSystems": []}],
     "physicsJoints": [{"limits": [{"linearAxes": [0, 1, 2], "min": 0, "max": 0}, {"angularAxes": [1, 2], "min": 0, "max": 0}]}]}},
 "nodes": [
  {"name": "ground", "mesh": 0, "extensions": {"KHR_physics_rigid_bodies": {"collider": {"geometry": {"node": 0}, "physicsMaterial": 0}}}},
  {"name": "box", "translation": [0, 0.4, 2], "scale": [0.5, 2, 1], "extensions": {"KHR_physics_rigid_bodies": {
    "motion": {"mass": 5, "linearVelocity": [0, -1, 0]}, "collider": {"geometry": {"shape": 0}, "physicsMaterial": 0}}}},
  {"name": "stone", "mesh": 1, "translation": [3, 0.6, 0], "rotation": [0.2, 0, 0.15, 0.9682458365518543], "extensions": {"KHR_physics_rigid_bodies": {
    "motion": {}, "collider": {"geometry": {"node": 2, "convexHull": true}}}}},
  {"name": "rod", "translation": [-3, 2, 0], "children": [4], "extensions": {"KHR_physics_rigid_bodies": {
    "motion": {"mass": 2, "centerOfMass": [0, -0.5, 0], "inertiaDiagonal": [0.1, 0.02, 0.1], "angularVelocity": [0.2, 0, 0], "linearVelocity": [0, 0, 0.1]},
    "joint": {"connectedNode": 5, "joint": 0}}}},
  {"translation": [0, -0.5, 0], "extensions": {"KHR_physics_rigid_bodies": {"collider": {"geometry": {"shape": 1}, "collisionFilter": 0}}}},
  {"name": "hook", "translation": [-3, 2, 0]}],
 "animations": []})";
}

std::string embedded() {
  return document("data:application/octet-stream;base64," + base64(bytes_of(kPoints, kCorners)));
}

/// Corners of `triangles` apart from each other, all on a paraboloid.
std::string apart(int triangles) {
  std::vector<float> points;
  for (int i = 0; i < triangles; ++i) {
    for (int k = 0; k < 3; ++k) {
      const float x = 0.001f * static_cast<float>(i) + (k == 1 ? 0.0005f : 0.0f);
      const float y = k == 2 ? 0.0005f : 0.0f;
      points.insert(points.end(), {x, y, x * x + y * y});
    }
  }
  return bytes_of(points, {});
}

/// Counts of a document's parts; primitives take buffers and indices in turn.
struct Many {
  int triangles = 1;  ///< in each buffer
  int buffers = 1;
  int meshes = 1;
  int primitives = 1;    ///< of each mesh
  int nodes = 1;         ///< of each mesh
  bool indexed = false;  ///< each primitive has one triangle of all, else it has all
  bool scaled = false;   ///< each node by another number
};

/// Its buffers are one file, mesh.bin, by several names; behind the points all corners in order.
std::string document(const Many& many) {
  const int points = 3 * many.triangles;
  std::ostringstream out;
  const auto list = [&](const char* name, int count, auto&& item) {
    out << ",\"" << name << "\":[";
    for (int i = 0; i < count; ++i) {
      if (i > 0) out << ',';
      item(i);
    }
    out << ']';
  };
  out << R"({"asset":{"version":"2.0"})";
  list("buffers", many.buffers, [&](int i) {
    out << R"({"uri":")" << (i % 2 == 0 ? "" : "./") << (i % 3 == 0 ? ".//" : "")
        << R"(mesh.bin"})";
  });
  list("bufferViews", 2 * many.buffers, [&](int i) {
    out << R"({"buffer":)" << i / 2 << R"(,"byteOffset":)" << (i % 2 == 0 ? 0 : 12 * points)
        << R"(,"byteLength":)" << (i % 2 == 0 ? 12 : 2) * points << '}';
  });
  list("accessors", many.buffers + (many.indexed ? many.triangles : 0), [&](int i) {
    if (i < many.buffers) {
      out << R"({"bufferView":)" << 2 * i << R"(,"componentType":5126,"type":"VEC3","count":)"
          << points << '}';
    } else {
      out << R"({"bufferView":1,"componentType":5123,"type":"SCALAR","count":3,"byteOffset":)"
          << 6 * (i - many.buffers) << '}';
    }
  });
  int next = 0;
  list("meshes", many.meshes, [&](int) {
    out << R"({"name":"")";
    list("primitives", many.primitives, [&](int) {
      out << R"({"attributes":{"POSITION":)" << next % many.buffers << '}';
      if (many.indexed) out << R"(,"indices":)" << many.buffers + next % many.triangles;
      out << '}';
      ++next;
    });
    out << '}';
  });
  list("nodes", many.nodes * many.meshes, [&](int i) {
    out << R"({"scale":[)" << (many.scaled ? 1 + i : 1)
        << R"(,1,1],"extensions":{"KHR_physics_rigid_bodies":{"collider":{"geometry":{"mesh":)"
        << i % many.meshes << "}}}}}";
  });
  out << '}';
  return out.str();
}

TEST_CASE("gltf: boxes and hulls rest and a rod swings as the formulas say", "[gltf]") {
  SceneFile file = parse_gltf(embedded(), {});
  Scene& scene = file.scene;
  REQUIRE(file.bodies.size() == 4);
  REQUIRE(file.warnings.size() == 2);  // of static friction and animations
  CHECK(file.warnings[0].find("/physicsMaterials/0: ") != std::string::npos);
  CHECK(file.warnings[1].find("/animations: ") == 0);
  // y is up there: z here.
  CHECK(scene.pose(file.find("box")).position.isApprox(Vec3(0.0, -2.0, 0.4)));
  CHECK(scene.world().twist(file.find("box")).linear.isApprox(Vec3(0.0, 0.0, -1.0)));
  // An octahedron has 4/3 r^3, of 1000 kg/m^3.
  CHECK(scene.world().props(file.find("stone")).mass ==
        Approx(1000.0 * 4.0 / 3.0 * 0.027).epsilon(1e-6));
  const BodyId rod = file.find("rod");
  CHECK(scene.world().pose(rod).position.isApprox(Vec3(-3.0, 0.0, 1.5)));
  const double period = 2.0 * std::numbers::pi * std::sqrt((0.1 + 2.0 * 0.25) / (2.0 * 9.81 * 0.5));
  constexpr double kStep = 1.0 / 240.0;
  int turns = 0;
  double first = 0.0, last = 0.0, before = 0.0;
  for (int i = 1; i <= 240 * 12; ++i) {
    scene.step(kStep);
    const double side = scene.world().pose(rod).position.y();
    if (before < 0.0 && side >= 0.0) {
      last = (i - 1 + before / (before - side)) * kStep;
      if (turns++ == 0) first = last;
    }
    before = side;
  }
  REQUIRE(turns > 5);
  CHECK((last - first) / (turns - 1) == Approx(period).epsilon(2e-3));
  CHECK(scene.pose(rod).position.isApprox(Vec3(-3.0, 0.0, 2.0), 1e-4));
  // Half of 0.2 m twice as high, and half of the way between two faces: r / sqrt(3).
  CHECK(scene.pose(file.find("box")).position.z() == Approx(0.2).margin(1e-3));
  CHECK(scene.pose(file.find("stone")).position.z() == Approx(0.3 / std::sqrt(3.0)).margin(2e-3));
}

TEST_CASE("gltf: a joint about any axis starts on the turn within its limits, and turns on",
          "[gltf]") {
  for (const int axis : {0, 1, 2}) {
    INFO("axis " << axis);
    const std::string locked = axis == 0 ? "[1,2]" : axis == 1 ? "[0,2]" : "[0,1]";
    // The frame is turned by 181 degrees in the body: past 170 degrees, so not by -179. A motor
    // turns it at 3 rad/s.
    const double half = 0.5 * 181.0 * std::numbers::pi / 180.0;
    double q[3] = {};
    q[axis] = -std::sin(half);
    std::ostringstream text;
    text.precision(17);
    text << R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0,2]}],
      "extensionsUsed":["KHR_physics_rigid_bodies"],
      "extensions":{"KHR_physics_rigid_bodies":{"physicsJoints":[{"limits":[
        {"linearAxes":[0,1,2],"min":0,"max":0},{"angularAxes":)"
         << locked << R"(,"min":0,"max":0},{"angularAxes":[)" << axis
         << R"(],"min":2.9671,"max":40}],"drives":[{"type":"angular","axis":)" << axis
         << R"(,"mode":"force","velocityTarget":3}]}]}},
      "nodes":[{"name":"body","rotation":[)"
         << q[0] << ',' << q[1] << ',' << q[2] << ',' << std::cos(half)
         << R"(],"children":[1],"extensions":{"KHR_physics_rigid_bodies":
          {"motion":{"mass":1,"inertiaDiagonal":[1,1,1]}}}},
        {"extensions":{"KHR_physics_rigid_bodies":{"joint":{"connectedNode":2,"joint":0}}}},
        {"name":"frame"}]})";
    SceneFile file = parse_gltf(text.str(), {});
    REQUIRE(file.joints.size() == 1);
    const auto angle = [&] {
      const auto& joints = file.scene.joints();
      return std::abs(joints.at(file.joints[0].joint).position[3 + static_cast<std::size_t>(axis)]);
    };
    CHECK(angle() == Approx(2.0 * half).margin(1e-5));
    double fastest = 0.0;
    for (int i = 0; i < 60 * 5; ++i) {
      file.scene.step(1.0 / 60.0);
      fastest = std::max(fastest, file.scene.world().twist(file.bodies[0].body).angular.norm());
    }
    CHECK(fastest == Approx(3.0).margin(1e-6));
    CHECK(angle() == Approx(2.0 * half + 15.0).margin(1e-5));
  }
}

TEST_CASE("gltf: buffers are files beside it, and nothing else", "[gltf][errors]") {
  const tandem::testing::Folder folder;
  const std::string bytes = bytes_of(kPoints, kCorners);
  folder.write("mesh.bin", bytes);
  folder.write("scene.gltf", document("mesh.bin"));
  CHECK(load_scene(folder.file("scene.gltf")).bodies.size() == 4);
  folder.write("my mesh 100%.bin", bytes);
  std::filesystem::create_directory(folder.file("a"));
  folder.write("a/k\u00f6rper.bin", bytes);
  for (const char* uri : {"my%20mesh%20100%25.bin", "my mesh 100%25.bin", "a/k%C3%B6rper.bin",
                          "a%2fk%c3%b6rper.bin"}) {
    CAPTURE(uri);
    CHECK(parse_gltf(document(uri), folder.file("")).bodies.size() == 4);
  }
  // Buffers are decoded once, before they are checked.
  std::filesystem::create_directory(folder.file("inner"));
  for (const char* uri : {"../mesh.bin", "%2e%2e/mesh.bin", "..%2Fmesh.bin", "%2e./mesh%2ebin"}) {
    CAPTURE(uri);
    CHECK(names(refusal([&] { parse_gltf(document(uri), folder.file("inner")); }), "/buffers/0/uri",
                "mesh", "folder or below"));
  }
  for (const char* uri :
       {"../mesh.bin", "/etc/hostname", "a/../../mesh.bin", "http://x/mesh.bin", "mesh%2520.bin",
        "mesh.bin%00", "mesh.bin%", "mesh.bin%4", "%+1mesh.bin", "%2Fetc/hostname",
        "http%3A//x/mesh.bin", "data:x;base64,!", "data:x,y", "nothing.bin"}) {
    CAPTURE(uri);
    CHECK_THROWS_AS(parse_gltf(document(uri), folder.file("")), SceneFileError);
  }
  // Less than the views say.
  CHECK(names(refusal([&] { parse_gltf(document("data:x;base64,AAAA"), {}); }), "/bufferViews/",
              "{...}", "within its buffer"));
}

TEST_CASE("gltf: any changed text is read or refused", "[gltf][errors]") {
  const std::string good = embedded();
  pbd::SplitMix64 random(5);
  const std::string with = "0123456789-.eE\"[]{},: xabc\n";
  int refused = 0;
  for (int i = 0; i < 4000; ++i) {
    std::string text = good;
    for (int k = 0; k < 1 + i % 4; ++k) {
      const auto at =
          static_cast<std::size_t>(random.uniform(0.0, static_cast<double>(text.size())));
      const auto which =
          static_cast<std::size_t>(random.uniform(0.0, static_cast<double>(with.size())));
      text[std::min(at, text.size() - 1)] = with[std::min(which, with.size() - 1)];
    }
    try {
      parse_gltf(text, {});
    } catch (const SceneFileError&) {
      ++refused;
    }
  }
  CHECK(refused > 1000);
  CHECK(refused < 4000);
  CHECK(names(refusal([] {
                parse_gltf(R"({"asset": {"version": "2.0"}, "nodes": [{"children": [0, 0]}]})", {});
              }),
              "/nodes/0/children/1", "0", "one parent"));
  CHECK(names(refusal([] { parse_gltf(R"({"asset": {"version": "1.0"}})", {}); }), "/asset/version",
              "1.0", "2.x"));
}

TEST_CASE("gltf: equal meshes are one shape", "[gltf]") {
  const tandem::testing::Folder folder;
  std::string indices(6000, '\0');
  for (std::size_t i = 0; i < 3000; ++i) {
    indices[2 * i] = static_cast<char>(i & 255);
    indices[2 * i + 1] = static_cast<char>(i >> 8);
  }
  folder.write("mesh.bin", apart(1000) + indices);
  const auto meshes = [&](const Many& many) {
    SceneFile file = parse_gltf(document(many), folder.file(""));
    std::vector<collision::Mesh> out;
    for (std::uint32_t i = 0; i < file.scene.shapes().slot_count(); ++i) {
      const collision::ColliderId id = file.scene.shapes().collider_at(i);
      out.push_back(std::get<collision::Mesh>(file.scene.shapes().collider(id).shape));
    }
    return out;
  };
  // Two meshes by turns, three nodes each.
  const auto shared = meshes({.triangles = 1000, .meshes = 2, .nodes = 3});
  REQUIRE(shared.size() == 6);
  CHECK(shared[0] == shared[2]);
  CHECK(shared[0] == shared[4]);
  CHECK(shared[1] == shared[5]);
  CHECK(shared[0] != shared[1]);
  const auto scaled = meshes({.triangles = 1000, .nodes = 2, .scaled = true});
  REQUIRE(scaled.size() == 2);
  CHECK(scaled[0] != scaled[1]);
  CHECK(scaled[1]->bounds().max.x() == Approx(2.0 * scaled[0]->bounds().max.x()));
  // Each mesh takes its own from positions that many meshes share.
  const auto single = meshes({.triangles = 1000, .meshes = 1000, .indexed = true});
  REQUIRE(single.size() == 1000);
  for (const auto& mesh : single) REQUIRE(mesh->vertex_count() == 3);
  CHECK(single[700]->bounds().min.x() == Approx(0.7));
}

TEST_CASE("gltf: the work is in proportion to the file", "[gltf][errors]") {
  const tandem::testing::Folder folder;
  constexpr int kTriangles = 3000;
  folder.write("mesh.bin", apart(kTriangles));
  const auto message = [&](Many many) {
    many.triangles = kTriangles;
    return refusal([&] { parse_gltf(document(many), folder.file("")); });
  };
  CHECK(message({}).empty());
  CHECK(message({.nodes = 1000}).empty());
  CHECK(message({.nodes = 50, .scaled = true}).empty());
  // 108 kB of corners, 400 times.
  const std::string rule = "SceneLimits::points";
  CHECK(names(message({.primitives = 400}), "/meshes/0/primitives/", "{...}", rule));
  CHECK(names(message({.nodes = 400, .scaled = true}), "/geometry/mesh", "is 0", rule));
  CHECK(names(message({.meshes = 400}), "mesh", "is ", rule));
  // A file is one, by however many names.
  CHECK(names(message({.buffers = 400, .meshes = 400}), "mesh", "is ", rule));
}

}  // namespace gltf_test
