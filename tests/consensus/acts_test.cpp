// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// What one application does to a shared body at once happens at all peers.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "consensus/peer_fixture.h"
#include "support/catch.h"

namespace tandem::consensus::acts_test {
namespace {

using namespace testing;

/// All peers are past their authority ramps then.
constexpr double kSettled = 1.5;  // s

void resting_cube(Site& site) {
  site.share(cube({0.0, 0.0, kHalf.z()}));
  put_on_plane(site);
}

std::unique_ptr<Session> settled(int peers, int profile,
                                 const std::function<void(Site&)>& build = resting_cube,
                                 const pbd::WorldDef& def = {}) {
  auto session = std::make_unique<Session>(network_profile(profile));
  for (int i = 0; i < peers; ++i) {
    build(session->add(static_cast<PeerId>(i + 1), 0.0049 * i, {}, def));
  }
  session->run(kSettled);
  return session;
}

double farthest_apart(Session& session) {
  double most = 0.0;
  for (const auto& site : session.sites) most = std::max(most, gap_now(*session.sites[0], *site));
  return most;
}

/// 50 cubes on a plane, 1 m apart; the first one is kBody.
constexpr int kMany = 50;
SharedId id_of(int i) { return i == 0 ? kBody : SharedId::from_name("cube " + std::to_string(i)); }
Vec3 place_of(int i) { return {1.0 * (i % 10), 1.0 * (i / 10), kHalf.z()}; }
void many_cubes(Site& site) {
  const pbd::BodyId ground = site.world.add_body({.type = pbd::BodyType::Static});
  for (int i = 0; i < kMany; ++i) {
    const pbd::BodyId body = site.world.add_body(cube(place_of(i)));
    if (i == 0) site.body = body;
    site.peer->share({.id = id_of(i), .body = body});
    site.contacts.box_on_plane(ground, Vec3::UnitZ(), 0.0, body, kHalf, {.friction = 0.5});
  }
  site.world.set_contact_source(&site.contacts);
}
const Vec3& x_of(const Site& site, int i) {
  return site.world.pose(site.peer->body_of(id_of(i))).position;
}

TEST_CASE("acts: figures", "[.measure]") {
  for (const int profile : {1, 3, 5}) {
    for (const int peers : {1, 2, 3, 6}) {
      {
        const auto session = settled(peers, profile);
        Site& actor = *session->sites.back();
        actor.peer->act({.body = kBody, .impulse = {4.0, 0.0, 0.0}});
        std::printf("kick profile %d peers %d:", profile, peers);
        double worst = 0.0;
        for (int k = 0; k < 12; ++k) {
          session->run(0.1);
          std::printf(" %.3f(%.3f)", actor.x().x(), farthest_apart(*session));
        }
        session->run(1.0);
        std::printf(" end %.4f apart %.4f %f\n", actor.x().x(), farthest_apart(*session), worst);
      }
      {
        const auto session = settled(peers, profile);
        Site& actor = *session->sites.back();
        // 0.5 s of 0.15 N s in each step: 9 N on 1 kg, of which friction takes 4.9 N.
        int pushes = 30;
        actor.user = [&](Site& site, SessionTime) {
          if (pushes-- > 0) site.peer->act({.body = kBody, .impulse = {0.15, 0.0, 0.0}});
        };
        std::printf("push profile %d peers %d:", profile, peers);
        for (int k = 0; k < 14; ++k) {
          session->run(0.1);
          std::printf(" %.3f(%.3f)", actor.x().x(), farthest_apart(*session));
        }
        session->run(1.0);
        std::printf(" end %.4f apart %.4f\n", actor.x().x(), farthest_apart(*session));
      }
      if (peers > 1) {
        const auto session = settled(peers, profile, [](Site& site) { site.share(ball(Vec3::Zero())); }, kWeightless);
        (*session)[0].peer->act({.body = kBody, .impulse = {2.0, 0.0, 0.0}});
        session->sites.back()->peer->act({.body = kBody, .impulse = {1.0, 2.0, 0.0}});
        std::printf("two profile %d peers %d:", profile, peers);
        for (int k = 0; k < 10; ++k) {
          session->run(0.1);
          const Vec3 v = (*session)[0].v();
          std::printf(" (%.2f %.2f)%.2f(%.3f)", v.x(), v.y(), (*session)[0].x().x(), farthest_apart(*session));
        }
        std::printf("\n");
      }
      if (peers > 1) {
        const auto session = settled(peers, profile, [](Site& site) { site.share(ball(Vec3::Zero())); }, kWeightless);
        int late = 0;
        for (auto& site : session->sites) {
          session->run(0.01 * late++);
          site->peer->act({.body = kBody, .impulse = {2.0, 0.0, 0.0}, .name = 7});
        }
        std::printf("named profile %d peers %d:", profile, peers);
        for (int k = 0; k < 10; ++k) {
          session->run(0.1);
          const Vec3 v = (*session)[0].v();
          std::printf(" (%.2f %.2f)%.2f(%.3f)", v.x(), v.y(), (*session)[0].x().x(), farthest_apart(*session));
        }
        std::printf("\n");
      }
      {
        const auto session = settled(peers, profile);
        Site& actor = *session->sites.back();
        actor.peer->act({.body = kBody, .pose = Pose{Vec3(3.0, 1.0, 1.0), Quat::Identity()}, .twist = Twist{}});
        std::printf("respawn profile %d peers %d:", profile, peers);
        for (int k = 0; k < 12; ++k) {
          session->run(0.1);
          std::printf(" %.3f %.3f(%.3f)", actor.x().x(), actor.x().z(), farthest_apart(*session));
        }
        std::printf("\n");
      }
      {
        const auto session = settled(peers, profile, many_cubes);
        Site& actor = *session->sites.back();
        for (int i = 0; i < kMany; ++i) {
          const Vec3 away = (place_of(i) - Vec3(4.5, 2.2, 0.0)).normalized();
          actor.peer->act({.body = id_of(i), .impulse = 3.0 * Vec3(away.x(), away.y(), 0.0)});
        }
        std::printf("blast profile %d peers %d:", profile, peers);
        for (int k = 0; k < 14; ++k) {
          session->run(0.1);
          double way = 0.0, most = 0.0;
          for (int i = 0; i < kMany; ++i) {
            way += (x_of(actor, i) - place_of(i)).norm() / kMany;
            for (auto& site : session->sites) most = std::max(most, (x_of(actor, i) - x_of(*site, i)).norm());
          }
          std::printf(" %.3f(%.3f)", way, most);
        }
        std::printf("\n");
      }
    }
  }
}

TEST_CASE("acts: more figures", "[.measure]") {
  const auto weightless = [](Site& site) { site.share(ball(Vec3::Zero())); };
  LinkOptions lossy = network_profile(4);
  lossy.loss = 0.2;
  lossy.jitter = 0.03;
  for (const int peers : {2, 3, 6}) {
    for (int seed = 1; seed < 6; ++seed) {
      Session session(lossy, kStart, static_cast<std::uint64_t>(seed));
      for (int i = 0; i < peers; ++i) resting_cube(session.add(static_cast<PeerId>(i + 1), 0.0049 * i));
      session.run(kSettled);
      Site& actor = *session.sites.back();
      actor.peer->act({.body = kBody, .impulse = {4.0, 0.0, 0.0}});
      std::printf("lossy kick peers %d:", peers);
      for (int k = 0; k < 12; ++k) {
        session.run(0.1);
        std::printf(" %.3f/%.2f(%.3f)", actor.x().x(), session[0].v().x(), farthest_apart(session));
      }
      std::printf("\n");
    }
    for (const int profile : {3, 5}) {
      Session session(network_profile(profile));
      PeerOptions options;
      options.sending = {.format = StateFormat::Compact, .kbit_per_s = 128.0, .tolerance = 0.002};
      for (int i = 0; i < peers; ++i) resting_cube(session.add(static_cast<PeerId>(i + 1), 0.0049 * i, options));
      session.run(3.0);
      Site& actor = *session.sites.back();
      actor.peer->act({.body = kBody, .impulse = {4.0, 0.0, 0.0}});
      std::printf("compact kick %d peers %d:", profile, peers);
      for (int k = 0; k < 12; ++k) {
        session.run(0.1);
        std::printf(" %.3f/%.2f(%.3f)", actor.x().x(), session[0].v().x(), farthest_apart(session));
      }
      std::printf("\n");
      for (const double later : {0.05, 0.15, 0.3, 0.6}) {
        const auto both = settled(peers, profile, weightless, kWeightless);
        both->sites.back()->peer->act({.body = kBody, .impulse = {2.0, 0.0, 0.0}});
        both->run(later);
        (*both)[0].peer->act({.body = kBody, .impulse = {0.0, 2.0, 0.0}});
        std::printf("later %.2f profile %d peers %d:", later, profile, peers);
        for (int k = 0; k < 10; ++k) {
          both->run(0.1);
          const Vec3 v = (*both)[0].v();
          const Vec3 w = both->sites.back()->v();
          std::printf(" (%.2f %.2f)(%.2f %.2f)(%.3f)", v.x(), v.y(), w.x(), w.y(), farthest_apart(*both));
        }
        std::printf("\n");
      }
      {
        const auto both = settled(peers, profile, weightless, kWeightless);
        for (Site* site : {&(*both)[0], both->sites.back().get()}) {
          site->user = [n = 30](Site& s, SessionTime) mutable {
            if (n-- > 0) s.peer->act({.body = kBody, .impulse = {s.id == 1 ? 0.05 : 0.0, s.id == 1 ? 0.0 : 0.05, 0.0}});
          };
        }
        std::printf("both push profile %d peers %d:", profile, peers);
        for (int k = 0; k < 12; ++k) {
          both->run(0.1);
          const Vec3 v = (*both)[0].v();
          std::printf(" (%.2f %.2f)(%.3f)", v.x(), v.y(), farthest_apart(*both));
        }
        std::printf("\n");
      }
      {
        const auto both = settled(peers, profile, weightless, kWeightless);
        both->sites.back()->peer->act({.body = kBody, .twist = Twist{{2.0, 0.0, 0.0}, {0.0, 0.0, 5.0}}});
        (*both)[0].peer->act({.body = kBody, .twist = Twist{{0.0, 2.0, 0.0}, {0.0, 0.0, 5.0}}});
        std::printf("both set profile %d peers %d:", profile, peers);
        for (int k = 0; k < 12; ++k) {
          both->run(0.1);
          const Vec3 v = (*both)[0].v();
          std::printf(" (%.2f %.2f)(%.3f)", v.x(), v.y(), farthest_apart(*both));
        }
        std::printf("\n");
      }
      {
        const auto both = settled(peers, profile);
        both->sites.back()->peer->act({.body = kBody, .pose = Pose{Vec3(3.0, 1.0, 1.0), Quat::Identity()}, .twist = Twist{}});
        (*both)[0].peer->act({.body = kBody, .pose = Pose{Vec3(-3.0, 1.0, 1.0), Quat::Identity()}, .twist = Twist{}});
        std::printf("both respawn profile %d peers %d:", profile, peers);
        for (int k = 0; k < 12; ++k) {
          both->run(0.1);
          std::printf(" (%.2f %.2f)(%.3f)", (*both)[0].x().x(), both->sites.back()->x().x(), farthest_apart(*both));
        }
        std::printf("\n");
      }
    }
  }
}

}  // namespace
}  // namespace tandem::consensus::acts_test
