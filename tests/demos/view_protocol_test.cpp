// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "scenes/cubes.h"
#include "scenes/random.h"
#include "support/catch.h"
#include "tandem/pbd/math.h"
#include "view/frame_encoder.h"
#include "view/protocol.h"
#include "view_frames.h"

namespace tandem::demos::view::view_protocol_test {
namespace {

using pbd::Vec3;

constexpr double kUnit = 20.0 / 0x100000;
/// Each of three parts is off by half a step at most; where all four are 1/2 the fourth takes up
/// all three errors, and an angle is twice the arc between quaternions.
const double kMaxTurn = 2.0 * std::sqrt(3.0 + 9.0) * 0.5 / (511.0 * std::sqrt(2.0));

Layout layout_of(std::size_t panes, std::size_t bodies) {
  Layout layout;
  layout.position_unit = kUnit;
  layout.panes.resize(panes);
  layout.bodies.resize(bodies);
  return layout;
}

pbd::Pose random_pose(Random& random) {
  pbd::Pose pose;
  for (double& value : pose.position) value = random.uniform(-19.0, 19.0);
  Eigen::Vector4d q;
  do {
    for (double& value : q) value = random.uniform(-1.0, 1.0);
  } while (q.norm() < 0.1);
  pose.orientation.coeffs() = q.normalized();
  return pose;
}

Frame random_frame(Random& random, const Layout& layout) {
  Frame frame;
  frame.time = random.uniform(0.0, 1e4);
  for (std::size_t i = 0; i < layout.panes.size(); ++i) {
    PaneFrame& pane = frame.panes.emplace_back();
    pane.step_ms = random.uniform(0.0, 10.0);
    pane.divergence_p50_mm = std::nan("");
    for (std::size_t b = 0; b < layout.bodies.size(); ++b)
      pane.poses.push_back(random_pose(random));
  }
  return frame;
}

std::string text_of(const FrameEncoder::Bytes& bytes) {
  return {reinterpret_cast<const char*>(bytes->data()), bytes->size()};
}

double angle_between(const pbd::Quat& a, const pbd::Quat& b) {
  return pbd::rotation_between(a, b).norm();
}

TEST_CASE("frame: a page reads shown poses to half a unit and 0.3 degrees", "[demos][view][unit]") {
  Layout layout = layout_of(2, 19);
  layout.bodies[7].turns = false;
  FrameEncoder encoder(layout);
  Random random(1);
  PageReader page(kUnit, 2, 19);
  for (std::uint32_t i = 1; i <= 50; ++i) {
    const Frame frame = random_frame(random, layout);
    REQUIRE(encoder.take(frame, false));
    page.read(text_of(encoder.bytes(i == 1, false)));
    CHECK(page.number == i);
    CHECK(page.key == (i == 1));
    CHECK(page.time == frame.time);
    for (std::size_t p = 0; p < 2; ++p) {
      CHECK(page.panes[p].step_ms == static_cast<float>(frame.panes[p].step_ms));
      CHECK(std::isnan(page.panes[p].divergence_p50_mm));
      for (std::size_t b = 0; b < 19; ++b) {
        const pbd::Pose& pose = frame.panes[p].poses[b];
        const PageBody& body = page.panes[p].bodies[b];
        const Vec3 off = body.position - pose.position;
        CHECK(off.cwiseAbs().maxCoeff() <= 0.5001 * kUnit);
        if (layout.bodies[b].turns) {
          CHECK(angle_between(body.orientation, pose.orientation) < 1.01 * kMaxTurn);
        } else {
          CHECK(body.orientation.w() == 1.0);
        }
      }
    }
  }
}

TEST_CASE("frame: the frame before and the changes are the whole frame", "[demos][view][unit]") {
  const Layout layout = layout_of(2, 9);
  FrameEncoder encoder(layout);
  Random random(2);
  Frame frame = random_frame(random, layout);
  PageReader follower(kUnit, 2, 9);
  for (int i = 0; i < 30; ++i) {
    if (i > 0) {
      // One moves, one turns, all others stay.
      const std::size_t pane = random.below(2);
      frame.panes[pane].poses[random.below(9)].position = random_pose(random).position;
      frame.panes[1 - pane].poses[random.below(9)].orientation = random_pose(random).orientation;
    }
    REQUIRE(encoder.take(frame, false));
    follower.read(text_of(encoder.bytes(i == 0, false)));
    if (i > 0) CHECK(follower.panes[0].records + follower.panes[1].records <= 2);
    PageReader newcomer(kUnit, 2, 9);
    newcomer.read(text_of(encoder.bytes(true, false)));
    for (std::size_t p = 0; p < 2; ++p) {
      CHECK(newcomer.panes[p].records == 9);
      for (std::size_t b = 0; b < 9; ++b) {
        CHECK(newcomer.panes[p].bodies[b].position == follower.panes[p].bodies[b].position);
        CHECK(newcomer.panes[p].bodies[b].orientation.coeffs() ==
              follower.panes[p].bodies[b].orientation.coeffs());
      }
    }
  }
  // Nothing is elsewhere: the frame is taken only where it must be.
  CHECK_FALSE(encoder.take(frame, false));
  CHECK(encoder.number() == 30);
  CHECK(encoder.take(frame, true));
  follower.read(text_of(encoder.bytes(false, false)));
  CHECK(follower.panes[0].records + follower.panes[1].records == 0);
  // Nobody has seen it any more, so that it is the first one again.
  encoder.forget();
  CHECK(encoder.number() == 0);
  CHECK(encoder.take(frame, false));
  CHECK(encoder.number() == 1);
}

TEST_CASE("frame: where panes are added or taken away, nobody may go on from the frame before",
          "[demos][view][unit]") {
  const Layout layout = layout_of(4, 3);
  FrameEncoder encoder(layout);
  Random random(7);
  Frame frame = random_frame(random, layout);
  const Frame all = frame;
  frame.panes.resize(2);
  REQUIRE(encoder.take(frame, false));
  CHECK(encoder.number() == 1);
  // A page that has frame 1 gets the changes only if the next frame is number 2.
  REQUIRE(encoder.take(all, false));
  CHECK(encoder.number() == 3);
  PageReader page(kUnit, 4, 3);
  page.read(text_of(encoder.bytes(true, false)));
  for (const PagePane& pane : page.panes) CHECK(pane.records == 3);
  REQUIRE(encoder.take(frame, false));
  CHECK(encoder.number() == 5);
  CHECK_FALSE(encoder.take(frame, false));
}

TEST_CASE("frame: overlays come where they are asked for and known", "[demos][view][unit]") {
  const Layout layout = layout_of(1, 3);
  FrameEncoder encoder(layout);
  Random random(3);
  Frame frame = random_frame(random, layout);
  PageReader page(kUnit, 1, 3);
  encoder.take(frame, true);
  page.read(text_of(encoder.bytes(true, true)));
  CHECK_FALSE(page.overlays);
  frame.overlays = true;
  PaneFrame& pane = frame.panes[0];
  pane.contacts.push_back({2, Vec3(1, 2, 3), Vec3(0, 0, 1), -0.25});
  pane.springs.push_back({1, Vec3(4, 5, 6), Vec3(7, 8, 9), 2, true});
  pane.targets.push_back({1, 3, Vec3(-1, -2, -3)});
  pane.influence = {0, 128, 255};
  encoder.take(frame, true);
  page.read(text_of(encoder.bytes(false, false)));
  CHECK_FALSE(page.overlays);
  // Hands are always seen.
  CHECK(page.panes[0].springs.size() == 1);
  page.read(text_of(encoder.bytes(false, true)));
  REQUIRE(page.overlays);
  const PagePane& seen = page.panes[0];
  REQUIRE(seen.contacts.size() == 1);
  CHECK(seen.contacts[0].body == 2);
  CHECK(seen.contacts[0].at == std::array<float, 7>{1, 2, 3, 0, 0, 1, -0.25F});
  REQUIRE(seen.springs.size() == 1);
  CHECK(seen.springs[0].body == 1);
  CHECK(seen.springs[0].ends == std::array<float, 6>{4, 5, 6, 7, 8, 9});
  CHECK(seen.springs[0].who == 2);
  CHECK(seen.springs[0].own == 1);
  REQUIRE(seen.targets.size() == 1);
  CHECK(seen.targets[0].body == 1);
  CHECK(seen.targets[0].peer == 3);
  CHECK(seen.targets[0].position == std::array<float, 3>{-1, -2, -3});
  CHECK(seen.influence == std::vector<int>{0, 128, 255});
}

TEST_CASE("frame: poses too far or not finite stay at the edge", "[demos][view][fault]") {
  const Layout layout = layout_of(1, 2);
  FrameEncoder encoder(layout);
  Frame frame;
  frame.panes.resize(1);
  frame.panes[0].poses.resize(2);
  frame.panes[0].poses[0].position = Vec3(1e300, -1e300, 21.0);
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  frame.panes[0].poses[1].position = Vec3(std::nan(""), kInfinity, -kInfinity);
  frame.panes[0].poses[1].orientation.coeffs().setConstant(std::nan(""));
  encoder.take(frame, true);
  PageReader page(kUnit, 1, 2);
  page.read(text_of(encoder.bytes(true, false)));
  CHECK((page.panes[0].bodies[0].position - Vec3(20, -20, 20)).norm() < 2.0 * kUnit);
  CHECK((page.panes[0].bodies[1].position - Vec3(-20, 20, -20)).norm() < 2.0 * kUnit);
}

TEST_CASE("hello: it lists bodies to draw and choices", "[demos][view][unit]") {
  const CubesScenario scenario;
  const Scene scene = scenario.build({});
  const Layout layout = make_layout("cubes", scene, 20.0, {{1, 60.0, "tandem"}}, true);
  CHECK(layout.position_unit == kUnit);
  Settings settings;
  settings.profile = 3;
  const auto hello = nlohmann::json::parse(hello_text(layout, scene, settings));
  CHECK(hello["type"] == "hello");
  CHECK(hello["protocol"] == 2);
  CHECK(hello["peers"].size() == 1);
  CHECK(hello["bodies"].size() == scene.bodies.size());
  CHECK(hello["bodies"][0]["name"] == scene.bodies[0].name);
  CHECK(hello["bodies"][0]["owner"].is_null());
  CHECK(hello["bodies"][0]["parts"][0]["shape"] == "box");
  CHECK(hello["bodies"][0]["parts"][0]["pose"].size() == 7);
  CHECK(hello["fixed"][0]["shape"] == "half_space");
  CHECK(hello["settings"]["profile"] == 3);
  CHECK(hello["settings"]["scheme"] == "one-pass");
  CHECK(hello["settings"]["beside"].is_null());
  CHECK(hello["peers"][0]["beside"] == false);
  CHECK(hello["choices"]["scheme"].size() == 5);
  CHECK(hello["choices"]["predictor"].size() == 3);
  settings.profile.reset();
  const Layout far = make_layout("cubes", scene, 20.0, {{1, 60.0, "tandem"}}, false);
  const auto other = nlohmann::json::parse(hello_text(far, scene, settings));
  CHECK(other["choices"].empty());
  CHECK(other["settings"]["profile"].is_null());
}

TEST_CASE("score: each pane's, by name, and whether it is the last word", "[demos][view][unit]") {
  const auto score = nlohmann::json::parse(
      score_text({{{"hits", 23.0}, {"longest_rally", 4.0}}, {{"hits", 22.0}}}, 12.5, true));
  CHECK(score["type"] == "score");
  CHECK(score["time"] == 12.5);
  CHECK(score["final"] == true);
  REQUIRE(score["outcomes"].size() == 2);
  CHECK(score["outcomes"][0]["longest_rally"] == 4.0);
  CHECK(score["outcomes"][1]["hits"] == 22.0);
}

// Commands.

Layout table() {
  Layout layout = layout_of(2, 5);
  layout.bodies[4].owner = 0;
  return layout;
}

std::string why(CommandReader& reader, const std::string& text) {
  const auto said = reader.read(text);
  const Refused* const refused = std::get_if<Refused>(&said);
  return refused == nullptr ? "" : refused->text;
}

/// Whether the text says what a field must be, and that it is `value`.
bool is_refused(const std::string& text, const std::string& field, const std::string& value) {
  const std::string is = ", is " + value;
  return text.starts_with(field + " must be ") && text.find(is) != std::string::npos;
}

TEST_CASE("command: a page's valid commands are understood", "[demos][view][unit]") {
  const Layout layout = table();
  CommandReader reader(layout);
  const auto said = [&](const std::string& text) {
    auto result = reader.read(text);
    INFO(text);
    REQUIRE(std::holds_alternative<Command>(result));
    return std::get<Command>(result);
  };
  const auto grab =
      std::get<Grab>(said(R"({"type":"grab","id":7,"pane":1,"body":3,"point":[1,-2.5,0]})"));
  CHECK((grab.id == 7 && grab.pane == 1 && grab.body == 3));
  CHECK(grab.point == Vec3(1, -2.5, 0));
  const auto move = std::get<Move>(said(R"({"type":"move","id":7,"point":[100,0,-100]})"));
  CHECK((move.id == 7 && move.point == Vec3(100, 0, -100)));
  CHECK(reader.held() == std::vector<std::uint32_t>{7});
  CHECK(std::get<Release>(said(R"({"type":"release","id":7})")).id == 7);
  CHECK(reader.held().empty());
  CHECK(std::get<SetPaused>(said(R"({"type":"set","name":"paused","value":true})")).paused);
  CHECK(std::get<SetSpeed>(said(R"({"type":"set","name":"speed","value":0.05})")).speed == 0.05);
  CHECK(std::get<SetProfile>(said(R"({"type":"set","name":"profile","value":5})")).profile == 5);
  CHECK(std::get<SetInfluence>(said(R"({"type":"set","name":"influence","value":0})")).influence ==
        0.0);
  CHECK(std::get<SetPredictor>(said(R"({"type":"set","name":"predictor","value":"euler"})"))
            .predictor == consensus::PredictorKind::Euler);
  CHECK(std::get<SetScheme>(said(R"({"type":"set","name":"scheme","value":"two-step"})")).scheme ==
        Scheme::TwoStep);
  CHECK(std::get<SetBeside>(said(R"({"type":"set","name":"beside","value":"none"})")).scheme ==
        Scheme::None);
  CHECK_FALSE(std::get<SetBeside>(said(R"({"type":"set","name":"beside","value":null})")).scheme);
  said(R"({"type":"step"})");
  said(R"({"type":"restart"})");
  said(R"({"type":"score"})");
  CHECK(std::get<Want>(said(R"({"type":"want","overlays":true})")).overlays);
  CHECK(std::get<Ping>(said(R"({"type":"ping","time":12.5})")).time == 12.5);
}

TEST_CASE("command: an invalid command is refused by name and changes nothing",
          "[demos][view][fault]") {
  const Layout layout = table();
  CommandReader reader(layout);
  const auto grab = [](const std::string& id, const std::string& rest) {
    std::string text(R"({"type":"grab","id":)");
    text.append(id).append(",").append(rest).append("}");
    return text;
  };
  const std::string good = R"("pane":0,"body":0,"point":[0,0,0])";
  CHECK(why(reader, R"({"type":"set","name":"influence","value":7})") ==
        "influence must be from 0 to 0.5, is 7");
  CHECK(why(reader, R"({"type":"set","name":"speed","value":1e999})") ==
        "command must be one JSON object");
  CHECK(is_refused(why(reader, R"({"type":"set","name":"speed","value":0.01})"), "speed", "0.01"));
  CHECK(is_refused(why(reader, R"({"type":"set","name":"profile","value":6})"), "profile", "6"));
  CHECK(
      is_refused(why(reader, R"({"type":"set","name":"profile","value":2.5})"), "profile", "2.5"));
  CHECK(
      is_refused(why(reader, R"({"type":"set","name":"scheme","value":"x"})"), "scheme", "\"x\""));
  CHECK(is_refused(why(reader, R"({"type":"set","name":"beside","value":7})"), "beside", "7"));
  CHECK(is_refused(why(reader, R"({"type":"set","name":"beside"})"), "beside", "nothing"));
  CHECK(is_refused(why(reader, R"({"type":"set","name":"gravity","value":1})"), "name", ""));
  CHECK(is_refused(why(reader, R"({"type":"move","id":1,"point":[0,0,0]})"), "id", "1"));
  CHECK(is_refused(why(reader, R"({"type":"release","id":1})"), "id", "1"));
  CHECK(is_refused(why(reader, grab("-1", good)), "id", "-1"));
  CHECK(is_refused(why(reader, grab("4294967296", good)), "id", "4294967296"));
  CHECK(is_refused(why(reader, grab("1", R"("pane":2,"body":0,"point":[0,0,0])")), "pane", "2"));
  CHECK(is_refused(why(reader, grab("1", R"("pane":0,"body":5,"point":[0,0,0])")), "body", "5"));
  CHECK(is_refused(why(reader, grab("1", R"("pane":0,"body":4,"point":[0,0,0])")), "body", "4"));
  CHECK(is_refused(why(reader, grab("1", R"("pane":0,"body":0,"point":[0,0,101])")), "point", ""));
  CHECK(is_refused(why(reader, grab("1", R"("pane":0,"body":0,"point":[0,0,null])")), "point", ""));
  CHECK(is_refused(why(reader, grab("1", R"("pane":0,"body":0,"point":[0,0])")), "point", ""));
  CHECK(is_refused(why(reader, grab("1", R"("pane":0,"body":0)")), "point", "nothing"));
  CHECK(is_refused(why(reader, R"({"type":"launch"})"), "type", "\"launch\""));
  CHECK(is_refused(why(reader, R"({"name":"speed"})"), "type", "nothing"));
  CHECK_FALSE(why(reader, "").empty());
  CHECK_FALSE(why(reader, "[1]").empty());
  CHECK_FALSE(why(reader, std::string(1025, ' ')).empty());
  std::string deep(R"({"type":"ping","time":0,"x":)");
  deep.append(900, '[').append(90, ']').append("}");
  CHECK_FALSE(why(reader, deep).empty());
  CHECK(reader.held().empty());
  for (int i = 0; i < 8; ++i) CHECK(why(reader, grab(std::to_string(i), good)).empty());
  CHECK(why(reader, grab("8", good)) == "id must be one of at most 8 at once, is 8");
  CHECK(is_refused(why(reader, grab("3", good)), "id", "3"));
  CHECK(reader.held().size() == 8);

  Layout far = table();
  far.live = false;
  CommandReader remote(far);
  for (const char* text : {R"({"type":"step"})", R"({"type":"restart"})", R"({"type":"score"})",
                           R"({"type":"set","name":"paused","value":true})"}) {
    CHECK(is_refused(why(remote, text), "type", ""));
  }
  CHECK(why(remote, grab("1", good)).empty());
}

TEST_CASE("command: any bytes are understood or refused", "[demos][view][fuzz]") {
  const std::array<std::string, 9> valid = {
      R"({"type":"grab","id":1,"pane":1,"body":3,"point":[1,-2.5,0]})",
      R"({"type":"move","id":1,"point":[0.5,0,1e-3]})",
      R"({"type":"release","id":1})",
      R"({"type":"set","name":"paused","value":false})",
      R"({"type":"set","name":"speed","value":1.5})",
      R"({"type":"set","name":"influence","value":0.25})",
      R"({"type":"set","name":"scheme","value":"none"})",
      R"({"type":"want","overlays":true})",
      R"({"type":"ping","time":3})"};
  constexpr std::string_view kPieces[] = {"1e308", "1e999", "-",    "null", "NaN", "{}",  "[",
                                          "]",     "\"",    "\\u0", "\xff", "0.5", "999", ","};
  const Layout layout = table();
  CommandReader reader(layout);
  Random random(4);
  int understood = 0;
  for (int i = 0; i < 100000; ++i) {
    std::string text = valid[random.below(valid.size())];
    for (std::uint64_t n = random.below(4); n > 0; --n) {
      const std::size_t at = random.below(text.size() + 1);
      switch (random.below(4)) {
        case 0:
          text.insert(at, kPieces[random.below(std::size(kPieces))]);
          break;
        case 1:
          text.erase(at, random.below(6));
          break;
        case 2:
          if (at < text.size()) text[at] = static_cast<char>(random.below(256));
          break;
        default:
          text.insert(at, text.substr(random.below(text.size()), random.below(2000)));
          break;
      }
      if (text.empty()) text.push_back('{');
    }
    const std::size_t held = reader.held().size();
    const auto said = reader.read(text);
    if (const Refused* const refused = std::get_if<Refused>(&said)) {
      CHECK(refused->text.size() < 200);
      CHECK(reader.held().size() == held);
      continue;
    }
    ++understood;
    CHECK(text.size() <= kMaxBytes);
    CHECK(reader.held().size() <= kMaxGrabs);
    const Command& command = std::get<Command>(said);
    const auto within = [](const Vec3& point) {
      return point.cwiseAbs().maxCoeff() <= kMaxDistance;
    };
    if (const Grab* const grab = std::get_if<Grab>(&command)) {
      CHECK((grab->pane < 2 && grab->body < 4 && within(grab->point)));
    } else if (const Move* const move = std::get_if<Move>(&command)) {
      CHECK(within(move->point));
    } else if (const SetSpeed* const speed = std::get_if<SetSpeed>(&command)) {
      CHECK((speed->speed >= kMinSpeed && speed->speed <= kMaxSpeed));
    } else if (const SetInfluence* const share = std::get_if<SetInfluence>(&command)) {
      CHECK((share->influence >= 0.0 && share->influence <= kMaxInfluence));
    }
  }
  CHECK(understood > 10000);
}

}  // namespace
}  // namespace tandem::demos::view::view_protocol_test
