// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/actor.h"
#include "common/run_arguments.h"
#include "runs.h"
#include "scenes/cliff.h"
#include "scenes/cubes.h"
#include "scenes/piano.h"
#include "scenes/pile.h"
#include "scenes/room.h"
#include "scenes/tennis.h"
#include "support/catch.h"
#include "tandem/consensus/update.h"
#include "tandem/consensus/virtual_link.h"
#include "trace/diff.h"
#include "trace/peer_trace.h"
#include "trace/replayer.h"
#include "trace_support.h"

namespace tandem::demos::trace_test {
namespace {

/// Half as many stacks on half a plate, to be quick.
const CubesOptions kSmall{.stacks = 2, .height = 3, .plate = pbd::Vec3(0.8, 0.8, 0.04)};

struct Replay {
  std::uint64_t steps = 0;
  std::optional<Departure> departure;
  std::uint64_t hash = 0;  ///< of the world at the end
};

Replay replay(const Scenario& scenario, const Bytes& trace) {
  Replayer replayer(scenario, trace);
  while (replayer.next_step()) {
  }
  return {replayer.steps(), replayer.departure(), replayer.scene().world->hash()};
}

/// Runs it and checks that each peer's replay is what the peer did.
void check_replays(const Scenario& scenario, const DemoOptions& options) {
  const TracedRun run = traced_run(scenario, options);
  for (std::size_t i = 0; i < run.traces.size(); ++i) {
    const PeerRecord& peer = run.result.peers[i];
    INFO(scenario.name() << ", " << to_string(options.scheme) << ", peer " << peer.id);
    const Replay again = replay(scenario, run.traces[i]);
    if (again.departure) UNSCOPED_INFO(to_text(*again.departure, ""));
    CHECK_FALSE(again.departure);
    CHECK(again.steps == peer.step_s.size());
    CHECK(again.hash == peer.hash);
  }
}

TEST_CASE("trace: a replay of every demo is bit-exact, in one pass and in two steps",
          "[demos][golden]") {
  PileOptions small_pile;
  small_pile.rows = 5;
  std::vector<std::unique_ptr<Scenario>> scenarios;
  scenarios.push_back(std::make_unique<CubesScenario>());
  scenarios.push_back(std::make_unique<CliffScenario>());
  scenarios.push_back(std::make_unique<RoomScenario>());
  scenarios.push_back(std::make_unique<PianoScenario>());
  scenarios.push_back(std::make_unique<TennisScenario>());
  scenarios.push_back(std::make_unique<PileScenario>(small_pile));
  for (const auto& scenario : scenarios) {
    for (const Scheme scheme : {Scheme::OnePass, Scheme::TwoStepPaper}) {
      // The tennis players serve, and the piano is grasped, within the first two seconds.
      DemoOptions options = quiet(3, scenario->name() == "cliff" ? 0.7 : 2.5);
      options.scheme = scheme;
      check_replays(*scenario, options);
    }
  }
}

TEST_CASE("trace: a replay is bit-exact with what else a transport may say", "[demos][golden]") {
  const CubesScenario scenario(kSmall);
  DemoOptions options = quiet(4, 3.0);
  options.peers = 3;
  options.rates = {60.0, 72.0};
  options.loss = 0.1;
  options.duplicate = 0.1;
  options.reorder = 0.1;
  options.max_state_bytes = 502;
  check_replays(scenario, options);
  options.compact = true;
  options.budget = 40.0;
  options.bandwidth = 30e3;
  options.tolerance = 1e-3;
  check_replays(scenario, options);
  options.timeline = Timeline::None;
  options.clock_spread = 0.25;
  check_replays(scenario, options);
  options = quiet(2, 2.0);
  options.mode = consensus::InputMode::Hard;
  options.ablation.leave_out(Part::Velocities);
  check_replays(scenario, options);
}

TEST_CASE("trace: a replay of a peer on Bullet is bit-exact", "[demos][golden]") {
  if (!has_bullet()) {
    WARN("skipped: built without Bullet (TANDEM_BULLET_PEER)");
    return;
  }
  DemoOptions options = quiet(3, 2.5);
  options.engines = {Engine::Tandem, Engine::Bullet};
  options.rates = {60.0, 72.0};
  check_replays(CubesScenario(), options);
}

TEST_CASE("trace: a replay follows a change of rules", "[demos][golden]") {
  const CubesScenario scenario(kSmall);
  const Folder folder;
  DemoOptions options = quiet(2, 3.0);
  options.trace = folder.file("trace");
  consensus::VirtualNetwork network(options.link_options(), 1, kVirtualStart);
  network.transport(1);
  network.transport(2);
  std::vector<std::unique_ptr<PeerTrace>> traces;
  std::vector<Actor> actors;
  for (std::size_t i = 0; i < 2; ++i) {
    traces.push_back(open_trace(scenario, options, i + 1, i, network.transport(i + 1), true));
    actors.emplace_back(scenario, options, i, traces[i]->transport());
    actors[i].participant().watch_steps_with(traces[i].get());
    actors[i].participant().add_user(i, user_options(options, i, kVirtualStart));
    // Forgets what users do, but not before it is told.
    if (i == 1) actors[i].participant().record_nothing();
  }
  DemoOptions others = options;
  others.scheme = Scheme::TwoStep;
  others.influence = 0.2;
  bool changed = false;
  while (true) {
    Actor& next = actors[next_actor(actors)];
    const consensus::SessionTime now = std::get<0>(next.next());
    if (now > kVirtualStart + 3'000'000'000) break;
    if (!changed && now > kVirtualStart + 2'000'000'000) {
      changed = true;
      for (Actor& actor : actors) actor.participant().change_rules(others);
    }
    network.advance_to(now);
    next.act();
  }
  for (const auto& trace : traces) trace->close();
  for (std::size_t i = 0; i < 2; ++i) {
    const Bytes trace = read_bytes(options.trace + '.' + std::to_string(i + 1));
    const Replay again = replay(scenario, trace);
    if (again.departure) UNSCOPED_INFO(to_text(*again.departure, ""));
    CHECK_FALSE(again.departure);
    CHECK(again.hash == actors[i].participant().scene().world->hash());
    const std::vector<TraceRecord> records = records_of(trace);
    const auto count = [&records](TraceKind kind) {
      return std::count_if(records.begin(), records.end(),
                           [kind](const auto& each) { return each.kind == kind; });
    };
    CHECK(count(TraceKind::Rules) == 1);
    CHECK(count(TraceKind::Inputs) > 0);
  }
}

TEST_CASE("trace: tracing changes nothing", "[demos][golden]") {
  const CubesScenario scenario(kSmall);
  const DemoOptions options = quiet(3, 2.0);
  const RunResult plain = run_virtual(scenario, options);
  const TracedRun traced = traced_run(scenario, options);
  for (std::size_t i = 0; i < 2; ++i) {
    CHECK(plain.peers[i].hash == traced.result.peers[i].hash);
    CHECK(plain.peers[i].bytes_sent == traced.result.peers[i].bytes_sent);
  }
}

/// A place in a packet, and the body whose position is there.
struct Place {
  std::size_t record = 0;
  std::size_t byte = 0;
  consensus::SharedId body;
};

/// Where a flip of one bit changes the position of one body and nothing else, by the codec's
/// account. The sender leads on it: nobody sleeps through that, nobody is deaf to it.
Place place_in_states(const std::vector<TraceRecord>& records) {
  for (std::size_t r = 0; r < records.size(); ++r) {
    if (records[r].kind != TraceKind::Packets) continue;
    const Bytes& packet = records[r].packets[0].bytes;
    consensus::DecodedPacket honest;
    if (!consensus::decode(packet, honest).ok()) continue;
    const auto led = std::find_if(
        honest.states.begin(), honest.states.end(),
        [](const auto& state) { return state.flags.leads && state.twist.linear.norm() > 0.05; });
    if (led == honest.states.end()) continue;
    const auto k = static_cast<std::size_t>(led - honest.states.begin());
    for (std::size_t byte = 0; byte < packet.size(); ++byte) {
      Bytes flipped = packet;
      flipped[byte] ^= std::byte{1};
      consensus::DecodedPacket other;
      if (!consensus::decode(flipped, other).ok()) continue;
      if (other.states.size() != honest.states.size()) continue;
      const pbd::Vec3 moved = other.states[k].pose.position - honest.states[k].pose.position;
      // Enough to outlive the rounding of what is made of it.
      if (moved.norm() > 1e-10 && moved.norm() < 1e-6) return {r, byte, honest.states[k].id};
    }
  }
  FAIL("nobody leads");
  return {};
}

TEST_CASE("trace: one bit of one packet is found at its step, stage and body", "[demos][fault]") {
  const CubesScenario scenario(kSmall);
  for (const Scheme scheme : {Scheme::OnePass, Scheme::TwoStep}) {
    DemoOptions options = quiet(3, 5.0);
    options.scheme = scheme;
    const Bytes trace = traced_run(scenario, options).traces[0];
    const std::vector<TraceRecord> records = records_of(trace);
    const Place place = place_in_states(records);
    const std::uint64_t step = step_of(records, place.record);
    const Bytes fault = altered(
        trace, [&](auto& all) { all[place.record].packets[0].bytes[place.byte] ^= std::byte{1}; });

    const std::optional<Departure> departure = replay(scenario, fault).departure;
    REQUIRE(departure);
    CHECK(departure->step == step);
    CHECK(departure->stage == "targets");
    REQUIRE(departure->body);
    CHECK(scenario.build({}).bodies[*departure->body].id == place.body);
    CHECK(departure->bodies == 1);

    TraceReader a(trace);
    TraceReader b(fault);
    const std::optional<Departure> difference = first_difference(a, b);
    REQUIRE(difference);
    CHECK(difference->step == step);
    CHECK(difference->stage == "packets");
    CHECK(difference->note.find("from peer 2, byte " + std::to_string(place.byte)) !=
          std::string::npos);
  }
}

TEST_CASE("trace: one bit of one input is found at its step, stage and body", "[demos][fault]") {
  const CubesScenario scenario(kSmall);
  const Bytes trace = traced_run(scenario, quiet(3, 3.0)).traces[0];
  const std::vector<TraceRecord> records = records_of(trace);
  const auto moves = [](const TraceRecord& record) {
    return record.kind == TraceKind::Inputs && record.inputs.size() == 3 &&
           record.inputs[1].kind == Input::Kind::Move;
  };
  const auto found = std::find_if(records.begin(), records.end(), moves);
  REQUIRE(found != records.end());
  const auto at = static_cast<std::size_t>(found - records.begin());
  const Bytes fault = altered(trace, [&](auto& all) {
    double& x = all[at].inputs[1].values[0];
    x = std::nextafter(x, 100.0);
  });
  const std::optional<Departure> departure = replay(scenario, fault).departure;
  REQUIRE(departure);
  CHECK(departure->step == step_of(records, at));
  CHECK(departure->stage == "targets");
  CHECK(departure->body == found->inputs[1].body);
  CHECK(departure->bodies == 1);

  TraceReader a(trace);
  TraceReader b(fault);
  const std::optional<Departure> difference = first_difference(a, b);
  REQUIRE(difference);
  CHECK(difference->stage == "inputs");
  CHECK(difference->body == found->inputs[1].body);
}

TEST_CASE("trace: where programs compute other things, a diff tells step, stage and body",
          "[demos][fault]") {
  const CubesScenario scenario(kSmall);
  const Bytes trace = traced_run(scenario, quiet(3, 1.0)).traces[1];
  const std::vector<TraceRecord> records = records_of(trace);
  std::vector<std::size_t> solved;
  for (std::size_t i = 0; i < records.size(); ++i) {
    if (records[i].kind == TraceKind::Solved) solved.push_back(i);
  }
  const auto difference = [&](const std::function<void(TraceRecord&)>& alter) {
    const Bytes other = altered(trace, [&](auto& all) { alter(all[solved[40]]); });
    TraceReader a(trace);
    TraceReader b(other);
    return first_difference(a, b).value();
  };
  const Departure poses = difference([](TraceRecord& record) { record.poses.bodies[3] ^= 1; });
  CHECK(poses.step == 40);
  CHECK(poses.stage == "poses");
  CHECK(poses.body == 3u);
  const Departure targets = difference([](TraceRecord& record) {
    record.targets.bodies[4] ^= 1;
    record.poses.bodies[3] ^= 1;
  });
  CHECK(targets.stage == "targets");
  CHECK(targets.body == 4u);
  // And the replay says the same of a program that does not compute what is in the file.
  const Bytes other = altered(trace, [&](auto& all) { all[solved[40]].poses.bodies[3] ^= 1; });
  const std::optional<Departure> departure = replay(scenario, other).departure;
  REQUIRE(departure);
  CHECK(departure->step == 40);
  CHECK(departure->stage == "poses");
  CHECK(departure->body == 3u);
  // The same run twice is the same.
  TraceReader a(trace);
  TraceReader b(trace);
  CHECK_FALSE(first_difference(a, b));
}

TEST_CASE("trace: two peers' copies are as far apart in their replays as they were in the run",
          "[demos][unit]") {
  const CubesScenario scenario(kSmall);
  const TracedRun run = traced_run(scenario, quiet(5, 3.0));
  // By the tracks of the run itself.
  const PeerRecord& one = run.result.peers[0];
  const PeerRecord& two = run.result.peers[1];
  double furthest = 0.0;
  std::size_t body = 0;
  for (std::size_t i = 0; i < one.tracks.size(); ++i) {
    // The first sample is of the beginning, before any step.
    const std::span here = std::span(one.tracks[i].samples()).subspan(1);
    const std::span there = std::span(two.tracks[i].samples()).subspan(1);
    for (const TrackSample& sample : here) {
      const auto after =
          std::find_if(there.begin(), there.end(),
                       [&sample](const TrackSample& each) { return each.time >= sample.time; });
      if (after == there.begin() || after == there.end()) continue;
      const TrackSample& before = *(after - 1);
      const double part = static_cast<double>(sample.time - before.time) /
                          static_cast<double>(after->time - before.time);
      const pbd::Vec3 position = (1.0 - part) * before.position + part * after->position;
      const double distance = (position - sample.position).norm();
      if (distance > furthest) body = i;
      furthest = std::max(furthest, distance);
    }
  }
  const TwoViews views = compare_views(scenario, run.traces[0], run.traces[1], 0.5 * furthest);
  CHECK_FALSE(views.a);
  CHECK_FALSE(views.b);
  REQUIRE(views.furthest);
  CHECK(views.furthest->distance == Approx(furthest).epsilon(1e-9));
  CHECK(views.furthest->body == body);
  REQUIRE(views.beyond);
  CHECK(views.beyond->distance > 0.5 * furthest);
  CHECK(views.beyond->time <= views.furthest->time);
  CHECK_FALSE(compare_views(scenario, run.traces[0], run.traces[1], 1.1 * furthest).beyond);
}

TEST_CASE("trace: a file that was cut off anywhere is replayed as far as it goes",
          "[demos][fault]") {
  const CubesScenario scenario(kSmall);
  const Bytes trace = traced_run(scenario, quiet(3, 0.4)).traces[0];
  std::size_t header = 0;
  std::uint64_t steps = 0;
  for (std::size_t length = 0; length < trace.size(); ++length) {
    const Bytes cut(trace.begin(), trace.begin() + static_cast<std::ptrdiff_t>(length));
    try {
      TraceReader reader(cut);
      for (TraceRecord record; reader.next(record);) {
      }
      CHECK_FALSE(reader.complete());
      CHECK(reader.steps() >= steps);
      steps = reader.steps();
    } catch (const TraceError&) {
      CHECK(steps == 0);
      header = length;
    }
  }
  CHECK(header < 400);
  CHECK(steps == records_of(trace).back().steps);
  // As a crash within the 20th step leaves it: what the step was told is there, its hashes not.
  const std::vector<TraceRecord> records = records_of(trace);
  std::vector<TraceRecord> until;
  for (std::size_t i = 0; step_of(records, i) < 20; ++i) until.push_back(records[i]);
  until.pop_back();
  const Replay again = replay(scenario, bytes_of(TraceReader(trace).header(), until));
  CHECK_FALSE(again.departure);
  CHECK(again.steps == 20);
}

TEST_CASE("trace: what is no trace is refused by offset and rule", "[demos][fault]") {
  const CubesScenario scenario(kSmall);
  const Bytes trace = traced_run(scenario, quiet(3, 0.2)).traces[0];
  const auto refusal = [](const Bytes& bytes) -> std::string {
    try {
      records_of(bytes);
    } catch (const TraceError& error) {
      return error.what();
    }
    return {};
  };
  CHECK(refusal(trace).empty());
  CHECK(refusal({}).find("offset 0: file breaks") == 0);
  Bytes bad = trace;
  bad[3] ^= std::byte{1};
  CHECK(refusal(bad).find("offset 0: magic breaks") == 0);
  bad = trace;
  bad[8] = std::byte{77};
  CHECK(refusal(bad).find("version = 77 breaks") != std::string::npos);
  // A bit that no rule minds is found by the checksum.
  bad = altered(trace, [](auto& all) { all.pop_back(); });
  const std::size_t last = bad.size() - 1;
  bad = trace;
  bad[last] ^= std::byte{0x10};
  CHECK(refusal(bad).find("checksum breaks") != std::string::npos);
  // Order.
  const auto swap_first = [&](TraceKind kind) {
    return altered(trace, [kind](auto& all) {
      const auto at = std::find_if(all.begin(), all.end(),
                                   [kind](const auto& each) { return each.kind == kind; });
      REQUIRE(at != all.end());
      all.erase(at);
    });
  };
  for (const TraceKind kind :
       {TraceKind::Begin, TraceKind::Step, TraceKind::Solved, TraceKind::Finish, TraceKind::Sent}) {
    CHECK(refusal(swap_first(kind)).find("record breaks: in its order") != std::string::npos);
  }
  // Another scene.
  const CubesScenario other;
  CHECK_THROWS_AS(Replayer(other, trace), std::invalid_argument);
}

TEST_CASE("trace: mutated traces are replayed or refused, and nothing else happens",
          "[demos][fault]") {
  const CubesScenario scenario(kSmall);
  DemoOptions options = quiet(3, 0.3);
  const Bytes trace = traced_run(scenario, options).traces[1];
  const std::vector<TraceRecord> records = records_of(trace);
  std::uint64_t state = 1;
  const auto below = [&state](std::size_t limit) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    return static_cast<std::size_t>(state >> 33) % limit;
  };
  std::size_t departed = 0;
  std::size_t refused = 0;
  for (int i = 0; i < 150; ++i) {
    Bytes bad = trace;
    for (std::size_t k = 0; k <= below(3); ++k) bad[below(bad.size())] = std::byte(below(256));
    if (below(4) == 0) bad.resize(below(bad.size()));
    try {
      departed += replay(scenario, bad).departure ? 1 : 0;
    } catch (const TraceError&) {
      ++refused;
    } catch (const std::invalid_argument&) {  // options, or the scene
      ++refused;
    }
  }
  CHECK(departed > 10);
  CHECK(refused > 10);
}

/// Values other than the default one for all that a run has.
struct Sample {
  std::string_view name;
  std::string_view value;  ///< "" = it takes none
};
constexpr Sample kVirtual[] = {{"--peers", "3"},
                               {"--profile", "5"},
                               {"--loss", "0.1"},
                               {"--duplicate", "0.2"},
                               {"--reorder", "0.30000000000000004"},
                               {"--bandwidth", "1500"},
                               {"--max-state", "502"},
                               {"--clock-spread", "0.25"},
                               {"--clock", "none"}};
constexpr Sample kEverywhere[] = {{"--seconds", "7.5"},
                                  {"--seed", "77"},
                                  {"--influence", "0.123456789012345"},
                                  {"--coupling", "two-step-paper"},
                                  {"--pd-frequency", "0.7"},
                                  {"--mode", "asymmetric"},
                                  {"--predictor", "kalman"},
                                  {"--extrapolation", "0.4"},
                                  {"--spring-extrapolation", "0.2"},
                                  {"--damped-start", "0.6"},
                                  {"--modelled-error", "0.01"},
                                  {"--sleeping-threshold", ""},
                                  {"--compact", ""},
                                  {"--budget", "64"},
                                  {"--tolerance", "0.001"},
                                  {"--update-hz", "30"},
                                  {"--rates", "60,72.5"},
                                  {"--engines", "tandem,tandem"},
                                  {"--bullet-iterations", "20"},
                                  {"--substeps", "7"},
                                  {"--iterations", "2"},
                                  {"--total-iterations", "3"},
                                  {"--ablate", "masses,refine"},
                                  {"--variant", "soft"}};
/// What says where results go, who is met and how, or what another option says.
constexpr std::string_view kOthers[] = {
    "--transport", "--view",    "--view-address", "--no-script", "--listen",
    "--connect",   "--peer-id", "--key",          "--insecure",  "--clock",
    "--wait",      "--uneven",  "--replay",       "--json",      "--csv",
    "--record",    "--trace",   "--quiet",        "--help",      "--reference"};

TEST_CASE("trace: the words of a run's options are read back as the same options",
          "[demos][unit]") {
  std::vector<std::string_view> words;
  const auto add = [&words](const Sample& sample) {
    words.push_back(sample.name);
    if (!sample.value.empty()) words.push_back(sample.value);
  };
  for (const Sample& sample : kVirtual) add(sample);
  for (const Sample& sample : kEverywhere) add(sample);
  const std::vector<std::string> written = run_arguments(parse_options(words));
  std::vector<std::string> expected(words.begin(), words.end());
  auto sorted = written;
  std::sort(sorted.begin(), sorted.end());
  std::sort(expected.begin(), expected.end());
  CHECK(sorted == expected);
  const std::vector<std::string_view> again(written.begin(), written.end());
  CHECK(run_arguments(parse_options(again)) == written);
  CHECK(run_arguments(DemoOptions{}).empty());

  const std::vector<std::string_view> network{"--connect", "localhost:7", "--peer-id", "4",
                                              "--key",     "secret",      "--budget",  "64"};
  CHECK(
      run_arguments(parse_options(network)) ==
      std::vector<std::string>{"--listen", "0", "--peer-id", "4", "--insecure", "--budget", "64"});

  // Who adds an option says whether a run depends on it.
  const std::string help = usage("cubes");
  for (std::size_t at = help.find("  --"); at != std::string::npos; at = help.find(" --", at + 3)) {
    const std::size_t begin = help.find("--", at);
    const std::string name = help.substr(begin, help.find_first_of(" ,:;)|\n", begin) - begin);
    const auto is = [&name](const Sample& sample) { return sample.name == name; };
    INFO(name);
    CHECK((std::any_of(std::begin(kVirtual), std::end(kVirtual), is) ||
           std::any_of(std::begin(kEverywhere), std::end(kEverywhere), is) ||
           std::find(std::begin(kOthers), std::end(kOthers), name) != std::end(kOthers)));
  }
}

}  // namespace
}  // namespace tandem::demos::trace_test
