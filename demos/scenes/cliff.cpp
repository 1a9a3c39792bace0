// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "scenes/cliff.h"

#include <cmath>
#include <stdexcept>
#include <utility>

#include "demos/scenes/cliff_geometry.h"
#include "scenes/random.h"
#include "scenes/words.h"
#include "tandem/pbd/validate.h"

namespace tandem::demos {

namespace {

using pbd::Vec3;

constexpr std::uint32_t kRelease = 1;  // signal
constexpr std::uint64_t kPlaces = 20261121;

class KeyUser final : public User {
 public:
  KeyUser(Controls& controls, double time) : controls_(controls), time_(time) {}
  void update(consensus::SessionTime /*now*/) override {
    if (pressed_ || controls_.time() < time_) return;
    pressed_ = true;
    controls_.signal(kRelease, CliffScenario::kLead);
  }

 private:
  Controls& controls_;
  double time_;
  bool pressed_ = false;
};

class CliffReferee final : public Referee {
 public:
  void watch(const Scene& scene, double /*time*/) override {
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
      const Vec3& p = scene.pose(i).position;
      deepest_ = std::max(deepest_, kCliffBallRadius - (p.z() - cliff_surface(p.x(), p.y())));
      fastest_ = std::max(fastest_, scene.twist(i).linear.norm());
    }
  }
  Outcome outcome(const Scene& scene) const override {
    double lost = 0.0, over = 0.0, moving = 0.0;
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
      const Vec3& p = scene.pose(i).position;
      const bool inside = std::abs(p.x()) < kCliffHalf && std::abs(p.y()) < kCliffHalf;
      if (!inside || p.z() < cliff_surface(p.x(), p.y())) lost += 1.0;
      if (p.z() < 3.0) over += 1.0;
      if (scene.twist(i).linear.norm() > 0.05) moving += 1.0;
    }
    return {{"lost", lost},
            {"over_the_cliff", over},
            {"still_moving", moving},
            {"deepest_m", deepest_},
            {"fastest_m_s", fastest_}};
  }

 private:
  double deepest_ = 0.0;  ///< m, of a ball's lowest point below the triangle under its centre
  double fastest_ = 0.0;  ///< m/s
};

}  // namespace

CliffScenario::CliffScenario(int balls) : Scenario("cliff", 1), balls_(balls) {
  if (balls < 1 || balls > 1000) {
    pbd::detail::refuse("CliffScenario: balls", "from 1 to 1000", balls);
  }
}

Scene CliffScenario::build(const SceneOptions& options) const {
  SceneBuilder builder;
  Random random(kPlaces);
  const std::vector<Vec3> places = cliff_balls([&random] { return random.uniform(0.0, 1.0); });
  for (int i = 0; i < balls_; ++i) {
    BodySpec spec;
    spec.name = "ball/" + std::to_string(i);
    spec.parts.push_back({collision::Sphere{kCliffBallRadius}, {}});
    spec.pose.position = places[static_cast<std::size_t>(i)];
    spec.held_up = true;
    builder.add(std::move(spec));
  }
  const CliffMesh mesh = cliff_mesh();
  builder.fix(collision::TriangleMesh::make(mesh.vertices, mesh.triangles), {});
  constexpr double kThick = 1.0;
  constexpr double kHigh = 10.0;
  for (const double side : {-1.0, 1.0}) {
    const double at = side * (kCliffHalf + kThick);
    pbd::Pose pose;
    pose.position = Vec3(at, 0.0, kHigh - 2.0);
    builder.fix(collision::Box{Vec3(kThick, kCliffHalf + 2.0 * kThick, kHigh)}, pose);
    pose.position = Vec3(0.0, at, kHigh - 2.0);
    builder.fix(collision::Box{Vec3(kCliffHalf, kThick, kHigh)}, pose);
  }
  return builder.build(options);
}

std::unique_ptr<User> CliffScenario::make_user(std::size_t user, Controls& controls,
                                               const UserOptions& options) const {
  require_user(user);
  Random random(derived_seed(options.seed, 18));
  return std::make_unique<KeyUser>(controls, kPress + random.uniform(-0.1, 0.1));
}

void CliffScenario::on_signal(Scene& scene, const Signal& signal,
                              consensus::SessionTime now) const {
  if (signal.code != kRelease) return;
  const double age = 1e-9 * static_cast<double>(now - signal.time);
  // A late joiner learns the balls' positions from the others.
  constexpr double kMaxAge = 0.5;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) let_fall(scene, i, std::min(age, kMaxAge));
}

std::string CliffScenario::fault(const Scene& scene) const {
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const Vec3& p = scene.pose(i).position;
    const bool inside = std::abs(p.x()) < kCliffHalf && std::abs(p.y()) < kCliffHalf;
    if (!inside) return scene.bodies[i].name + " is behind a wall";
    if (p.z() < cliff_surface(p.x(), p.y())) return scene.bodies[i].name + " is under the ground";
  }
  return {};
}

std::unique_ptr<Referee> CliffScenario::make_referee(const Scene& /*scene*/) const {
  return std::make_unique<CliffReferee>();
}

Achievement CliffScenario::achievement(const Outcome& outcome) const {
  const auto over = static_cast<std::size_t>(value_of(outcome, "over_the_cliff"));
  const auto lost = static_cast<std::size_t>(value_of(outcome, "lost"));
  return {"saw " + count_words(over, "ball") + " fall over a cliff", "balls over the cliff",
          std::to_string(over), lost == 0};
}

}  // namespace tandem::demos
