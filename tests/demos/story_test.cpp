// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// What happened, in words, of results that are made up.
#include "measures/story.h"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <string>

#include "scenes/cliff.h"
#include "scenes/cubes.h"
#include "scenes/piano.h"
#include "scenes/pile.h"
#include "scenes/room.h"
#include "scenes/tennis.h"
#include "scenes/words.h"
#include "support/catch.h"

namespace tandem::demos::story_test {
namespace {

Outcome piano_outcome(bool delivered) {
  return {{"delivered", delivered ? 1.0 : 0.0},
          {"delivered_at_s", delivered ? 12.0 : -1.0},
          {"from_goal_m", delivered ? 0.001 : 0.58},
          {"way_left_m", delivered ? 0.001 : 1.12}};
}

/// Of so many peers who all saw the same.
Report report(std::size_t peers, const Outcome& outcome) {
  Report r;
  r.scenario = "piano";
  r.run.peers.resize(peers);
  for (PeerRecord& peer : r.run.peers) peer.outcome = outcome;
  r.run.seconds = 20.0;
  Distribution& apart = r.metrics.shared_m;
  apart.count = 100;
  apart.p50 = 0.0007;
  apart.p95 = 0.004;
  apart.max = 0.0561;
  Distribution& turned = r.metrics.divergence_deg;
  turned.p50 = 0.001;
  turned.p95 = 0.1;
  turned.max = 2.86;
  return r;
}

std::string told(const Report& r, const Report* beside = nullptr) {
  return story(PianoScenario(), r, beside, false);
}

/// In one line.
std::string flat(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

/// With one space for many: columns are as wide as what stands in them.
std::string squeezed(std::string text) {
  const auto both = [](char a, char b) { return a == ' ' && b == ' '; };
  text.erase(std::unique(text.begin(), text.end(), both), text.end());
  return text;
}

TEST_CASE("words: a length has the unit in which it is easily read", "[demos][unit]") {
  CHECK(length_words(0.0) == "less than 0.01 mm");
  CHECK(length_words(0.00007) == "0.07 mm");
  CHECK(length_words(0.0056) == "5.6 mm");
  CHECK(length_words(0.0561) == "56 mm");
  CHECK(length_words(0.0999) == "10 cm");
  CHECK(length_words(0.579) == "58 cm");
  CHECK(length_words(0.999) == "1 m");
  CHECK(length_words(123.4) == "123 m");
}

TEST_CASE("words: counts have the singular or the plural", "[demos][unit]") {
  CHECK(count_words(0, "ball") == "no balls");
  CHECK(count_words(1, "ball") == "one ball");
  CHECK(count_words(2, "person", "people") == "two people");
  CHECK(count_words(13, "ball") == "13 balls");
}

TEST_CASE("story: the link, the distances of copies, and the result", "[demos][unit]") {
  Report r = report(2, piano_outcome(true));
  r.options.profile = 5;
  CHECK(told(r).find("Two people, 123.5 ms apart, carried one piano through a maze in 12 s. Their\n"
                     "copies were typically 0.7 mm and at most 56 mm apart.\n") == 0);
  r.options.profile = 0;
  CHECK(told(r).find("Two people, with no delay between them, carried") == 0);
}

TEST_CASE("story: people alone, and people that watch", "[demos][unit]") {
  const std::string alone = flat(told(report(1, piano_outcome(true))));
  CHECK_THAT(alone, Catch::Contains("Two people at one computer carried one piano"));
  CHECK_THAT(alone, Catch::Contains("There was one copy"));
  const auto start = [](std::size_t peers) {
    const std::string text = told(report(peers, piano_outcome(true)));
    return text.substr(0, text.find(','));
  };
  CHECK(start(3) == "Two people and one other who watches");
  CHECK(start(5) == "Two people and three others who watch");
  Report nobody = report(2, piano_outcome(true));
  nobody.options.no_script = true;
  CHECK_THAT(told(nobody), Catch::Contains("Two peers, 28.5 ms apart,"));
}

TEST_CASE("story: over a network news have an age, unless there are none", "[demos][unit]") {
  Report r = report(2, piano_outcome(true));
  r.run.peers[1].outcome.clear();  // in another process
  r.options.listen = std::uint16_t{7777};
  r.metrics.latency_ms.count = 10;
  r.metrics.latency_ms.mean = 21.4;
  CHECK_THAT(told(r), Catch::Contains("Two people, whose news were 21 ms old"));
  r.metrics = {};
  CHECK_THAT(flat(told(r)), Catch::Contains("They did not hear of each other."));
}

TEST_CASE("story: a fault is told", "[demos][unit]") {
  Report r = report(2, piano_outcome(false));
  r.fault = "peer 1, 5.18 s: ball/0 fell through the ground";
  CHECK_THAT(told(r), Catch::Contains("left one piano in a maze with 1.1 m of 1.4 m to go"));
  CHECK_THAT(told(r), Catch::Contains("It went wrong: peer 1, 5.18 s: ball/0 fell"));
}

TEST_CASE("story: beside another run both are shown, and why that one lost", "[demos][unit]") {
  const Report r = report(2, piano_outcome(true));
  Report other = report(2, piano_outcome(false));
  other.options.scheme = Scheme::SingleOwner;
  other.fault = "it fell";
  const std::string text = squeezed(told(r, &other));
  CHECK_THAT(text, Catch::Contains("with agreement with a single owner\n"));
  CHECK_THAT(text, Catch::Contains("piano arrived after 12 s no, 1.1 m of 1.4 m to go\n"));
  CHECK_THAT(text, Catch::Contains("copies typically apart 0.7 mm 0.7 mm\n"));
  CHECK_THAT(text, Catch::Contains("at most 56 mm, 2.9 degrees 56 mm, 2.9 degrees\n"));
  CHECK_THAT(text, Catch::Contains("went wrong nothing it fell\n"));
  CHECK_THAT(text, Catch::Contains("A single owner loses by its nature"));
  // Outcomes that two peers saw differently.
  other.run.peers[1].outcome = piano_outcome(true);
  CHECK_THAT(told(r, &other), Catch::Contains("no, 1.1 m of 1.4 m to go or after 12 s"));
  other.options.scheme = Scheme::None;
  CHECK_THAT(told(r, &other), Catch::Contains("every computer simulates alone"));
  other.options.scheme = Scheme::TwoStepPaper;
  CHECK_THAT(told(r, &other), Catch::Contains("with two-step-paper"));
  CHECK_THAT(told(r, &other), !Catch::Contains("nature"));
  // A run that failed too must not disparage the other.
  other.options.scheme = Scheme::SingleOwner;
  CHECK_THAT(told(report(2, piano_outcome(false)), &other), !Catch::Contains("nature"));
}

TEST_CASE("story: colours where they are wanted alone", "[demos][unit]") {
  const Report r = report(2, piano_outcome(true));
  Report other = report(2, piano_outcome(false));
  CHECK(told(r, &other).find('\033') == std::string::npos);
  const std::string coloured = story(PianoScenario(), r, &other, true);
  CHECK_THAT(coloured, Catch::Contains("\033[32mafter 12 s"));
  CHECK_THAT(coloured, Catch::Contains("\033[31mno, 1.1 m of 1.4 m to go"));
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::tmpfile(), std::fclose);
  REQUIRE(file != nullptr);
  CHECK_FALSE(may_colour(file.get()));
}

TEST_CASE("story: every scene tells its result and whether that was the aim", "[demos][unit]") {
  const Achievement rally =
      TennisScenario().achievement({{"served", 1.0}, {"longest_rally", 23.0}});
  CHECK(rally.text == "played table tennis with one ball, 23 strokes in a row at most");
  CHECK(rally.done);
  CHECK_FALSE(TennisScenario().achievement({{"served", 5.0}, {"longest_rally", 1.0}}).done);
  const Achievement plate =
      CubesScenario().achievement({{"plate_carried_m", 0.3}, {"cubes_on_plate", 14.0}});
  CHECK(plate.text == "carried one plate with 14 cubes on it by 30 cm");
  CHECK(plate.done);
  CHECK_FALSE(CubesScenario().achievement({}).done);
  const Achievement room = RoomScenario().achievement(
      {{"box_handed_over", 1.0}, {"bench_moved_m", 0.5}, {"thrown_m", 2.03}});
  CHECK(room.text == "handed over a box, carried a bench by 50 cm and threw a toy by 2 m");
  CHECK_FALSE(RoomScenario().achievement({}).done);
  CHECK(CliffScenario().achievement({{"over_the_cliff", 664.0}}).text ==
        "saw 664 balls fall over a cliff");
  CHECK_FALSE(CliffScenario().achievement({{"lost", 1.0}}).done);
  CHECK(PileScenario().achievement({{"rolled_m", 4.7}, {"displaced", 1.0}}).text ==
        "rolled one big cube by 4.7 m and moved one small cube");
}

}  // namespace
}  // namespace tandem::demos::story_test
