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

TEST_CASE("options: ablated parts reach the peer", "[demos][unit]") {
  CHECK_FALSE(parse({}).ablation.any());
  const std::string help = usage_of_all("cubes");
  for (std::size_t i = 0; i < kParts; ++i) {
    const std::string_view name = to_string(static_cast<Part>(i));
    CAPTURE(name);
    CHECK(help.find(name) != std::string::npos);
    CHECK(parse({"--ablate", name}).ablation.lacks(static_cast<Part>(i)));
  }
  const DemoOptions o = parse({"--ablate", "velocities,leading", "--substeps", "7"});
  CHECK(o.solver.substeps == 7);
  CHECK(o.peer_options().influence.leading == 0.0);
  CHECK(o.peer_options().initiative);
  CHECK_FALSE(refusal({"--ablate", "leading,nonsense"}).empty());
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
                               "--coupling=two-step",
                               "--profile",
                               "5",
                               "--rates",
                               "60,72",
                               "--link",
                               "loss=0.1,duplicate=0.2,reorder=0.3,bandwidth=1e6",
                               "--link=max-state=502",
                               "--json",
                               "-",
                               "--send",
                               "compact,budget=256,hz=30,tolerance=0.002,near=4",
                               "--iterations",
                               "2,20",
                               "--csv",
                               "out",
                               "--print",
                               "nothing"});
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
  CHECK(o.quiet());
  CHECK(o.solver.position_iterations == 2);
  CHECK(o.bullet_iterations == 20);
  CHECK(o.link_options().loss == 0.1);
  CHECK(o.link_options().duplicate == 0.2);
  CHECK(o.link_options().reorder == 0.3);
  CHECK(o.link_options().bandwidth == 1e6);
  CHECK(o.link_options().latency == 0.1235);  // profile 5
  CHECK(o.link_options().max_state_bytes == 502);
  CHECK(o.peer_options().sending.format == consensus::StateFormat::Compact);
  CHECK(o.peer_options().sending.kbit_per_s == 256.0);
  CHECK(o.peer_options().sending.tolerance == 0.002);
  CHECK(o.interest_radius == 4.0);
  CHECK(o.peer_options().update_hz == 30.0);
  CHECK(o.peer_options().coupling == consensus::Coupling::TwoStep);
}

TEST_CASE("options: the run to compare with", "[demos][unit]") {
  CHECK_FALSE(parse({}).beside);
  CHECK_FALSE(parse({}).alone);
  CHECK_FALSE(parse({"--coupling", "none"}).beside);
  const DemoOptions two = parse({"--coupling", "two-step-paper,single-owner"});
  CHECK(two.scheme == Scheme::TwoStepPaper);
  CHECK(two.beside == Scheme::SingleOwner);
  CHECK_FALSE(two.alone);
  CHECK(parse({"--coupling", "one-pass,nothing"}).alone);
  CHECK_FALSE(parse({"--coupling", "one-pass,none", "--coupling", "two-step"}).beside);
  CHECK(refusal({"--coupling", "one-pass,nobody"}).find("--coupling must be one-pass, ") == 0);
  CHECK(refusal({"--coupling", "nothing"}).find("--coupling must be one-pass, ") == 0);
  CHECK(refusal({"--coupling", "none,none,none"}) ==
        "--coupling must be A, or A,B to show it beside B, is 'none,none,none'");
  CHECK(refusal({"--coupling", "one-pass,none", "--view"}) ==
        "--coupling A,B has no meaning with --view");
  CHECK(refusal({"--coupling", "one-pass,none", "--listen", "0"}) ==
        "--coupling A,B has no meaning with --listen or --connect");
}

TEST_CASE("options: the amount of text on the terminal", "[demos][unit]") {
  CHECK(parse({}).print == Print::Story);
  CHECK(parse({"--print", "story"}).print == Print::Story);
  CHECK(parse({"--print", "details"}).print == Print::Details);
  CHECK(parse({"--print=nothing"}).quiet());
  CHECK(refusal({"--print", "all"}) == "--print must be nothing, story or details, is 'all'");
}

TEST_CASE("options: modes, predictors and rules reach the peer", "[demos][unit]") {
  const consensus::PeerOptions plain = parse({}).peer_options();
  CHECK(plain.mode == consensus::InputMode::Soft);
  const DemoOptions o = parse({"--mode", "hard", "--predictor=euler"});
  const consensus::PeerOptions peer = o.peer_options();
  CHECK(peer.mode == consensus::InputMode::Hard);
  CHECK(peer.predictor == consensus::PredictorKind::Euler);
  for (const char* name : {"none", "euler", "replay"}) {
    CHECK(to_string(parse({"--predictor", name}).predictor_kind()) == name);
  }
  for (const char* name : {"soft", "asymmetric", "hard"}) {
    CHECK(to_string(parse({"--mode", name}).mode) == name);
  }
}

TEST_CASE("options: settings of replays reach the peer, and others are refused", "[demos][unit]") {
  CHECK(parse({}).peer_options().replay.share == consensus::ReplayOptions{}.share);
  const auto asked =
      parse({"--agreement", "share=0.3,budget=7,inputs=common"}).peer_options().replay;
  CHECK(asked.share == 0.3);
  CHECK(asked.budget == 7.0);
  CHECK(asked.inputs == consensus::ReplayInputs::Common);
  // Whatever is accepted here is accepted by the peer.
  for (const char* good : {"share=1", "share=0.001", "budget=1", "budget=1000"}) {
    CHECK_NOTHROW(parse({"--agreement", good}).peer_options().validate());
  }
  for (const char* bad : {"share=0", "share=1.1", "share=nan", "budget=0.9", "inputs=mine"}) {
    CAPTURE(bad);
    CHECK_FALSE(refusal({"--agreement", bad}).empty());
  }
}

TEST_CASE("options: compared couplings differ in their own settings alone", "[demos][unit]") {
  using consensus::Coupling;
  using consensus::PredictorKind;
  const auto of = [](std::string_view name) { return parse({"--coupling", name}).peer_options(); };
  for (const char* name : {"one-pass", "two-step-paper", "two-step", "none", "single-owner"}) {
    CHECK(to_string(parse({"--coupling", name}).scheme) == name);
  }
  CHECK(of("one-pass").coupling == Coupling::OnePass);
  const consensus::PeerOptions two_step = of("two-step");
  CHECK(two_step.coupling == Coupling::TwoStep);
  CHECK(two_step.predictor == of("one-pass").predictor);
  CHECK(two_step.influence.limits_guesses);
  CHECK(two_step.initiative);
  CHECK_FALSE(two_step.two_step_thresholds);
  const consensus::PeerOptions paper = of("two-step-paper");
  CHECK(paper.coupling == Coupling::TwoStep);
  CHECK(paper.predictor == PredictorKind::Euler);
  CHECK_FALSE(paper.prediction.extrapolates_orientation);
  CHECK_FALSE(paper.initiative);
  CHECK(paper.authority_ramp == 0.0);
  CHECK_FALSE(paper.influence.limits_guesses);
  CHECK(paper.two_step_thresholds);
  CHECK(of("none").coupling == Coupling::None);
  CHECK(of("single-owner").coupling == Coupling::SingleOwner);
  CHECK(of("single-owner").predictor == PredictorKind::Euler);
  // Explicit options count.
  CHECK(parse({"--coupling=two-step-paper", "--predictor", "none"}).peer_options().predictor ==
        PredictorKind::None);
}

TEST_CASE("options: rates go round the peers", "[demos][unit]") {
  const DemoOptions o =
      parse({"--rates", "60,72,90.5", "--variant", "mouse", "--record", "a", "--script=b"});
  CHECK(o.rates == std::vector<double>{60.0, 72.0, 90.5});
  CHECK(o.step_hz(1) == 72.0);
  CHECK(o.step_hz(3) == 60.0);
  CHECK(o.variant == "mouse");
  CHECK(o.record == "a");
  CHECK(o.replay == "b");
  CHECK_FALSE(o.no_script);
  for (const char* bad : {"", "60,", "60,,72", "5", "nan"}) {
    CHECK_FALSE(refusal({"--rates", bad}).empty());
  }
}

TEST_CASE("options: a listener is peer 1 and a caller peer 2 by default", "[demos][unit]") {
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

TEST_CASE("options: a key asks for UDP, which is on this machine alone without one",
          "[demos][unit]") {
  CHECK_FALSE(parse({"--listen", "1"}).udp());
  const DemoOptions o = parse({"--listen", "1", "--key", "k", "--send", "budget=256"});
  CHECK(o.udp());
  CHECK(o.key == "k");
  CHECK(o.budget == 256.0);
  CHECK(o.timeline == Timeline::Session);
  CHECK(parse({"--listen", "1", "--clock", "system"}).timeline == Timeline::System);
  CHECK(refusal({"--listen", "1", "--clock", "gps"}) ==
        "unknown item of --clock 'gps'; --help-all lists what there is");
  CHECK(refusal({"--clock", "system"}) == "--clock system needs --listen or --connect");
  CHECK(refusal({"--listen", "1", "--clock", "none"}) ==
        "--clock none needs --key or --transport udp over a network");
  CHECK(parse({"--listen", "1", "--key", "k", "--clock", "none"}).peer_options().timestamps ==
        consensus::TimestampSource::Arrival);
  CHECK(parse({"--clock", "none"}).peer_options().timestamps ==
        consensus::TimestampSource::Arrival);
  CHECK(parse({"--clock", "spread=3"}).peer_options().timestamps ==
        consensus::TimestampSource::Sender);
  CHECK(parse({"--connect", "localhost:1", "--transport", "udp"}).insecure);
  CHECK_FALSE(parse({"--listen", "1", "--key", "k", "--transport", "tcp"}).udp());
  CHECK_FALSE(parse({"--listen", "1", "--transport", "tcp"}).insecure);
  const DemoOptions both = parse({"--listen", "1", "--key", "k", "--transport", "udp"});
  CHECK(both.udp());
  CHECK_FALSE(both.insecure);
  CHECK(parse({"--listen", "1", "--transport", "udp", "--clock", "none"}).udp());
  CHECK(refusal({"--listen", "1", "--transport", "quic"}) ==
        "--transport must be tcp or udp, is 'quic'");
  CHECK(refusal({"--transport", "udp"}) == "--transport needs --listen or --connect");
  CHECK(refusal({"--listen", "1", "--send", "budget=7"}) ==
        "--send budget must be 0 or a number from 8 to 1e6 kbit/s, is '7'");
}

TEST_CASE("options: a refusal has the rule and the value", "[demos][fault]") {
  CHECK(refusal({"--profile", "6"}) == "--profile must be an integer from 0 to 5, is '6'");
  CHECK(refusal({"--profile", "2.5"}) == "--profile must be an integer from 0 to 5, is '2.5'");
  CHECK(refusal({"--seconds", "nan"}) == "--seconds must be a number from 0.1 to 86400, is 'nan'");
  CHECK(refusal({"--seconds", "inf"}) == "--seconds must be a number from 0.1 to 86400, is 'inf'");
  CHECK(refusal({"--seconds"}) == "--seconds needs a value");
  CHECK(refusal({"--seed", "-1"}) == "--seed must be an integer of 64 bits, >= 0, is '-1'");
  CHECK(refusal({"--influence", "1"}) == "--influence must be a number from 0 to 0.99, is '1'");
  CHECK(refusal({"--predictor", "Euler"}) ==
        "--predictor must be none, euler or replay, is 'Euler'");
  CHECK(refusal({"--coupling", ""}) ==
        "--coupling must be one-pass, two-step-paper, two-step, none or single-owner, is ''");
  CHECK(refusal({"--listen", "65536"}) ==
        "--listen must be a port from 0 (any) to 65535, is '65536'");
  for (const char* bad : {"host", "host:", ":80", "host:0", "host:65536", "host:8x"}) {
    CHECK(refusal({"--connect", bad}) ==
          "--connect must be HOST:PORT, port 1 to 65535, is '" + std::string(bad) + "'");
  }
  CHECK(refusal({"7"}) == "unexpected word '7'; options begin with --");
  CHECK(refusal({"--reference=yes"}) == "--reference takes no value");
  CHECK(refusal({"--script", "hands=a.txt,"}) ==
        "--script must be none, FILE or hands=FILE,.., is 'hands=a.txt,'");
  CHECK(parse({"--script", "hands=a.txt,b.txt"}).hands ==
        std::vector<std::string>{"a.txt", "b.txt"});
  CHECK(refusal({"--json="}) == "--json must not be empty");
  CHECK(refusal({"--iterations", "1,2,3"}) ==
        "--iterations must be N, or N,M with M of Bullet's solver, is '1,2,3'");
  CHECK(refusal({"--send", "compact=1"}) == "--send compact must be without a value, is '1'");
}

TEST_CASE("options: an unknown name is refused with the closest known one", "[demos][fault]") {
  CHECK(refusal({"--profil", "3"}) == "unknown option '--profil'; did you mean '--profile'?");
  CHECK(refusal({"--seeed=3"}) == "unknown option '--seeed'; did you mean '--seed'?");
  CHECK(refusal({"--bogus"}) == "unknown option '--bogus'; --help-all lists what there is");
  CHECK(refusal({"-q"}) == "unknown option '-q'; --help-all lists what there is");
  CHECK(refusal({"--link", "los=0.1"}) == "unknown item of --link 'los'; did you mean 'loss'?");
  CHECK(refusal({"--ablate", "leading,channel"}) ==
        "unknown part for --ablate 'channel'; did you mean 'channels'?");
}

TEST_CASE("options: results that cannot be written are found before the run", "[demos][fault]") {
  const auto wrong = [](const std::vector<std::string_view>& words) -> std::string {
    try {
      check_results(parse(words));
    } catch (const UsageError& error) {
      return error.what();
    }
    return {};
  };
  CHECK(wrong({"--json", "/nowhere/at/all"}) ==
        "--json must be a file that can be written, is '/nowhere/at/all'");
  CHECK(wrong({"--record", "/nowhere/at/all.glb"}).starts_with("--record must be a file"));
  CHECK(wrong({"--csv", "/dev/null/here"}).starts_with("--csv must be a folder"));
  CHECK(wrong({"--json", "-"}).empty());
}

TEST_CASE("options: contradictory options are refused", "[demos][fault]") {
  CHECK(refusal({"--listen", "1", "--profile", "2"}) ==
        "--profile has no meaning with --listen or --connect");
  CHECK(refusal({"--peers", "2", "--connect", "a:1"}) ==
        "--peers has no meaning with --listen or --connect");
  CHECK(refusal({"--peer-id", "2"}) == "--peer-id needs --listen or --connect");
  CHECK(refusal({"--listen", "1", "--rates", "60,72", "--seconds", "3"}).empty());
}

TEST_CASE("options: a page has any port where none is given, and no end but a given one",
          "[demos][unit]") {
  CHECK_FALSE(parse({}).view);
  CHECK(parse({"--view"}).view == std::uint16_t{0});
  CHECK(parse({"--view", "--reference"}).view == std::uint16_t{0});
  CHECK(parse({"--view", "8080"}).view == std::uint16_t{8080});
  CHECK(parse({"--view", "0.0.0.0:8080"}).view_address == "0.0.0.0");
  CHECK(parse({"--view", "[::1]:8080"}).view_address == "::1");
  CHECK(parse({"--view", "[::1]:8080"}).view == std::uint16_t{8080});
  CHECK(parse({"--view=8080", "--script", "none"}).no_script);
  CHECK(parse({"--view"}).endless);
  CHECK_FALSE(parse({"--seconds", "5", "--view"}).endless);
  CHECK_FALSE(parse({"--script", "none"}).endless);
  CHECK(refusal({"--view", "65536"}) == "--view must be a port from 0 (any) to 65535, is '65536'");
  CHECK(refusal({"--view", "here"}) == "--view must be a port from 0 (any) to 65535, is 'here'");
  CHECK(refusal({"--view", "--json", "-"}) == "--json with --view needs --seconds");
  CHECK(refusal({"--view", "--json", "-", "--seconds", "5"}).empty());
}

}  // namespace
}  // namespace tandem::demos::options_test
