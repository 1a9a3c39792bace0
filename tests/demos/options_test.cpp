// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "session/options.h"

#include <string>
#include <string_view>
#include <vector>

#include "support/catch.h"

namespace tandem::demos::options_test {
namespace {

DemoOptions parse(const std::vector<std::string_view>& arguments) {
  return parse_options(arguments);
}

/// The message of the refusal; empty where there was none.
std::string refusal(const std::vector<std::string_view>& arguments) {
  try {
    parse_options(arguments);
  } catch (const UsageError& error) {
    return error.what();
  }
  return {};
}

TEST_CASE("options: nothing given is a virtual run of two peers", "[demos][unit]") {
  const DemoOptions o = parse({});
  CHECK_FALSE(o.over_network());
  CHECK(o.peers == 2);
  CHECK(o.seconds == 20.0);
  CHECK(o.influence >= 0.05);  // the baseline's range, 5 to 10 %
  CHECK(o.influence <= 0.10);
  CHECK(o.scheme == Scheme::OnePass);
  CHECK(o.predictor_kind() == consensus::PredictorKind::Replay);
}

TEST_CASE("options: what a run does without reaches solver and peer", "[demos][unit]") {
  CHECK_FALSE(parse({}).ablation.any());
  const std::string help = usage("cubes");
  for (std::size_t i = 0; i < kParts; ++i) {
    const std::string_view name = to_string(static_cast<Part>(i));
    CAPTURE(name);
    CHECK(help.find(name) != std::string::npos);
    CHECK(parse({"--ablate", name}).ablation.lacks(static_cast<Part>(i)));
  }
  const DemoOptions o = parse({"--ablate", "refine,age", "--substeps", "7"});
  CHECK_FALSE(o.solver_options().refine);
  CHECK(o.solver_options().substeps == 7);
  CHECK(o.peer_options().influence.half_life > 1e3);
  CHECK(o.peer_options().initiative);
  CHECK_FALSE(refusal({"--ablate", "ramp,nonsense"}).empty());
}

TEST_CASE("options: every option reaches its field, in both spellings", "[demos][unit]") {
  const DemoOptions o = parse({"--peers",
                               "3",
                               "--seconds=4.5",
                               "--seed",
                               "9",
                               "--influence",
                               "0",
                               "--predictor",
                               "euler",
                               "--solver=two-step",
                               "--update-hz",
                               "30",
                               "--profile",
                               "5",
                               "--uneven",
                               "--loss",
                               "0.1",
                               "--duplicate",
                               "0.2",
                               "--reorder",
                               "0.3",
                               "--bandwidth",
                               "1e6",
                               "--json",
                               "-",
                               "--compact",
                               "--budget",
                               "256",
                               "--tolerance=0.002",
                               "--max-state",
                               "502",
                               "--csv",
                               "out",
                               "--quiet",
                               "--help"});
  CHECK(o.peers == 3);
  CHECK(o.seconds == 4.5);
  CHECK(o.seed == 9);
  CHECK(o.influence == 0.0);
  CHECK(o.peer_options().influence.held_alone == 0.0);  // not even of who holds a body alone
  CHECK(o.predictor == consensus::PredictorKind::Euler);
  CHECK(o.scheme == Scheme::TwoStep);
  CHECK(o.update_hz == 30.0);
  CHECK(o.profile == 5);
  CHECK(o.step_hz(0) == 60.0);
  CHECK(o.step_hz(1) == 72.0);
  CHECK(o.json == "-");
  CHECK(o.csv == "out");
  CHECK(o.quiet);
  CHECK(o.help);
  CHECK(o.link_options().loss == 0.1);
  CHECK(o.link_options().duplicate == 0.2);
  CHECK(o.link_options().reorder == 0.3);
  CHECK(o.link_options().bandwidth == 1e6);
  CHECK(o.link_options().latency == 0.1235);  // profile 5
  CHECK(o.link_options().max_state_bytes == 502);
  CHECK(o.peer_options().sending.format == consensus::StateFormat::Compact);
  CHECK(o.peer_options().sending.kbit_per_s == 256.0);
  CHECK(o.peer_options().sending.tolerance == 0.002);
  CHECK(o.peer_options().update_hz == 30.0);
  CHECK(o.peer_options().coupling == consensus::Coupling::TwoStep);
}

TEST_CASE("options: modes, predictors and rules reach the peer", "[demos][unit]") {
  const consensus::PeerOptions plain = parse({}).peer_options();
  CHECK(plain.mode == consensus::InputMode::Soft);
  const DemoOptions o = parse({"--mode", "hard", "--predictor=second-order", "--extrapolation",
                               "0.2", "--spring-extrapolation=0"});
  const consensus::PeerOptions peer = o.peer_options();
  CHECK(peer.mode == consensus::InputMode::Hard);
  CHECK(peer.predictor == consensus::PredictorKind::SecondOrder);
  CHECK(peer.prediction.max_extrapolation == 0.2);
  CHECK(peer.max_anchor_extrapolation == 0.0);
  for (const char* name : {"none", "euler", "second-order", "replay"}) {
    CHECK(to_string(parse({"--predictor", name}).predictor_kind()) == name);
  }
  for (const char* name : {"soft", "asymmetric", "hard"}) {
    CHECK(to_string(parse({"--mode", name}).mode) == name);
  }
}

TEST_CASE("options: what a replay does reaches the peer, and what it cannot do is refused",
          "[demos][unit]") {
  const consensus::ReplayOptions usual = parse({}).peer_options().replay;
  CHECK(usual.share == consensus::ReplayOptions{}.share);
  CHECK(usual.inputs == consensus::ReplayOptions{}.inputs);
  CHECK(usual.budget == consensus::ReplayOptions{}.budget);
  CHECK(usual.substeps == consensus::ReplayOptions{}.substeps);
  const consensus::ReplayOptions replay =
      parse({"--closing-share", "0.3", "--inputs=common", "--replay-budget", "2.5",
             "--replay-substeps", "3"})
          .peer_options()
          .replay;
  CHECK(replay.share == 0.3);
  CHECK(replay.inputs == consensus::ReplayInputs::Common);
  CHECK(replay.budget == 2.5);
  CHECK(replay.substeps == 3);
  CHECK(parse({"--inputs", "known"}).replayed.inputs == consensus::ReplayInputs::Known);
  // Whatever is accepted here is accepted by the peer.
  for (const auto& words :
       std::vector<std::vector<std::string_view>>{{"--closing-share", "1"},
                                                  {"--closing-share", "0.001"},
                                                  {"--replay-budget", "1"},
                                                  {"--replay-budget", "1000"},
                                                  {"--replay-substeps", "1000"}}) {
    CHECK_NOTHROW(parse(words).peer_options().validate());
  }
  for (const auto& words :
       std::vector<std::vector<std::string_view>>{{"--closing-share", "0"},
                                                  {"--closing-share", "1.1"},
                                                  {"--closing-share", "nan"},
                                                  {"--replay-budget", "0.9"},
                                                  {"--replay-budget", "inf"},
                                                  {"--replay-substeps", "-1"},
                                                  {"--replay-substeps", "1001"},
                                                  {"--replay-substeps", "1.5"}}) {
    CAPTURE(words[0], words[1]);
    CHECK_FALSE(refusal(words).empty());
  }
  CHECK(refusal({"--inputs", "both"}) == "--inputs = both breaks: known or common");
}

TEST_CASE("options: couplings that are compared differ in what they say and in nothing else",
          "[demos][unit]") {
  using consensus::Coupling;
  using consensus::PredictorKind;
  const auto of = [](std::string_view name) { return parse({"--coupling", name}).peer_options(); };
  for (const char* name : {"one-pass", "one-pass-plain", "two-step-paper", "two-step-plain",
                           "two-step", "none", "single-owner", "pd"}) {
    CHECK(to_string(parse({"--coupling", name}).scheme) == name);
    CHECK(parse({"--solver", name}).scheme == parse({"--coupling", name}).scheme);
  }
  CHECK(of("one-pass").coupling == Coupling::OnePass);
  const consensus::PeerOptions two_step = of("two-step");
  CHECK(two_step.coupling == Coupling::TwoStep);
  CHECK(two_step.predictor == of("one-pass").predictor);
  CHECK(two_step.influence.limits_guesses);
  CHECK(two_step.initiative);
  CHECK_FALSE(two_step.two_step_thresholds);
  for (const char* name : {"two-step-paper", "two-step-plain"}) {
    const consensus::PeerOptions paper = of(name);
    CHECK(paper.coupling == Coupling::TwoStep);
    CHECK(paper.predictor == PredictorKind::Euler);
    CHECK_FALSE(paper.prediction.extrapolates_orientation);
    CHECK_FALSE(paper.initiative);
    CHECK(paper.authority_ramp == 0.0);
    CHECK_FALSE(paper.influence.limits_guesses);
    CHECK(paper.two_step_thresholds == (std::string_view(name) == "two-step-paper"));
  }
  CHECK(of("one-pass-plain").coupling == Coupling::OnePass);
  CHECK(of("one-pass-plain").predictor == PredictorKind::Euler);
  CHECK_FALSE(of("one-pass-plain").initiative);
  CHECK(of("none").coupling == Coupling::None);
  CHECK(of("single-owner").coupling == Coupling::SingleOwner);
  CHECK(of("single-owner").predictor == PredictorKind::Euler);
  CHECK(of("pd").predictor == PredictorKind::Euler);
  CHECK(parse({"--pd-frequency", "2"}).pd_frequency == 2.0);
  // What is said counts.
  CHECK(parse({"--coupling=pd", "--predictor", "second-order"}).peer_options().predictor ==
        PredictorKind::SecondOrder);
}

TEST_CASE("options: rates go round the peers", "[demos][unit]") {
  const DemoOptions o =
      parse({"--rates", "60,72,90.5", "--variant", "mouse", "--record", "a", "--replay=b"});
  CHECK(o.rates == std::vector<double>{60.0, 72.0, 90.5});
  CHECK(o.step_hz(1) == 72.0);
  CHECK(o.step_hz(3) == 60.0);
  CHECK(o.variant == "mouse");
  CHECK(o.record == "a");
  CHECK(o.replay == "b");
  for (const char* bad : {"", "60,", "60,,72", "5", "nan"}) {
    CHECK_FALSE(refusal({"--rates", bad}).empty());
  }
}

TEST_CASE("options: who listens is peer 1, who connects peer 2, unless told", "[demos][unit]") {
  CHECK(parse({"--listen", "4000"}).peer_id == 1);
  CHECK(parse({"--listen", "4000"}).over_network());
  CHECK(parse({"--connect", "localhost:4000"}).peer_id == 2);
  CHECK(parse({"--listen", "4001", "--connect", "[::1]:4000"}).peer_id == 2);
  const DemoOptions o =
      parse({"--connect", "a:1", "--connect", "b:65535", "--peer-id", "7", "--wait", "3"});
  CHECK(o.peer_id == 7);
  CHECK(o.wait == 3.0);
  CHECK(o.connect == std::vector<std::string>{"a:1", "b:65535"});
}

TEST_CASE("options: a key or --insecure ask for UDP", "[demos][unit]") {
  CHECK_FALSE(parse({"--listen", "1"}).udp());
  const DemoOptions o = parse({"--listen", "1", "--key", "k", "--budget", "256"});
  CHECK(o.udp());
  CHECK(o.key == "k");
  CHECK(o.budget == 256.0);
  CHECK(o.timeline == Timeline::Session);
  CHECK(parse({"--listen", "1", "--clock", "system"}).timeline == Timeline::System);
  CHECK(refusal({"--listen", "1", "--clock", "gps"}) ==
        "--clock = gps breaks: session, system or none");
  CHECK(refusal({"--clock", "system"}) == "--clock = given breaks: needs --listen or --connect");
  CHECK(refusal({"--listen", "1", "--clock", "none"}) ==
        "--clock = none breaks: over a network needs --key or --insecure");
  CHECK(parse({"--listen", "1", "--key", "k", "--clock", "none"}).peer_options().dating ==
        consensus::Dating::Receipt);
  CHECK(parse({"--clock", "none"}).peer_options().dating == consensus::Dating::Receipt);
  CHECK(parse({"--clock-spread", "3"}).peer_options().dating == consensus::Dating::Stamp);
  CHECK(parse({"--connect", "localhost:1", "--insecure"}).udp());
  CHECK(refusal({"--listen", "1", "--key", "k", "--insecure"}) ==
        "--insecure = given breaks: has no meaning with --key");
  CHECK_FALSE(parse({"--listen", "1", "--key", "k", "--transport", "tcp"}).udp());
  CHECK_FALSE(parse({"--listen", "1", "--insecure", "--transport", "tcp"}).udp());
  CHECK(parse({"--listen", "1", "--key", "k", "--transport", "udp"}).udp());
  CHECK(refusal({"--listen", "1", "--transport", "udp"}) ==
        "--transport = udp breaks: needs --key or --insecure");
  CHECK(refusal({"--listen", "1", "--transport", "quic"}) ==
        "--transport = quic breaks: tcp or udp");
  CHECK(refusal({"--insecure"}) == "--insecure = given breaks: needs --listen or --connect");
  CHECK(refusal({"--listen", "1", "--budget", "7"}) ==
        "--budget = 7 breaks: kbit/s, 0 or a number from 8 to 1e6");
}

TEST_CASE("options: a refusal names option, value and rule", "[demos][fault]") {
  CHECK(refusal({"--profile", "6"}) == "--profile = 6 breaks: an integer from 0 to 5");
  CHECK(refusal({"--profile", "2.5"}) == "--profile = 2.5 breaks: an integer from 0 to 5");
  CHECK(refusal({"--seconds", "nan"}) == "--seconds = nan breaks: a number from 0.1 to 86400");
  CHECK(refusal({"--seconds", "inf"}) == "--seconds = inf breaks: a number from 0.1 to 86400");
  CHECK(refusal({"--seconds"}) == "--seconds =  breaks: needs a value");
  CHECK(refusal({"--seed", "-1"}) == "--seed = -1 breaks: an integer of 64 bits, >= 0");
  CHECK(refusal({"--influence", "1"}) == "--influence = 1 breaks: a number from 0 to 0.99");
  CHECK(refusal({"--predictor", "Euler"}) ==
        "--predictor = Euler breaks: none, euler, second-order or replay");
  CHECK(refusal({"--solver", ""}) ==
        "--solver =  breaks: one-pass, one-pass-plain, two-step-paper, two-step-plain, two-step, "
        "none, single-owner or pd");
  CHECK(refusal({"--listen", "65536"}) == "--listen = 65536 breaks: a port from 0 (any) to 65535");
  for (const char* bad : {"host", "host:", ":80", "host:0", "host:65536", "host:8x"}) {
    CHECK(refusal({"--connect", bad}) ==
          "--connect = " + std::string(bad) + " breaks: HOST:PORT, port 1 to 65535");
  }
  CHECK(refusal({"--bogus"}) == "option = --bogus breaks: must be one of those that --help lists");
  CHECK(refusal({"7"}) == "argument = 7 breaks: options begin with --");
  CHECK(refusal({"--quiet=yes"}) == "--quiet = yes breaks: takes no value");
  CHECK(refusal({"--json="}) == "--json =  breaks: must not be empty");
}

TEST_CASE("options: what has no meaning together is refused", "[demos][fault]") {
  CHECK(refusal({"--listen", "1", "--profile", "2"}) ==
        "--profile = given breaks: has no meaning with --listen or --connect");
  CHECK(refusal({"--peers", "2", "--connect", "a:1"}) ==
        "--peers = given breaks: has no meaning with --listen or --connect");
  CHECK(refusal({"--peer-id", "2"}) == "--peer-id = given breaks: needs --listen or --connect");
  CHECK(refusal({"--listen", "1", "--uneven", "--seconds", "3"}).empty());
}

TEST_CASE("options: a page has any port where none is given, and no end but a given one",
          "[demos][unit]") {
  CHECK_FALSE(parse({}).view);
  CHECK(parse({"--view"}).view == std::uint16_t{0});
  CHECK(parse({"--view", "--quiet"}).view == std::uint16_t{0});
  CHECK(parse({"--view", "8080"}).view == std::uint16_t{8080});
  CHECK(parse({"--view=8080", "--no-script"}).no_script);
  CHECK(parse({"--view"}).endless);
  CHECK_FALSE(parse({"--seconds", "5", "--view"}).endless);
  CHECK_FALSE(parse({"--no-script"}).endless);
  CHECK(refusal({"--view", "65536"}) == "--view = 65536 breaks: a port from 0 (any) to 65535");
  CHECK(refusal({"--view", "here"}) == "--view = here breaks: a port from 0 (any) to 65535");
  CHECK(refusal({"--view", "--json", "-"}) == "--json = - breaks: with --view needs --seconds");
  CHECK(refusal({"--view", "--json", "-", "--seconds", "5"}).empty());
}

}  // namespace
}  // namespace tandem::demos::options_test
