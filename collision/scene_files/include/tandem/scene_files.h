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

/// What all readers and writers of scenes throw, and nothing else but std::bad_alloc: file, place
/// in it (a JSON pointer, or the name of an element), rule and value.
class TANDEM_API SceneFileError : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

/// A scene that came from a file.
struct TANDEM_API SceneFile {
  struct TANDEM_API Body {
    std::string name = {};  ///< may be empty
    BodyId body = {};
    /// In the body's, that which Scene::pose() tells of. Robots' links that are fixed to another
    /// one are parts of its body; their frames stay known here.
    Pose frame = {};
  };
  struct TANDEM_API Joint {
    std::string name = {};  ///< may be empty
    pbd::JointId joint = {};
  };
  /// Pulls at a coordinate of a joint with gain * control + bias - stiffness * coordinate, N or
  /// N m. MJCF has such ones; the first one of a coordinate has the joint's own spring in it. A
  /// servo whose force has a bound is by itself: it pulls with that less damping * speed, or with
  /// max_force where that is more.
  struct TANDEM_API Actuator {
    std::string name = {};  ///< may be empty
    pbd::JointId joint = {};
    int coordinate = 0;      ///< as those of pbd::JointState::position
    double control = 0.0;    ///< in the file's unit
    double lower = 0.0;      ///< of the control
    double upper = 0.0;      ///< likewise
    double gain = 0.0;       ///< N or N m for each unit of control
    double bias = 0.0;       ///< N or N m
    double stiffness = 0.0;  ///< N/m or N m/rad, >= 0
    double damping = 0.0;    ///< N s/m or N m s/rad, >= 0; that of others is in the joint's spring
    double max_force = pbd::kUnlimited;  ///< N or N m, > 0
  };

  Scene scene{};
  std::vector<Body> bodies = {};         ///< in the file's order
  std::vector<Joint> joints = {};        ///< likewise
  std::vector<Actuator> actuators = {};  ///< likewise
  /// What the file has and the scene has not, with its place.
  std::vector<std::string> warnings = {};

  /// Of the first one with that name; the invalid id where there is none.
  BodyId find(std::string_view name) const;
  pbd::JointId find_joint(std::string_view name) const;
  /// World, of the first frame with that name, where its body is now.
  /// @throws std::invalid_argument  where there is none, or its body has been removed
  Pose pose(std::string_view name) const;
  /// Of the first actuator with that name, or the one at that place: from now on, or as much of it
  /// as lower and upper let through. All that pull at its coordinate are its spring, and a
  /// motor: a servo whose force has a bound, or one of constant force below 1000 m/s or rad/s.
  /// @throws std::invalid_argument  where there is none, its joint has been removed, or the control
  ///   or the force is not finite
  void set_control(std::string_view actuator, double control);
  void set_control(std::size_t actuator, double control);
};

/// Files are read up to this size, and JSON up to this depth.
inline constexpr std::size_t kMaxSceneBytes = std::size_t{1} << 26;
inline constexpr int kMaxSceneDepth = 24;

/// The most that is made of one document, whatever its format; who breaks one is refused by its
/// name. By the defaults 10 MB of a stranger take some seconds, and the first step is no longer
/// than one in a heap of ten thousand boxes. What becomes of a scene afterwards they do not bound.
struct TANDEM_API SceneLimits {
  std::size_t nodes = std::size_t{1} << 18;  ///< of glTF
  std::size_t bodies = std::size_t{1} << 16;
  std::size_t colliders = std::size_t{1} << 16;
  std::size_t parts = 4096;  ///< colliders of one body that moves
  std::size_t joints = std::size_t{1} << 16;
  std::size_t points = std::size_t{1} << 19;       ///< of meshes and height fields
  std::size_t hull_points = std::size_t{1} << 18;  ///< that hulls are made of
  std::size_t triangles = std::size_t{1} << 19;
  std::size_t pairs = std::size_t{1} << 17;  ///< that are close as it begins, collision::is_crowded
};

/// Tandem's own format (docs/scene_files.md, docs/scene.schema.json), which those of rooms are in.
/// @param options  gravity is the file's where that says one
/// @param name  stands for the file in messages
TANDEM_API SceneFile parse_scene(std::string_view text, const SceneOptions& options = {},
                                 std::string_view name = "scene", const SceneLimits& limits = {});
/// The same from a file; one that ends in .gltf or .glb is read as load_gltf() does.
TANDEM_API SceneFile load_scene(const std::filesystem::path& path, const SceneOptions& options = {},
                                const SceneLimits& limits = {});

/// One more body, as the format has it in "bodies". Its group is a number of this scene: that of a
/// text from elsewhere may be one that Scene::new_group() gave here. @return with its name
TANDEM_API SceneFile::Body add_body(Scene& scene, std::string_view text,
                                    std::string_view name = "body");

/// What a scene is made of: bodies as they stand and go, colliders, joints, gravity. Read again by
/// the same options it moves by the same bits as a scene that was made so. Not in it: options,
/// what the solver carries from step to step (World::snapshot() has that), targets, kinds of rows
/// other than joints; where there are rows of those, it is an error.
/// @param bodies, joints  names; those of what is no longer there are passed over, and of several
///   of one body the first counts
TANDEM_API std::string write_scene(const Scene& scene, std::span<const SceneFile::Body> bodies = {},
                                   std::span<const SceneFile::Joint> joints = {});
/// With the file's names.
TANDEM_API std::string write_scene(const SceneFile& file);

/// glTF 2.0 with KHR_physics_rigid_bodies and KHR_implicit_shapes, drafts of 2025, or with
/// OMI_physics_body and OMI_physics_shape, as text or in its binary container (.glb). Its y is up:
/// the scene is turned so that z is. Buffers are embedded or files in `folder` or below.
/// @param strict  hulls of more than 128 corners or flat ones, and triangles without area, are
///   errors; else they are mended, and told
TANDEM_API SceneFile load_gltf(const std::filesystem::path& path, const SceneOptions& options = {},
                               const SceneLimits& limits = {}, bool strict = false);
TANDEM_API SceneFile parse_gltf(std::string_view text, const std::filesystem::path& folder,
                                const SceneOptions& options = {}, std::string_view name = "gltf",
                                const SceneLimits& limits = {}, bool strict = false);

}  // namespace tandem
