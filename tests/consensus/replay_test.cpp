// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Agreement at the stamp, replayed to now, by real peers: what they disagree about vanishes at any
// delay, nothing is slowed down, and it costs what it should.
#include "tandem/consensus/replay.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "consensus/peer_fixture.h"
#include "support/bodies.h"
#include "support/catch.h"

namespace tandem::consensus::replay_test {
namespace {

using namespace testing;
using tandem::testing::names;
using tandem::testing::refusal;

constexpr double kFrame = 1.0 / 60.0;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

/// Fresh replays in each step: what the method is, whatever it costs.
PeerOptions fresh(PeerOptions options = {}) {
  options.authority_ramp = 0.0;
  options.replay.budget = kInf;
  return options;
}

using Build = std::function<void(Site&)>;

void free_ball(Site& site) {
  site.share(site.id == 1 ? ball(Vec3::Zero(), Vec3(1.0, 0.0, 0.0))
                          : ball(Vec3(0.05, 0.02, 0.0), Vec3(0.8, 0.3, 0.0)));
}

/// On an undamped spring of `hertz` to the origin.
Build swinging_ball(double hertz) {
  return [hertz](Site& site) {
    pbd::BodyDef def = ball(site.id == 1 ? Vec3(0.1, 0.0, 0.0) : Vec3(0.15, 0.03, 0.0));
    def.can_sleep = false;
    site.share(def);
    const double w = 2.0 * std::numbers::pi * hertz;
    auto& springs = site.world.add_block<pbd::Tethers>();
    springs.add(site.world, {.body = site.body, .stiffness = w * w, .damping = 0.0});
  };
}

struct Run {
  double apart = 0.0;        ///< m, largest in the last second
  double speed = 0.0;        ///< m/s, rms of the peers' mean motion in the last two seconds
  std::vector<Vec3> motion;  ///< m/s, of the mean, step by step
};

/// Two peers in step with each other.
Run run(const Build& build, double frames, const PeerOptions& options, double seconds) {
  Session session({.latency = frames * kFrame});
  Site& a = session.add(1, 0.0, options, kWeightless);
  Site& b = session.add(2, 0.0, options, kWeightless);
  build(a);
  build(b);
  Run result;
  session.after = [&](Site& site) {
    if (&site != &b) return;
    result.motion.push_back(0.5 * (a.v() + b.v()));
    if (session.network.now() > kStart + ns(seconds - 1.0)) {
      result.apart = std::max(result.apart, gap(a, b));
    }
  };
  session.run(seconds);
  double squares = 0.0;
  for (std::size_t i = result.motion.size() - 120; i < result.motion.size(); ++i) {
    squares += result.motion[i].squaredNorm() / 120.0;
  }
  result.speed = std::sqrt(squares);
  return result;
}

void check_agreement(const Build& build, double frames) {
  CAPTURE(frames);
  PeerOptions none = fresh();
  none.coupling = Coupling::None;
  // The mean of two that know nothing of each other is what physics makes of the mean.
  const Run alone = run(build, frames, none, 8.0);
  REQUIRE(alone.apart > 5e-3);
  for (const double budget : {kInf, ReplayOptions{}.budget}) {
    CAPTURE(budget);
    PeerOptions options = fresh();
    options.replay.budget = budget;
    const Run agreed = run(build, frames, options, 8.0);
    CHECK(agreed.apart < 1e-4);
    CHECK(agreed.speed == Approx(alone.speed).epsilon(0.01));
  }
}

TEST_CASE("replay: copies of a free body come together at any delay, and keep their speed",
          "[consensus][analytic]") {
  check_agreement(free_ball, GENERATE(0.0, 3.0, 8.0, 15.0));
}

TEST_CASE("replay: copies on a spring come together at any delay, and keep their speed",
          "[consensus][analytic]") {
  const double hertz = GENERATE(0.5, 1.7);
  CAPTURE(hertz);
  check_agreement(swinging_ball(hertz), GENERATE(0.0, 3.0, 8.0, 15.0));
}

// What the application does -----------------------------------------------------------------------

/// Does something to the ball at the first peer, and looks at what becomes of it there until the
/// other peer can have heard.
struct Deed {
  const char* name;
  std::function<void(Site&, int step)> act;  ///< from step 0 on
  Vec3 way;                                  ///< m, that it moves in all, but for speed
  Vec3 speed;                                ///< m/s, that it gains
};

TEST_CASE("replay: an application's change acts at its peer at once, at others in time",
          "[consensus]") {
  const std::vector<Deed> deeds{
      {"impulse",
       [](Site& site, int step) {
         if (step == 0) site.world.apply_impulse(site.body, Vec3(1.0, 0.0, 0.0), site.x());
       },
       Vec3::Zero(), Vec3(1.0, 0.0, 0.0)},
      {"force",
       [](Site& site, int step) {
         if (step < 6) site.world.apply_force(site.body, Vec3(10.0, 0.0, 0.0));
       },
       Vec3::Zero(), Vec3(1.0, 0.0, 0.0)},
      {"set_twist",
       [](Site& site, int step) {
         if (step == 0) {
           site.world.set_twist(site.body, {Vec3(0.0, 1.0, 0.0), Vec3::Zero()});
         }
       },
       Vec3::Zero(), Vec3(0.0, 1.0, 0.0)},
      {"set_pose",
       [](Site& site, int step) {
         if (step == 0) site.displace(Vec3(0.0, 0.0, 0.05));
       },
       Vec3(0.0, 0.0, 0.05), Vec3::Zero()},
  };
  const int frames = GENERATE(3, 8, 15);
  const double budget = GENERATE(as<double>{}, kInf, ReplayOptions{}.budget);
  for (const Deed& deed : deeds) {
    INFO(deed.name << ", " << frames << " frames late, budget " << budget);
    PeerOptions options = fresh();
    options.replay.budget = budget;
    Session session({.latency = frames * kFrame});
    Site& a = session.add(1, 0.0, options, kWeightless);
    Site& b = session.add(2, 0.0, options, kWeightless);
    for (Site* site : {&a, &b}) {
      pbd::BodyDef def = ball(Vec3::Zero());
      def.can_sleep = false;
      site->share(def);
    }
    session.run(0.5);
    REQUIRE(gap(a, b) < 1e-6);
    int step = -1;
    double least_speed = kInf;
    double least_way = kInf;
    a.user = [&](Site& site, SessionTime) { deed.act(site, ++step); };
    // Six steps are as long as any deed; nobody else can have said anything of it so far.
    session.after = [&](Site& site) {
      if (&site != &a || step < 6 || step >= frames) return;
      if (!deed.speed.isZero()) least_speed = std::min(least_speed, a.v().dot(deed.speed));
      if (!deed.way.isZero()) {
        least_way = std::min(least_way, a.x().dot(deed.way) / deed.way.norm());
      }
    };
    session.run(4.0);
    if (!std::isinf(least_speed)) CHECK(least_speed == Approx(1.0).epsilon(0.01));
    if (!std::isinf(least_way)) CHECK(least_way == Approx(0.05).epsilon(0.01));
    // Both have half of it in the end: the mean of one that was pushed and one that was not.
    CHECK(gap(a, b) < 1e-4);
    CHECK((a.v() - 0.5 * deed.speed).norm() < 0.01);
    CHECK((b.v() - 0.5 * deed.speed).norm() < 0.01);
    if (deed.speed.isZero()) CHECK((a.x() - 0.5 * deed.way).norm() < 0.01 * deed.way.norm());
  }
}

TEST_CASE("replay: the next step does not undo an application's change", "[consensus]") {
  // Copies that differ by a speed of their own, and so are replayed in each step.
  struct Case {
    const char* name;
    std::function<void(Site&)> act;
    Vec3 way;
    Vec3 speed;
  };
  const std::vector<Case> cases{
      {"impulse",
       [](Site& site) { site.world.apply_impulse(site.body, Vec3(0.0, 0.0, 1.0), site.x()); },
       Vec3::Zero(), Vec3(0.0, 0.0, 1.0)},
      {"force", [](Site& site) { site.world.apply_force(site.body, Vec3(0.0, 0.0, 60.0)); },
       Vec3::Zero(), Vec3(0.0, 0.0, 1.0)},
      {"set_pose", [](Site& site) { site.displace(Vec3(0.0, 0.0, 0.05)); }, Vec3(0.0, 0.0, 0.05),
       Vec3::Zero()},
  };
  for (const Case& deed : cases) {
    INFO(deed.name);
    const auto track = [&](bool acts) {
      Session session({.latency = 8.0 * kFrame});
      Site& a = session.add(1, 0.0, fresh(), kWeightless);
      Site& b = session.add(2, 0.0, fresh(), kWeightless);
      free_ball(a);
      free_ball(b);
      session.run(14.0 * kFrame);
      REQUIRE(a.peer->stats().replay.fresh > 0);
      REQUIRE((a.v() - b.v()).norm() > 0.05);
      bool done = !acts;
      a.user = [&](Site& site, SessionTime) {
        if (!done) deed.act(site);
        done = true;
      };
      std::vector<pbd::BodyState> states;
      session.after = [&](Site& site) {
        if (&site == &a) states.push_back(site.world.state(site.body));
      };
      session.run(7.0 * kFrame);
      return states;
    };
    const std::vector<pbd::BodyState> without = track(false);
    const std::vector<pbd::BodyState> with = track(true);
    REQUIRE(with.size() >= 6);
    for (std::size_t i = 1; i < 6; ++i) {
      CAPTURE(i);
      // Upwards nothing else happens to it, with or without agreement.
      const double faster = with[i].twist.linear.z() - without[i].twist.linear.z();
      CHECK(faster == Approx(deed.speed.z()).margin(1e-3));
      const double t = static_cast<double>(i) * kFrame;
      const double further = with[i].pose.position.z() - without[i].pose.position.z();
      const double wanted = deed.way.z() + t * deed.speed.z();
      CHECK(std::abs(further - wanted) < 1.5 * kFrame * deed.speed.z() + 1e-3);
    }
  }
}

/// Pushes the ball by code of its own, in the world and in its replays alike.
struct Wind final : ReplayHook {
  Site* site = nullptr;
  Vec3 force = Vec3::Zero();
  std::uint64_t calls = 0;
  SessionTime last = 0;
  double shortest = kInf;
  double longest = 0.0;
  void before_step(pbd::World& scratch, SessionTime time, double dt) override {
    ++calls;
    CHECK(time < site->world_time());
    shortest = std::min(shortest, dt);
    longest = std::max(longest, dt);
    last = time;
    pbd::Twist twist = scratch.twist(site->body);
    twist.linear += dt * force;
    scratch.set_twist(site->body, twist);
  }
};

TEST_CASE("replay: the hook is called once for each replayed step, at its time", "[consensus]") {
  const double budget = GENERATE(as<double>{}, kInf, ReplayOptions{}.budget);
  CAPTURE(budget);
  PeerOptions options = fresh();
  options.replay.budget = budget;
  Session session({.latency = 8.0 * kFrame});
  Site& a = session.add(1, 0.0, options, kWeightless);
  Site& b = session.add(2, 0.0, options, kWeightless);
  free_ball(a);
  free_ball(b);
  Wind wind;
  wind.site = &a;
  a.peer->set_replay_hook(&wind);
  session.run(1.0);
  const ReplayStats& stats = a.peer->stats().replay;
  CHECK(stats.steps > 30);
  CHECK(wind.calls == stats.steps);
  CHECK(wind.shortest == Approx(kFrame).epsilon(1e-6));
  CHECK(wind.longest == Approx(kFrame).epsilon(1e-6));
  a.peer->set_replay_hook(nullptr);
  const std::uint64_t calls = wind.calls;
  session.run(0.5);
  CHECK(wind.calls == calls);
}

// What hangs --------------------------------------------------------------------------------------

/// Ten links of 0.2 m and 1 kg that hang from a hook.
std::vector<pbd::BodyId> hang_chain(Site& site, double angle) {
  constexpr double kLink = 0.2;  // m
  const Vec3 down(std::sin(angle), 0.0, -std::cos(angle));
  auto& joints = site.world.add_block<pbd::JointBlock>();
  pbd::BodyId above = site.world.add_body({.type = pbd::BodyType::Static});
  std::vector<pbd::BodyId> links;
  for (int i = 0; i < 10; ++i) {
    pbd::BodyDef def = ball((i + 0.5) * kLink * down);
    def.pose.orientation = Quat(Eigen::AngleAxisd(-angle, Vec3::UnitY()));
    def.can_sleep = false;
    const pbd::BodyId link = site.world.add_body(def);
    joints.add(site.world, pbd::ball_joint_at(site.world, above, link, i * kLink * down));
    site.peer->share({.id = SharedId::from_name("link/" + std::to_string(i)), .body = link});
    links.push_back(link);
    above = link;
  }
  return links;
}

struct Apart {
  double early = 0.0;  ///< m, largest rms over the links in the middle third
  double late = 0.0;   ///< and in the last one
  double speed = 0.0;  ///< m/s, rms in the last third, of both
};

Apart chain_of(double delay) {
  Session session({.latency = delay});
  Site& a = session.add(1, 0.0, {.authority_ramp = 0.0});
  Site& b = session.add(2, 0.0, {.authority_ramp = 0.0});
  const auto here = hang_chain(a, 0.0);
  const auto there = hang_chain(b, 0.05);
  Apart apart;
  int steps = 0;
  session.after = [&](Site& site) {
    if (&site != &b) return;
    double sum = 0.0;
    double squares = 0.0;
    for (std::size_t i = 0; i < here.size(); ++i) {
      sum += (a.world.pose(here[i]).position - b.world.pose(there[i]).position).squaredNorm();
      squares += a.world.twist(here[i]).linear.squaredNorm();
      squares += b.world.twist(there[i]).linear.squaredNorm();
    }
    const double rms = std::sqrt(sum / 10.0);
    ++steps;
    if (steps > 600) {
      apart.late = std::max(apart.late, rms);
      apart.speed += squares;
    } else if (steps > 300) {
      apart.early = std::max(apart.early, rms);
    }
  };
  session.run(15.0);
  apart.speed = std::sqrt(apart.speed / (20.0 * (steps - 600)));
  return apart;
}

TEST_CASE("replay: chains of which one hung aside come to agree, and the swing stays",
          "[consensus][long]") {
  const double frames = GENERATE(0.0, 3.0, 8.0, 15.0, 30.0);
  CAPTURE(frames);
  const Apart apart = chain_of(frames / 60.0);
  CHECK(apart.late < 1e-4);
  CHECK(apart.late < 1.1 * apart.early + 1e-5);
  // The mean of a swing and of none is half as far: 0.025 rad, of whose energy m g h half is in
  // motion in the mean. Those speeds are the physics', and agreement should leave them.
  const double expected = std::sqrt(0.5 * 9.81 * 2.0 * 0.5) * 0.025;
  CHECK(apart.speed > 0.65 * expected);
  CHECK(apart.speed < 1.3 * expected);
}

// What is refused ---------------------------------------------------------------------------------

TEST_CASE("replay: options out of range are refused by field and rule", "[consensus][fault]") {
  const auto refused = [](const std::function<void(ReplayOptions&)>& change) {
    ReplayOptions options;
    change(options);
    const std::string message = refusal([&] { options.validate(); });
    // A peer refuses the same.
    VirtualNetwork network;
    pbd::World world;
    CHECK(refusal([&] { Peer(world, network.transport(1), {.replay = options}); }) == message);
    return message;
  };
  CHECK(refused([](ReplayOptions&) {}).empty());
  CHECK(refused([](ReplayOptions& o) { o.share = 1.0; }).empty());
  CHECK(refused([](ReplayOptions& o) { o.budget = kInf; }).empty());
  CHECK(refused([](ReplayOptions& o) { o.tolerance = 0.0; }).empty());
  CHECK(names(refused([](ReplayOptions& o) { o.share = 0.0; }), "share", "0",
              "above 0 and at most 1"));
  CHECK(names(refused([](ReplayOptions& o) { o.share = 1.5; }), "share", "1.5",
              "above 0 and at most 1"));
  CHECK(names(refused([](ReplayOptions& o) { o.share = kNan; }), "share", "nan",
              "above 0 and at most 1"));
  CHECK(names(refused([](ReplayOptions& o) { o.budget = 0.5; }), "budget", "0.5", "at least 1"));
  CHECK(names(refused([](ReplayOptions& o) { o.budget = kNan; }), "budget", "nan", "at least 1"));
  CHECK(names(refused([](ReplayOptions& o) { o.tolerance = -1.0; }), "tolerance", "-1", ">= 0"));
  CHECK(names(refused([](ReplayOptions& o) { o.tolerance = kInf; }), "tolerance", "inf", "finite"));
}

}  // namespace
}  // namespace tandem::consensus::replay_test
