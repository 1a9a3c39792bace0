// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "scenes/piano.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "scenes/piano_user.h"
#include "scenes/words.h"

namespace tandem::demos {

namespace {

using pbd::Vec3;

constexpr double kWall = 0.06;   // m, half its height
constexpr double kThick = 0.01;  // half that of the outer walls
constexpr double kTurned = 0.5 * std::numbers::pi;

collision::Material smooth(double friction) {
  collision::Material material;
  material.friction = friction;
  material.friction_rule = collision::Combine::Maximum;
  return material;
}

ScenePart box(const Vec3& half, const Vec3& centre) {
  ScenePart part;
  part.shape = collision::Box{half};
  part.local.position = centre;
  return part;
}

/// A case with keys on three legs, 18 by 8 by 8 cm, long along x, standing on z = 0.
BodySpec piano() {
  BodySpec spec;
  spec.name = "piano";
  spec.parts.resize(5);
  spec.parts[0] = box(Vec3(0.09, 0.0325, 0.025), Vec3(0.0, 0.0075, 0.055));
  spec.parts[1] = box(Vec3(0.08, 0.0075, 0.008), Vec3(0.0, -0.0325, 0.045));
  spec.parts[2] = box(Vec3(0.006, 0.006, 0.015), Vec3(-0.08, -0.015, 0.015));
  spec.parts[3] = box(Vec3(0.006, 0.006, 0.015), Vec3(0.08, -0.015, 0.015));
  spec.parts[4] = box(Vec3(0.006, 0.006, 0.015), Vec3(0.0, 0.03, 0.015));
  spec.mass = kPianoMass;
  const PianoPose start = PianoPath().at(0.0);
  spec.pose.position = Vec3(start.x, start.y, 0.0);
  spec.pose.orientation = pbd::Quat(Eigen::AngleAxisd(start.angle, Vec3::UnitZ()));
  spec.material = smooth(0.0);
  // Friction of the castors.
  spec.linear_damping = 1.5;
  spec.angular_damping = 3.0;
  return spec;
}

class PianoReferee final : public Referee {
 public:
  explicit PianoReferee(const Scene& scene) : piano_(scene.index_of("piano")) {}
  void watch(const Scene& scene, double time) override {
    const PianoPose goal = PianoPath().goal();
    const Vec3& p = scene.pose(piano_).position;
    distance_ = (p - Vec3(goal.x, goal.y, p.z())).norm();
    way_left_ = PianoPath().left_from(p);
    const Vec3 up = scene.pose(piano_).orientation * Vec3::UnitZ();
    steepest_ = std::max(steepest_, std::acos(std::clamp(up.z(), -1.0, 1.0)));
    if (distance_ < 0.04 && delivered_at_ < 0.0) delivered_at_ = time;
  }
  Outcome outcome(const Scene& /*scene*/) const override {
    return {{"delivered", delivered_at_ >= 0.0 && distance_ < 0.04 ? 1.0 : 0.0},
            {"delivered_at_s", delivered_at_},
            {"from_goal_m", distance_},
            {"way_left_m", way_left_},
            {"steepest_deg", steepest_ * 180.0 / std::numbers::pi}};
  }

 private:
  std::size_t piano_;
  double distance_ = 0.0;       ///< m, straight to the goal
  double way_left_ = 0.0;       ///< m, around the walls
  double delivered_at_ = -1.0;  ///< s
  double steepest_ = 0.0;       ///< rad
};

}  // namespace

bool PianoOptions::parse(const std::string& variant, PianoOptions& options) {
  options = {};
  for (std::size_t begin = 0; begin < variant.size();) {
    const std::size_t end = std::min(variant.find('-', begin), variant.size());
    const std::string word = variant.substr(begin, end - begin);
    if (word == "soft") {
      options.soft = true;
    } else if (word == "mouse") {
      options.mouse = true;
    } else if (word == "tug") {
      options.tug = true;
    } else {
      return false;
    }
    begin = end + 1;
  }
  return true;
}

Vec3 piano_handle(std::size_t user) { return {user == 0 ? -0.08 : 0.08, 0.0, 0.02}; }

PianoPath::PianoPath()
    : poses_{{-0.28, -0.13, kTurned}, {-0.28, 0.14, kTurned}, {-0.28, 0.14, 0.0},
             {0.005, 0.14, 0.0},      {0.005, 0.14, kTurned}, {0.005, -0.14, kTurned},
             {0.005, -0.14, 0.0},     {0.29, -0.14, 0.0},     {0.29, -0.14, kTurned},
             {0.29, 0.13, kTurned}} {
  constexpr double kMove = 1.7;  // s
  constexpr double kTurn = 1.5;
  times_.push_back(0.0);
  for (std::size_t i = 1; i < poses_.size(); ++i) {
    const bool turns = poses_[i].angle != poses_[i - 1].angle;
    times_.push_back(times_.back() + (turns ? kTurn : kMove));
  }
}

PianoPose PianoPath::at(double time) const {
  const auto next = std::upper_bound(times_.begin(), times_.end(), time);
  if (next == times_.begin()) return poses_.front();
  if (next == times_.end()) return poses_.back();
  const auto i = static_cast<std::size_t>(next - times_.begin());
  const double s = min_jerk((time - times_[i - 1]) / (times_[i] - times_[i - 1]));
  const PianoPose& a = poses_[i - 1];
  const PianoPose& b = poses_[i];
  return {a.x + s * (b.x - a.x), a.y + s * (b.y - a.y), a.angle + s * (b.angle - a.angle)};
}

Vec3 PianoPath::handle(std::size_t user, double time, double z) const {
  const PianoPose pose = at(time);
  const double arm = piano_handle(user).x();
  return {pose.x + arm * std::cos(pose.angle), pose.y + arm * std::sin(pose.angle), z};
}

double PianoPath::left_from(const Vec3& position) const {
  double left = 0.0;
  double nearest = std::numeric_limits<double>::infinity();
  double result = 0.0;
  for (std::size_t i = poses_.size() - 1; i > 0; --i) {
    const Vec3 from(poses_[i - 1].x, poses_[i - 1].y, position.z());
    const Vec3 way = Vec3(poses_[i].x, poses_[i].y, position.z()) - from;
    const double square = way.squaredNorm();
    if (square == 0.0) continue;  // a turn in place
    const double s = std::clamp((position - from).dot(way) / square, 0.0, 1.0);
    const double distance = (position - from - s * way).norm();
    if (distance < nearest) {
      nearest = distance;
      result = left + (1.0 - s) * way.norm();
    }
    left += way.norm();
  }
  return result;
}

Scene PianoScenario::build(const SceneOptions& options) const {
  SceneBuilder builder;
  builder.add(piano());
  builder.ground(smooth(0.02));
  const auto wall = [&builder](double x, double y, double half_x, double half_y) {
    builder.fix(collision::Box{Vec3(half_x, half_y, kWall)}, upright_at(x, y, kWall), smooth(0.2));
  };
  for (const double side : {-1.0, 1.0}) {
    wall(side * (kPianoArenaX + kThick), 0.0, kThick, kPianoArenaY);
    wall(0.0, side * (kPianoArenaY + kThick), kPianoArenaX + 2.0 * kThick, kThick);
  }
  // The path around them is an S.
  constexpr double kHalf = 0.5 * kPianoArenaY;
  wall(kPianoWallX[0], -kHalf, kPianoWallHalf, kHalf);
  wall(kPianoWallX[1], kHalf, kPianoWallHalf, kHalf);
  return builder.build(options);
}

std::unique_ptr<User> PianoScenario::make_user(std::size_t user, Controls& controls,
                                               const UserOptions& options) const {
  require_user(user);
  return std::make_unique<PianoUser>(user, options_, controls, options);
}

std::string PianoScenario::fault(const Scene& scene) const {
  const Vec3& p = scene.pose(scene.index_of("piano")).position;
  if (std::abs(p.x()) < kPianoArenaX && std::abs(p.y()) < kPianoArenaY) return {};
  return "the piano is outside of the maze";
}

std::unique_ptr<Referee> PianoScenario::make_referee(const Scene& scene) const {
  return std::make_unique<PianoReferee>(scene);
}

Achievement PianoScenario::achievement(const Outcome& outcome) const {
  const bool delivered = value_of(outcome, "delivered") > 0.5;
  if (!delivered) {
    const std::string left =
        length_words(value_of(outcome, "way_left_m")) + " of " + length_words(PianoPath().length());
    return {"left one piano in a maze with " + left + " to go", "piano arrived",
            "no, " + left + " to go", false};
  }
  const std::string when = two_digits(value_of(outcome, "delivered_at_s")) + " s";
  return {"carried one piano through a maze in " + when, "piano arrived", "after " + when};
}

}  // namespace tandem::demos
