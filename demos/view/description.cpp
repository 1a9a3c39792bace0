// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// JSON messages to a page.
#include <utility>

#include "measures/json.h"
#include "view/protocol.h"

namespace tandem::demos::view {

namespace {

void write(JsonWriter& json, const pbd::Vec3& v) {
  json.begin_array().value(v.x()).value(v.y()).value(v.z()).end_array();
}

struct ShapeWriter {
  JsonWriter& json;

  void vertex(const pbd::Vec3& at) const { write(json, at); }
  void triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
    json.begin_array().value(a).value(b).value(c).end_array();
  }

  void operator()(const collision::Sphere& s) const {
    json.field("shape", "sphere").field("radius", s.radius);
  }
  void operator()(const collision::Capsule& s) const {
    json.field("shape", "capsule").field("radius", s.radius).field("half_height", s.half_height);
  }
  void operator()(const collision::Cylinder& s) const {
    json.field("shape", "cylinder").field("radius", s.radius).field("half_height", s.half_height);
  }
  void operator()(const collision::Cone& s) const {
    json.field("shape", "cone").field("radius", s.radius).field("half_height", s.half_height);
  }
  void operator()(const collision::Box& s) const {
    json.field("shape", "box").key("half_extents");
    write(json, s.half_extents);
  }
  void operator()(const collision::HalfSpace& s) const {
    json.field("shape", "half_space").key("normal");
    write(json, s.normal);
    json.field("offset", s.offset);
  }
  void operator()(const collision::Mesh& s) const {
    json.field("shape", "mesh").key("vertices").begin_array();
    for (const pbd::Vec3& at : s->vertices()) vertex(at);
    json.end_array().key("triangles").begin_array();
    for (const auto& [a, b, c] : s->triangles()) triangle(a, b, c);
    json.end_array();
  }
  void operator()(const collision::Hull& s) const {
    json.field("shape", "mesh").key("vertices").begin_array();
    for (const pbd::Vec3& arm : s->arms()) vertex(s->centre() + arm);
    json.end_array().key("triangles").begin_array();
    for (const collision::ConvexHull::Face& face : s->faces()) {
      const auto corners = s->face_corners(face);
      for (std::size_t i = 2; i < corners.size(); ++i) {
        triangle(corners[0], corners[i - 1], corners[i]);
      }
    }
    json.end_array();
  }
  void operator()(const collision::Field& s) const {
    json.field("shape", "mesh").key("vertices").begin_array();
    for (std::uint32_t v = 0; v < s->vertex_count(); ++v) vertex(s->vertex(v));
    json.end_array().key("triangles").begin_array();
    for (std::uint32_t t = 0; t < s->triangle_count(); ++t) {
      const auto [a, b, c] = s->corners(t);
      triangle(a, b, c);
    }
    json.end_array();
  }
};

void write_part(JsonWriter& json, const collision::Shape& shape, const pbd::Pose& pose) {
  json.begin_object();
  std::visit(ShapeWriter{json}, shape);
  const pbd::Vec3& p = pose.position;
  const pbd::Quat& q = pose.orientation;
  json.key("pose").begin_array();
  for (const double value : {p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w()}) json.value(value);
  json.end_array().end_object();
}

void write(JsonWriter& json, const Settings& settings) {
  json.begin_object().field("paused", settings.paused).field("speed", settings.speed);
  if (settings.profile) {
    json.field("profile", *settings.profile);
  } else {
    json.null_field("profile");
  }
  json.field("influence", settings.influence);
  json.field("predictor", to_string(settings.predictor));
  json.field("scheme", to_string(settings.scheme));
  if (settings.beside) {
    json.field("beside", to_string(*settings.beside));
  } else {
    json.null_field("beside");
  }
  json.end_object();
}

void write_speeds(JsonWriter& json) {
  json.key("speed").begin_array().value(kMinSpeed).value(kMaxSpeed).end_array();
}

/// All that a page can switch in a session.
void write_choices(JsonWriter& json) {
  json.begin_object().key("profile").begin_array();
  for (int profile = 0; profile <= kMaxProfile; ++profile) json.value(profile);
  json.end_array().key("predictor").begin_array();
  for (int kind = 0; kind <= static_cast<int>(consensus::PredictorKind::Replay); ++kind) {
    json.value(to_string(static_cast<consensus::PredictorKind>(kind)));
  }
  json.end_array().key("scheme").begin_array();
  for (int scheme = 0; scheme <= static_cast<int>(Scheme::SingleOwner); ++scheme) {
    json.value(to_string(static_cast<Scheme>(scheme)));
  }
  json.end_array();
  write_speeds(json);
  json.key("influence").begin_array().value(0.0).value(kMaxInfluence).end_array().end_object();
}

/// True for a single ball about the body's centre: its rotation is invisible.
bool is_ball(const SceneBody& body) {
  return body.parts.size() == 1 &&
         std::holds_alternative<collision::Sphere>(body.parts.front().shape) &&
         body.parts.front().local.position.isZero(0.0);
}

}  // namespace

Settings settings_of(const DemoOptions& options) {
  Settings settings;
  if (!options.over_network()) settings.profile = options.profile;
  settings.influence = options.influence;
  settings.predictor = options.predictor_kind();
  settings.scheme = options.scheme;
  return settings;
}

Layout make_layout(std::string name, const Scene& scene, double max_distance,
                   std::vector<PaneInfo> panes, bool live) {
  Layout layout;
  layout.scene = std::move(name);
  layout.live = live;
  layout.panes = std::move(panes);
  layout.position_unit = max_distance / 0x100000;
  for (const SceneBody& body : scene.bodies) {
    layout.bodies.push_back({body.name, !is_ball(body), body.owner});
  }
  return layout;
}

std::string hello_text(const Layout& layout, const Scene& scene, const Settings& settings) {
  JsonWriter json;
  json.begin_object().field("type", "hello").field("protocol", kProtocol);
  json.field("scene", layout.scene).field("live", layout.live);
  if (layout.alone) json.field("alone", true);
  json.key("peers").begin_array();
  for (const PaneInfo& pane : layout.panes) {
    json.begin_object().field("id", pane.id).field("hz", pane.hz);
    json.field("engine", pane.engine).field("beside", pane.beside).end_object();
  }
  json.end_array().field("position_unit", layout.position_unit).key("bodies").begin_array();
  for (std::size_t i = 0; i < layout.bodies.size(); ++i) {
    const Layout::Body& body = layout.bodies[i];
    json.begin_object().field("name", body.name).field("turns", body.turns);
    if (body.owner) {
      json.field("owner", *body.owner);
    } else {
      json.null_field("owner");
    }
    json.key("parts").begin_array();
    for (const ScenePart& part : scene.bodies[i].parts) write_part(json, part.shape, part.local);
    json.end_array().end_object();
  }
  json.end_array().key("fixed").begin_array();
  for (const FixedPart& part : scene.fixed) write_part(json, part.shape, part.pose);
  json.end_array().key("settings");
  write(json, settings);
  json.key("choices");
  if (layout.alone) {
    json.begin_object();
    write_speeds(json);
    json.end_object();
  } else if (layout.live) {
    write_choices(json);
  } else {
    json.begin_object().end_object();
  }
  json.end_object();
  return json.text();
}

std::string settings_text(const Settings& settings) {
  JsonWriter json;
  json.begin_object().field("type", "settings").key("settings");
  write(json, settings);
  json.end_object();
  return json.text();
}

std::string refused_text(std::string_view reason) {
  JsonWriter json;
  json.begin_object().field("type", "refused").field("text", reason).end_object();
  return json.text();
}

std::string pong_text(double time) {
  JsonWriter json;
  json.begin_object().field("type", "pong").field("time", time).end_object();
  return json.text();
}

std::string score_text(const std::vector<Outcome>& outcomes, double time, bool final) {
  JsonWriter json;
  json.begin_object().field("type", "score").field("time", time).field("final", final);
  json.key("outcomes").begin_array();
  for (const Outcome& outcome : outcomes) {
    json.begin_object();
    for (const auto& [name, value] : outcome) json.field(name, value);
    json.end_object();
  }
  json.end_array().end_object();
  return json.text();
}

}  // namespace tandem::demos::view
