// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "scenes/recorded_hand.h"

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <numbers>
#include <string>
#include <tuple>
#include <vector>

#include "runner/virtual_runner.h"
#include "runs.h"
#include "scenes/cubes.h"
#include "scenes/piano.h"
#include "scenes/room.h"
#include "scenes/tennis.h"
#include "support/catch.h"
#include "tandem/consensus/virtual_network.h"
#include "tandem/pbd/solver.h"

namespace tandem::demos::recorded_hand_test {
namespace {

using consensus::SessionTime;
using pbd::Vec3;

constexpr double kMass = 0.3;  // kg

/// One box of 10 cm on the ground.
class OneBox final : public Scenario {
 public:
  OneBox() : Scenario("one box", 1) {}
  Scene build(const SceneOptions& options) const override {
    SceneBuilder builder;
    builder.box("box", Vec3::Constant(0.1), kMass, Vec3(0.5, 0.0, 0.05));
    return builder.build(options, 0.5);
  }
  std::unique_ptr<User> make_user(std::size_t, Controls&, const UserOptions&) const override {
    return nullptr;
  }
  std::vector<std::size_t> holdable(const Scene& scene) const override { return unowned(scene); }
};

/// A peer without company.
struct Bench {
  explicit Bench(const Scenario& scenario) : scene(scenario.build({})) {
    peer = std::make_unique<consensus::Peer>(*scene.world, network.transport(1));
    for (const SceneBody& body : scene.bodies) {
      peer->share({.id = body.id, .body = body.body, .owner = std::nullopt});
    }
    controls = std::make_unique<Controls>(0, scene, *peer, 0);
  }
  /// To the session time `end` (s).
  void run(User& user, double end) {
    while (now < static_cast<SessionTime>(end * 1e9)) {
      controls->begin(now, 1.0 / 64.0);
      user.update(now);
      peer->before_step(now);
      solver.step(*scene.world, 1.0 / 64.0);
      now += 15'625'000;  // 1/64 s
      peer->after_step(now);
    }
  }

  consensus::VirtualNetwork network;
  Scene scene;
  std::unique_ptr<consensus::Peer> peer;
  std::unique_ptr<Controls> controls;
  pbd::Solver solver;
  SessionTime now = 0;
};

/// m: a lift by 20 cm in a second, and 5 cm to and fro, in another place.
Vec3 way(double t) {
  const double up = 0.1 * (1.0 - std::cos(std::numbers::pi * std::min(t, 1.0)));
  return Vec3(-3.0 + 0.05 * std::sin(std::numbers::pi * t), 2.0, 0.4 + up);
}
constexpr double kSharpest = 0.1 * 9.87;  // m/s^2, of that way's acceleration, each term pi^2

/// That way at 60 Hz, as a page would have written it, from 0.5 s on.
HandRecord recorded(double seconds, const std::string& body, const Vec3& attachment) {
  HandRecord record;
  HandRecord::Hold hold;
  hold.body = body;
  hold.attachment_l = attachment;
  for (int i = 0; i <= std::lround(60.0 * seconds); ++i) {
    hold.way.push_back({0.5 + i / 60.0, way(i / 60.0)});
  }
  hold.end = 0.5 + seconds;
  record.holds.push_back(hold);
  record.seconds = hold.end;
  return record;
}

// A critically damped follower is behind by the sum of two exponential times of kSmooth each, of
// which a step sees its end at once: by twice kSmooth less half a step in the mean, with a variance
// of 2 kSmooth^2.
TEST_CASE("recorded hand: it goes where the recorded one went, smoothly", "[demos][analytic]") {
  constexpr double kSmooth = PointerHand::kSmooth;
  constexpr double kBehind = 2.0 * kSmooth - 0.5 / 64.0;
  const OneBox scenario;
  Bench bench(scenario);
  RecordedHand user(0, scenario, *bench.controls, recorded(3.0, "cube/9", Vec3::Zero()));
  bench.run(user, 0.45);
  CHECK_FALSE(bench.controls->holds(0));
  bench.run(user, 3.4);
  REQUIRE(bench.controls->holds(0));
  const Vec3 start(0.5, 0.0, 0.05);
  int moves = 0;
  for (const Input& input : bench.controls->log()) {
    if (input.kind != Input::Kind::Move) continue;
    ++moves;
    const double t = 1e-9 * static_cast<double>(input.time) - 0.5;
    const Vec3 is(input.values[0], input.values[1], input.values[2]);
    if (t < 0.5) continue;  // it has begun at rest
    const Vec3 expected = start + way(t - kBehind) - way(0.0);
    // And the error of lines between points 1/60 s apart.
    CHECK((is - expected).norm() <=
          kSharpest * (kSmooth * kSmooth + 1.0 / (8.0 * 60.0 * 60.0)) + 1e-4);
  }
  CHECK(moves > 180);
  // The spring has 1000 N/m for each kg.
  const double sag = 0.25 - bench.scene.pose(0).position.z();
  CHECK(sag == Approx(9.81e-3).margin(1e-3));
  bench.run(user, 4.5);
  CHECK_FALSE(bench.controls->holds(0));
  CHECK(value_of(user.outcome(), "holds_done") == 1.0);
}

TEST_CASE("recorded hand: it is no faster than 2 m/s and stays within 10 cm of its point",
          "[demos][unit]") {
  const OneBox scenario;
  Bench bench(scenario);
  HandRecord record = recorded(1.0, "box", Vec3(0.5, 0.0, 0.0));
  for (HandRecord::Hold::Point& point : record.holds[0].way) {
    if (point.time > 0.6) point.wanted = Vec3(90.0, 0.0, 90.0);
  }
  RecordedHand user(0, scenario, *bench.controls, std::move(record));
  Vec3 before = Vec3(0.55, 0.0, 0.05);  // the recorded point is outside: the side of the box
  bench.run(user, 0.5);
  for (double end = 0.52; end < 1.45; end += 1.0 / 64.0) {
    const Vec3 held = bench.scene.pose(0).to_world(Vec3(0.05, 0.0, 0.0));
    bench.run(user, end);
    const std::vector<Input>& log = bench.controls->log();
    REQUIRE_FALSE(log.empty());
    const std::size_t at = log.back().kind == Input::Kind::Grab ? 3 : 0;
    const Vec3 anchor(log.back().values[at], log.back().values[at + 1], log.back().values[at + 2]);
    CHECK((anchor - held).norm() <= 0.1 + 1e-9);
    if (log.size() < 5) CHECK((anchor - before).norm() <= 2.0 / 64.0 + 1e-9);
    before = anchor;
  }
}

TEST_CASE("recorded hand: it holds the body of that name, else the scene's next one",
          "[demos][unit]") {
  const CubesScenario cubes;
  for (const auto& [name, user, held] :
       {std::tuple{"cube/1/2", 0, "cube/1/2"}, std::tuple{"pillar/0", 0, "plate"},
        std::tuple{"ball/0", 0, "plate"}, std::tuple{"ball/0", 1, "cube/0/0"}}) {
    CAPTURE(name, user);
    Bench bench(cubes);
    RecordedHand hand(static_cast<std::size_t>(user), cubes, *bench.controls,
                      recorded(1.0, name, Vec3::Zero()));
    bench.run(hand, 0.6);
    CHECK(bench.controls->holds(bench.scene.index_of(held)));
  }
  const TennisScenario tennis;
  Bench bench(tennis);
  CHECK_THROWS_AS(RecordedHand(0, tennis, *bench.controls, recorded(1.0, "b", Vec3::Zero())),
                  std::invalid_argument);
}

/// In a folder of its own.
struct File {
  explicit File(const std::string& text) { std::ofstream(path) << text; }
  ~File() { std::filesystem::remove(path); }
  std::string path =
      (std::filesystem::temp_directory_path() /
       ("tandem-hand-" + std::to_string(reinterpret_cast<std::uintptr_t>(this)) + ".txt"))
          .string();
};

TEST_CASE("recorded hand: the same file gives the same bits twice", "[demos][determinism]") {
  const File file(
      "tandem-hand 1\nroom sandbox\nrate 60\n0.2 grab a 0 0 0.1 0 0 0\n"
      "0.7 move 0 0.1 0.3\n1.4 let\n1.5 grab b 0.05 0 0 1 1 1\n2.2 move 1.2 1 1.2\n2.6 let\n"
      "3 end\n");
  DemoOptions options = quiet(3, 3.0);
  options.hands = {file.path, file.path};
  const auto hashes = [&](const DemoOptions& o) {
    std::vector<std::uint64_t> result;
    for (const PeerRecord& peer : run_virtual(CubesScenario(), o).peers)
      result.push_back(peer.hash);
    return result;
  };
  const std::vector<std::uint64_t> first = hashes(options);
  CHECK(first == hashes(options));
  DemoOptions scripted = options;
  scripted.hands.clear();
  CHECK(first != hashes(scripted));
}

TEST_CASE("recorded hand: the records of the evaluation play in their scenes", "[demos][unit]") {
  DemoOptions options = quiet(3, 32.0);
  std::vector<double> holds;
  for (const char* name : {"synthetic-pointer-1.txt", "synthetic-pointer-2.txt"}) {
    const std::string path = std::string(TANDEM_HANDS) + "/" + name;
    // Nobody may take it for a person's.
    std::ifstream file(path);
    std::string line;
    std::getline(file, line);
    CHECK(line.find("# Synthetic pointer through the page") == 0);
    CHECK(std::filesystem::file_size(path) < 60000);
    holds.push_back(static_cast<double>(read_hand_record(path).holds.size()));
    CHECK(holds.back() >= 3.0);
    options.hands.push_back(path);
  }
  const CubesScenario cubes;
  const PianoScenario piano;
  const RoomScenario room;
  for (const Scenario* scenario :
       {static_cast<const Scenario*>(&cubes), static_cast<const Scenario*>(&piano),
        static_cast<const Scenario*>(&room)}) {
    CAPTURE(scenario->name());
    const RunResult run = run_virtual(*scenario, options);
    for (std::size_t user = 0; user < 2; ++user) {
      CHECK(run.peers[user].fault == "");
      CHECK(number(run.peers[user], user == 0 ? "a_holds_done" : "b_holds_done") == holds[user]);
    }
  }
}

}  // namespace
}  // namespace tandem::demos::recorded_hand_test
