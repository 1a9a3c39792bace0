// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <vector>

#include "limit_count.h"
#include "mjcf_filters.h"
#include "mjcf_joints.h"
#include "mjcf_model.h"
#include "mjcf_shapes.h"
#include "rigid_parts.h"
#include "tandem/mjcf.h"

namespace tandem::mjcf {

/// Turns a compiled model into a scene.
class Reader {
 public:
  Reader(const mjModel& model, SceneFile& out, const MjcfOptions& options)
      : model_{model}, m_(model), out_(out), options_(options), limits_(options.limits) {}

  void run();

 private:
  /// By index in the model.
  struct Body {
    Pose frame;              ///< world
    int lead = 0;            ///< the body whose scene body it is part of: itself, or an earlier one
    Pose in_lead;            ///< its frame in the lead's
    std::int32_t group = 0;  ///< group of its tree; 0: of the world
    std::vector<JointRange> joints;  ///< each is one joint in the scene
    std::vector<BodyId> between;     ///< bodies between those, in order
    BodyId id;                       ///< only of leads
    // Only of leads, over all their parts:
    scene_files::RigidParts parts;
    std::size_t geoms = 0;
  };
  Body& at(int body) { return bodies_[static_cast<std::size_t>(body)]; }
  bool is_mocap(int body) const { return m_.body_mocapid[body] >= 0; }

  void place(int body);
  void add_body(int body);
  void add_between(int body, pbd::BodyDef& def);
  void damp(int body, pbd::BodyDef& def);
  void add_geom(int geom, const Filters& filters);
  double friction(int geom);
  void add_joints(int body);
  void tell_free_joint(int joint);
  void start();
  void set_poses(const std::vector<mjtNum>& coordinates);
  Pose frame_behind(int body, int joint, const mjData& data) const;
  /// @param ids  of joints_
  void couple(const std::vector<pbd::JointId>& ids);
  bool couple(int equality, const std::vector<pbd::JointId>& ids);
  void tell_rest();

  Model model_;
  const mjModel& m_;
  SceneFile& out_;
  const MjcfOptions& options_;
  std::vector<Body> bodies_;
  std::vector<BodyJoint> joints_;
  scene_files::LimitCount limits_;
  Shapes shapes_{model_, options_, limits_};
};

}  // namespace tandem::mjcf
