// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// What a display of 144 Hz shows of a body that two users pull at over an ocean.
#include "tandem/pbd/smooth_poses.h"

#include <algorithm>
#include <vector>

#include "consensus/peer_fixture.h"
#include "support/catch.h"

namespace tandem::consensus::smooth_poses_test {
namespace {

using namespace testing;

constexpr double kDisplay = 144.0;  ///< Hz
constexpr double kStep = 1.0 / 60.0;

/// m, quantiles of how far a frame is from the last one beyond what speed explains.
struct Jumps {
  double p99 = 0.0;
  double largest = 0.0;
};

/// Frames of one peer whose body is shown by `blend` s.
class Display {
 public:
  explicit Display(double blend) : shown_({.blend = blend}) {}

  /// Draw all that is due before the next step ends.
  void after_step(const Site& site) {
    shown_.after_step(site.world, kStep);
    const double fastest = std::max(speed_, site.v().norm());
    speed_ = site.v().norm();
    const double begins = static_cast<double>(site.steps) * kStep;
    for (; next_ < begins + kStep; next_ += 1.0 / kDisplay) {
      const Vec3 at = shown_.at(site.body, (next_ - begins) / kStep).position;
      // Frames begin before the step and end in it: either's speed explains.
      if (frames_++ > 0)
        jumps_.push_back((at - last_).norm() - std::max(fastest, before_) / kDisplay);
      last_ = at;
    }
    before_ = fastest;
  }
  Jumps jumps() {
    std::ranges::sort(jumps_);
    return {jumps_[jumps_.size() * 99 / 100], jumps_.back()};
  }
  std::size_t frames() const { return jumps_.size(); }

 private:
  pbd::SmoothPoses shown_;
  std::vector<double> jumps_;
  Vec3 last_ = Vec3::Zero();
  double next_ = kStep;
  double speed_ = 0.0;
  double before_ = 0.0;
  int frames_ = 0;
};

/// A cube on a plane; each user takes it now and then and draws it about, two of them at once for
/// part of the time.
void add_user(Site& site, int index) {
  site.share(cube(Vec3(0.0, 0.0, 0.1)));
  put_on_plane(site);
  site.user = [index, grip = GrabId{}](Site& s, SessionTime now) mutable {
    const double t = 1e-9 * static_cast<double>(now - kStart);
    const bool holds = std::fmod(t + 2.5 * index, 6.0) < 4.0;
    const double phase = (index == 0 ? 2.1 : 2.9) * t;
    const Vec3 hand(0.5 * std::sin(phase), 0.4 * std::cos(0.7 * phase), 0.3);
    if (holds && grip.spring == 0) grip = s.peer->grab({.body = kBody, .anchor_w = hand});
    if (!holds && grip.spring != 0) s.peer->release(std::exchange(grip, {}));
    if (grip.spring != 0) s.peer->move(grip, hand, now);
  };
}

std::vector<Jumps> displays(int profile, double blend) {
  Session session(network_profile(profile));
  std::vector<Display> all(2, Display(blend));
  for (int i = 0; i < 2; ++i) {
    add_user(session.add(static_cast<PeerId>(i + 1), 0.007 * i), i);
  }
  session.after = [&](Site& site) { all[site.id - 1].after_step(site); };
  session.run(60.0);
  std::vector<Jumps> result;
  for (Display& display : all) {
    CHECK(display.frames() > 8000);
    result.push_back(display.jumps());
  }
  return result;
}

}  // namespace

TEST_CASE("smooth poses: at 144 Hz nothing jumps, over an ocean either", "[consensus][smooth]") {
  const int profile = GENERATE(1, 5);
  double raw = 0.0;  // m, the largest without blending
  for (const Jumps& jumps : displays(profile, 0.0)) raw = std::max(raw, jumps.largest);
  for (const Jumps& jumps : displays(profile, pbd::SmoothPosesOptions{}.blend)) {
    CAPTURE(profile, jumps.p99, jumps.largest, raw);
    CHECK(jumps.p99 <= 2e-3);
    CHECK(jumps.largest <= 8e-3);
    if (profile == 5) CHECK(raw > 1.5 * jumps.largest);  // what blending is worth
  }
}

}  // namespace tandem::consensus::smooth_poses_test
