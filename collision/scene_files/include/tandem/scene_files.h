// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <filesystem>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "tandem/pbd/export.h"
#include "tandem/scene.h"

namespace tandem {

/// The only exception of all scene readers and writers besides std::bad_alloc: names file, place in
/// it (a JSON pointer, or the name of an element), rule and value.
class TANDEM_API SceneFileError : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

/// A scene loaded from a file.
struct TANDEM_API SceneFile {
  struct TANDEM_API Body {
    std::string name = {};  ///< may be empty
    BodyId body = {};
    /// In the body's frame, which Scene::pose() gives. Robot links that are fixed to another one
    /// are parts of its body and keep their frames here.
    Pose frame = {};
  };
  struct TANDEM_API Joint {
    std::string name = {};  ///< may be empty
    pbd::JointId joint = {};
  };
  /// Pulls at a coordinate of a joint with gain * control + bias - stiffness * coordinate, N or N
  /// m. MJCF has such actuators; the first one of a coordinate includes the joint's own spring. A
  /// servo with a bounded force is separate: it subtracts damping * speed, and its force is cut at
  /// max_force.
  struct TANDEM_API Actuator {
    std::string name = {};  ///< may be empty
    pbd::JointId joint = {};
    int coordinate = 0;                  ///< index as in pbd::JointState::position
    double control = 0.0;                ///< in the file's unit
    double lower = 0.0;                  ///< range of the control
    double upper = 0.0;                  ///< range of the control
    double gain = 0.0;                   ///< N or N m per unit of control
    double bias = 0.0;                   ///< N or N m
    double stiffness = 0.0;              ///< N/m or N m/rad, >= 0
    double damping = 0.0;                ///< N s/m or N m s/rad, >= 0; of servos only
    double max_force = pbd::kUnlimited;  ///< N or N m, > 0
  };

  Scene scene{};
  std::vector<Body> bodies = {};         ///< in the file's order
  std::vector<Joint> joints = {};        ///< in the file's order
  std::vector<Actuator> actuators = {};  ///< in the file's order
  /// Elements of the file that the scene does not have, with their places.
  std::vector<std::string> warnings = {};

  /// The first body with that name; the invalid id if there is none.
  BodyId find(std::string_view name) const;
  pbd::JointId find_joint(std::string_view name) const;
  /// World pose of the first frame with that name, at the current pose of its body.
  /// @throws std::invalid_argument  if there is none, or its body was removed
  Pose pose(std::string_view name) const;
  /// Sets the control of an actuator (the first one of that name, or by index), clamped to lower
  /// and upper. All actuators of a coordinate act through its spring, and a motor: a servo with
  /// bounded force, or one of constant force below 1000 m/s or rad/s.
  /// @throws std::invalid_argument  if there is none, its joint was removed, or the control or
  ///   force is not finite
  void set_control(std::string_view actuator, double control);
  void set_control(std::size_t actuator, double control);
};

/// Limits of files in bytes, and of JSON in depth.
inline constexpr std::size_t kMaxSceneBytes = std::size_t{1} << 26;
inline constexpr int kMaxSceneDepth = 24;

/// Limits for one document of any format; errors name the limit that was exceeded. With the
/// defaults 10 MB from an untrusted source take some seconds, and the first step takes no longer
/// than one in a heap of ten thousand boxes. Later growth of a scene is not limited.
struct TANDEM_API SceneLimits {
  std::size_t nodes = std::size_t{1} << 18;  ///< of glTF
  std::size_t bodies = std::size_t{1} << 16;
  std::size_t colliders = std::size_t{1} << 16;
  std::size_t parts = 4096;  ///< colliders of one moving body
  std::size_t joints = std::size_t{1} << 16;
  std::size_t points = std::size_t{1} << 19;       ///< of meshes and height fields
  std::size_t hull_points = std::size_t{1} << 18;  ///< points that hulls are made of
  std::size_t triangles = std::size_t{1} << 19;
  std::size_t pairs = std::size_t{1} << 17;  ///< close at the start, see collision::is_crowded
};

/// Tandem's own format (docs/scene_files.md, docs/scene.schema.json), also used by rooms.
/// @param options  gravity is overridden by the file's, if given
/// @param name  stands for the file in messages
TANDEM_API SceneFile parse_scene(std::string_view text, const SceneOptions& options = {},
                                 std::string_view name = "scene", const SceneLimits& limits = {});
/// Like parse_scene(), from a file; .gltf and .glb files are read by load_gltf().
TANDEM_API SceneFile load_scene(const std::filesystem::path& path, const SceneOptions& options = {},
                                const SceneLimits& limits = {});

/// Adds a body in the format of "bodies". Its group is a number of this scene: one in a text from
/// elsewhere may equal one that Scene::new_group() returned here. @return the body with its name
TANDEM_API SceneFile::Body add_body(Scene& scene, std::string_view text,
                                    std::string_view name = "body");

/// Writes the content of a scene: bodies with poses and velocities, colliders, joints, gravity.
/// Read again with the same options it moves bit for bit like a scene built that way. Not included:
/// options, state that the solver carries from step to step (see World::snapshot()), targets, and
/// rows other than joints, which are an error.
/// @param bodies, joints  names; removed bodies and joints are skipped, and of several names of one
///   body the first counts
TANDEM_API std::string write_scene(const Scene& scene, std::span<const SceneFile::Body> bodies = {},
                                   std::span<const SceneFile::Joint> joints = {});
/// With the file's names.
TANDEM_API std::string write_scene(const SceneFile& file);

/// glTF 2.0 with KHR_physics_rigid_bodies and KHR_implicit_shapes, drafts of 2025, or with
/// OMI_physics_body and OMI_physics_shape, as text or in its binary container (.glb). glTF has y
/// up: the scene is rotated to z up. Buffers are embedded, or files in `folder` or below.
/// @param strict  hulls that are flat or have more than 128 corners, and triangles without area,
///   are errors; otherwise they are repaired, with a warning
TANDEM_API SceneFile load_gltf(const std::filesystem::path& path, const SceneOptions& options = {},
                               const SceneLimits& limits = {}, bool strict = false);
TANDEM_API SceneFile parse_gltf(std::string_view text, const std::filesystem::path& folder,
                                const SceneOptions& options = {}, std::string_view name = "gltf",
                                const SceneLimits& limits = {}, bool strict = false);

}  // namespace tandem
