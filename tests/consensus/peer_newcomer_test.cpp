// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Who comes late, or comes back, learns before it is heard.
#include <algorithm>
#include <cmath>

#include "consensus/peer_fixture.h"
#include "support/catch.h"
#include "support/oracles.h"

namespace tandem::consensus::peer_newcomer_test {
namespace {

using tandem::testing::angle_between;
using tandem::testing::kPi;
using namespace testing;

Quat about_y(double angle) { return Quat(Eigen::AngleAxisd(angle, Vec3::UnitY())); }

/// Two peers that have shared a cube on a plane for 3 s, and a third that believes it elsewhere.
struct LateArrival {
  Session session;
  Vec3 agreed;
  double others_moved = 0.0;   ///< m, largest so far
  double others_turned = 0.0;  ///< rad
  Quat agreed_orientation = Quat::Identity();

  LateArrival(int profile, PeerId newcomer, const Vec3& offset, const Quat& orientation)
      : session(network_profile(profile)) {
    for (int i = 0; i < 2; ++i) add(static_cast<PeerId>(i + 2), 0.007 * i, Vec3::Zero());
    session.run(3.0);
    agreed = session[0].x();
    agreed_orientation = session[0].pose().orientation;
    add(newcomer, 0.003, offset, orientation);
    session.after = [this](Site& site) {
      if (&site == session.sites.back().get()) return;
      others_moved = std::max(others_moved, (site.x() - agreed).norm());
      others_turned =
          std::max(others_turned, angle_between(site.pose().orientation, agreed_orientation));
    };
  }
  void add(PeerId id, double phase, const Vec3& offset,
           const Quat& orientation = Quat::Identity()) {
    Site& site = session.add(id, phase);
    site.share(cube(Vec3(0.0, 0.0, kHalf.z()) + offset, orientation));
    put_on_plane(site);
  }
};

TEST_CASE("peer: a newcomer learns where things are and hardly moves the others", "[consensus]") {
  const int profile = GENERATE(1, 5);
  const double distance = GENERATE(0.08, 0.5);
  const PeerId id = GENERATE(PeerId{1}, PeerId{9});
  CAPTURE(profile, distance, id);
  LateArrival scene(profile, id, {distance, 0.0, 0.0}, Quat::Identity());
  scene.session.run(4.0);
  CHECK(gap(scene.session[2], scene.session[0]) < 1e-3);
  CHECK(gap(scene.session[2], scene.session[1]) < 1e-3);
  // It takes over what it hears at its first chance, one latency after it has come; what it said
  // before is heard for as long. Its announced share is 0 at first and grows to the baseline within
  // the ramp of 1 s: the others close the integral of 60 * 0.08 t over that time of the distance.
  const LinkOptions link = network_profile(profile);
  const double heard = link.latency + link.jitter + 2.0 / 60.0;
  CHECK(scene.others_moved < 0.5 * 60.0 * 0.08 * heard * heard * distance);
}

TEST_CASE("peer: a newcomer with the lowest id does not impose its orientation", "[consensus]") {
  const PeerId id = GENERATE(PeerId{1}, PeerId{9});
  const int profile = GENERATE(1, 5);
  CAPTURE(id, profile);
  LateArrival scene(profile, id, Vec3::Zero(), about_y(0.5 * kPi));
  scene.session.run(5.0);
  const Quat& late = scene.session[2].pose().orientation;
  CHECK(angle_between(late, scene.session[0].pose().orientation) < kPi / 180.0);
  CHECK(angle_between(late, scene.session[1].pose().orientation) < kPi / 180.0);
  CHECK(scene.others_turned < 20.0 * kPi / 180.0);
}

}  // namespace
}  // namespace tandem::consensus::peer_newcomer_test
