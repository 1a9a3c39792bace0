// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <unordered_map>

#include "read_bytes.h"
#include "reader.h"

namespace tandem {

using scene_files::json;
using scene_files::Place;
using scene_files::Reader;
using scene_files::Reading;

namespace scene_files {
namespace {

/// For people and displays: ignored without a warning.
constexpr const char* kOfDisplays[] = {"$schema", "title", "say", "camera", "make", "colour"};

/// Layers by name, as in collision::Layers.
struct LayerTable {
  std::unordered_map<std::string, collision::Filter> filters;

  collision::Filter& find(const Place& at) {
    const auto found = filters.find(at.text());
    if (found == filters.end()) at.refuse("the name of one of /layers/names");
    return found->second;
  }
  void read(const Place& at) {
    Reader io(at);
    io.has("names");
    const Place names = at.at("names");
    if (names.size() > collision::Layers::kMax) names.refuse("an array of at most 32 names");
    for (std::size_t i = 0; i < names.size(); ++i) {
      const Place name = names.at(i);
      const bool fresh = filters.emplace(name.text(), collision::Filter{1u << i, ~0u, 0}).second;
      if (!fresh || name.text().empty()) name.refuse("of one layer, and not empty");
    }
    if (io.has("ignore")) {
      const Place pairs = at.at("ignore");
      for (std::size_t i = 0; i < pairs.size(); ++i) {
        const Place pair = pairs.at(i);
        collision::Filter& a = find(pair.at(std::size_t{0}));
        collision::Filter& b = find(pair.at(std::size_t{1}));
        a.mask &= ~b.category;
        b.mask &= ~a.category;
      }
    }
    io.finish();
  }
};

/// Fills a scene.
class SceneReader {
 public:
  SceneReader(Scene& scene, LayerTable& layers) : scene_(scene), layers_(layers) {}

  SceneFile::Body body(const Place& at) {
    Reader io(at);
    SceneFile::Body out;
    at.count(&SceneLimits::bodies);
    io("name", out.name);
    for (const char* key : kOfDisplays) io.has(key);
    at.guard([&] { out.body = io.has("colliders") ? exact(io) : solid(io); });
    io.finish();
    return out;
  }

  /// @param find  finds a body by its reference
  template <class Find>
  SceneFile::Joint joint(const Place& at, Find&& find) {
    Reader io(at);
    SceneFile::Joint out;
    at.count(&SceneLimits::joints);
    io("name", out.name);
    io.has("type");
    const std::string type = at.at("type").text();
    const BodyId a = io.has("a") ? find(at.at("a")) : BodyId{};
    io.has("b");
    const BodyId b = find(at.at("b"));
    at.guard([&] {
      const pbd::World& world = scene_.world();
      Vec3 point = Vec3::Zero(), axis = Vec3::UnitX(), up = Vec3::UnitZ();
      place(io, point, axis, up);
      pbd::SixDofJointDef def;
      if (type == "fixed") {
        def = fill(io, pbd::fixed_joint_at(world, a, b, point));
      } else if (type == "ball") {
        def = fill(io, pbd::ball_joint_at(world, a, b, point, axis));
      } else if (type == "hinge") {
        def = fill(io, pbd::hinge_joint_at(world, a, b, point, axis));
      } else if (type == "slider") {
        def = fill(io, pbd::slider_joint_at(world, a, b, point, axis));
      } else if (type == "wheel") {
        if (!at.has("at")) axis = Vec3::UnitY();
        def = fill(io, pbd::wheel_joint_at(world, a, b, point, axis, up));
      } else if (type == "sixDof") {
        def = fill(io, pbd::six_dof_joint_at(world, a, b, point, axis));
      } else {
        at.at("type").refuse("one of fixed, ball, hinge, slider, wheel, sixDof");
      }
      if (type != "sixDof") io("enabled", def.enabled);
      out.joint = scene_.add_joint(def);
    });
    io.finish();
    return out;
  }

 private:
  /// Reads the place of a joint in the world, "at"; without it the joint is given by its frames.
  static void place(Reader& io, Vec3& point, Vec3& axis, Vec3& up) {
    if (!io.has("at")) return;
    const Place place = io.at().at("at");
    Reader at(place);
    at("position", point);
    at("axis", axis);
    at("up", up);
    at.finish();
  }
  template <class Def>
  static Def fill(Reader& io, Def def) {
    if (!io.at().has("at")) {
      def.frame_a = {};
      def.frame_b = {};
    }
    fields(io, def);
    return def;
  }

  void filter(Reader& io, collision::Filter& out) {
    if (io.has("layer")) out = layers_.find(io.at().at("layer"));
  }

  /// A body with colliders relative to its centre of mass, which its pose refers to.
  BodyId exact(Reader& io) {
    pbd::BodyDef def;
    fields(io, def);
    for (const char* key : {"mass", "inertia"}) {
      if (def.type == BodyType::Dynamic) io.at().at(key);  // refuses a missing key
    }
    const BodyId id = scene_.world().add_body(def);
    whole(id, [&] { colliders(io.at().at("colliders"), id); });
    return id;
  }

  void colliders(const Place& list, BodyId id) {
    list.count(&SceneLimits::colliders, list.size());
    if (scene_.world().props(id).type != BodyType::Static) list.count_parts();
    for (std::size_t i = 0; i < list.size(); ++i) {
      const Place at = list.at(i);
      Reader part(at);
      collision::ColliderDef collider;
      collider.body = id;
      filter(part, collider.filter);
      fields(part, collider);
      part.finish();
      at.guard([&] { scene_.shapes().add(scene_.world(), collider); });
    }
  }

  /// Fills a body, or removes it on failure.
  void whole(BodyId id, const std::function<void()>& fill) {
    try {
      fill();
    } catch (...) {
      scene_.remove(id);
      throw;
    }
  }

  /// A body whose mass follows from its shape or shapes; further colliders have none.
  BodyId solid(Reader& io) {
    SolidDef def;
    filter(io, def.filter);
    fields(io, def);
    std::vector<collision::CompoundPart> compound;
    BodyId id;
    if (io.has("compound")) {
      const Place list = io.at().at("compound");
      list.count(&SceneLimits::colliders, list.size());
      list.count_parts();
      compound.resize(list.size());
      for (std::size_t i = 0; i < compound.size(); ++i) scene_files::read(list.at(i), compound[i]);
      id = scene_.add(compound, def);
    } else {
      collision::Shape shape;
      io.at().count(&SceneLimits::colliders);
      io.has("shape");
      scene_files::read(io.at().at("shape"), shape);
      id = scene_.add(shape, def);
    }
    if (io.has("parts")) whole(id, [&] { parts(io.at().at("parts"), id, def); });
    return id;
  }

  void parts(const Place& list, BodyId id, const SolidDef& def) {
    list.count(&SceneLimits::colliders, list.size());
    if (scene_.world().props(id).type != BodyType::Static) list.count_parts();
    const Vec3 origin = scene_.world().props(id).origin;
    for (std::size_t i = 0; i < list.size(); ++i) {
      const Place at = list.at(i);
      collision::ColliderDef part{.body = id,
                                  .material = def.material,
                                  .filter = def.filter,
                                  .sensor = def.sensor,
                                  .user_data = def.user_data};
      Reader io(at);
      for (const char* key : kOfDisplays) io.has(key);
      at.at("shape");  // refuses a missing key
      filter(io, part.filter);
      fields(io, part);
      io.finish();
      if (!origin.isZero(0.0)) part.local.position += origin;
      at.guard([&] { scene_.shapes().add(scene_.world(), part); });
    }
  }

  Scene& scene_;
  LayerTable& layers_;
};

/// Bodies by name, or by index in the list.
struct BodyNames {
  const std::vector<SceneFile::Body>& bodies;
  std::unordered_map<std::string_view, std::size_t> by_name;

  BodyId operator()(const Place& at) const {
    if (at.value().is_string()) {
      const auto found = by_name.find(at.value().get_ref<const std::string&>());
      if (found == by_name.end()) at.refuse("the name of one of /bodies");
      return bodies[found->second].body;
    }
    if (bodies.empty()) at.refuse("the number of one of /bodies");
    const auto last = static_cast<std::int64_t>(bodies.size()) - 1;
    return bodies[static_cast<std::size_t>(at.integer(0, last))].body;
  }
};

void read_document(const Place& at, SceneFile& out) {
  Reader io(at);
  for (const char* key : kOfDisplays) io.has(key);
  io.has("gravity");
  if (io.has("version") && at.at("version").value() != 1) at.at("version").refuse("1");
  LayerTable layers;
  if (io.has("layers")) layers.read(at.at("layers"));
  SceneReader reader(out.scene, layers);
  io.has("bodies");
  const Place bodies = at.at("bodies");
  for (std::size_t i = 0; i < bodies.size(); ++i) out.bodies.push_back(reader.body(bodies.at(i)));
  BodyNames names{out.bodies, {}};
  for (std::size_t i = 0; i < out.bodies.size(); ++i) {
    const std::string& name = out.bodies[i].name;
    if (name.empty() || names.by_name.emplace(name, i).second) continue;
    const Place body = bodies.at(i);
    body.at("name").refuse("of one body");
  }
  if (io.has("joints")) {
    const Place joints = at.at("joints");
    for (std::size_t i = 0; i < joints.size(); ++i) {
      out.joints.push_back(reader.joint(joints.at(i), names));
    }
  }
  if (io.has("apart")) {
    const Place pairs = at.at("apart");
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const Place pair = pairs.at(i);
      const BodyId a = names(pair.at(std::size_t{0}));
      const BodyId b = names(pair.at(std::size_t{1}));
      pair.guard([&] { out.scene.set_apart(a, b); });
    }
  }
  io.finish();
}

}  // namespace
}  // namespace scene_files

BodyId SceneFile::find(std::string_view name) const {
  const auto found = std::find_if(bodies.begin(), bodies.end(),
                                  [name](const Body& body) { return body.name == name; });
  return found == bodies.end() ? BodyId{} : found->body;
}

pbd::JointId SceneFile::find_joint(std::string_view name) const {
  const auto found = std::find_if(joints.begin(), joints.end(),
                                  [name](const Joint& joint) { return joint.name == name; });
  return found == joints.end() ? pbd::JointId{} : found->joint;
}

Pose SceneFile::pose(std::string_view name) const {
  const auto found = std::find_if(bodies.begin(), bodies.end(),
                                  [name](const Body& body) { return body.name == name; });
  if (found == bodies.end()) {
    pbd::detail::refuse("SceneFile::pose: name", "that of a body of the file",
                        '"' + std::string(name) + '"');
  }
  const Pose body = scene.pose(found->body);
  return {body.to_world(found->frame.position),
          (body.orientation * found->frame.orientation).normalized()};
}

SceneFile parse_scene(std::string_view text, const SceneOptions& options, std::string_view name,
                      const SceneLimits& limits) {
  const json document = scene_files::parse_document(text, name);
  Reading reading{.file = name, .limits = scene_files::LimitCount(limits)};
  const Place at(document, reading);
  SceneOptions with = options;
  if (at.has("gravity")) scene_files::read(at.at("gravity"), with.gravity);
  std::optional<SceneFile> out;
  at.guard([&] { out.emplace(SceneFile{.scene = Scene(with)}); });
  scene_files::read_document(at, *out);
  scene_files::require_within(std::string(name), reading.limits.pairs(out->scene));
  out->warnings = std::move(reading.warnings);
  return std::move(*out);
}

SceneFile load_scene(const std::filesystem::path& path, const SceneOptions& options,
                     const SceneLimits& limits) {
  if (path.extension() == ".gltf" || path.extension() == ".glb")
    return load_gltf(path, options, limits);
  return parse_scene(scene_files::read_bytes(path), options, path.string(), limits);
}

SceneFile::Body add_body(Scene& scene, std::string_view text, std::string_view name) {
  const json document = scene_files::parse_document(text, name);
  Reading reading{.file = name};
  scene_files::LayerTable layers;
  return scene_files::SceneReader(scene, layers).body(Place(document, reading));
}

}  // namespace tandem
