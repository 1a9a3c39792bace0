// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "scenes/hand_record.h"

#ifndef _WIN32
#include <sys/stat.h>
#endif

#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "support/catch.h"
#include "support/folder.h"

namespace tandem::demos::hand_record_test {
namespace {

const std::string kHead = "tandem-hand 1\nroom sandbox\nrate 60\n";

std::string refusal(const std::string& text) {
  try {
    hand_record_from_text(text, "mine.txt");
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return {};
}

TEST_CASE("hand record: a written record is read back", "[demos][unit]") {
  const HandRecord record =
      hand_record_from_text("# Somebody.\n" + kHead +
                                "\n0.5 grab cube/9 0.1 -0.05 0 1 2 3\n0.75 move 1 2 3.5\n1 let\n"
                                "1 grab ball/0 0 0 0 -1 0 0.1\n1.5 let\n2.25 end\n",
                            "mine.txt");
  CHECK(record.room == "sandbox");
  CHECK(record.rate == 60);
  CHECK(record.seconds == 2.25);
  REQUIRE(record.holds.size() == 2);
  const HandRecord::Hold& hold = record.holds[0];
  CHECK(hold.body == "cube/9");
  CHECK(hold.attachment_l == pbd::Vec3(0.1, -0.05, 0.0));
  CHECK(hold.start() == 0.5);
  CHECK(hold.end == 1.0);
  CHECK(hold.wanted(0.0) == pbd::Vec3(1.0, 2.0, 3.0));
  CHECK(hold.wanted(0.625) == pbd::Vec3(1.0, 2.0, 3.25));
  CHECK(hold.wanted(0.99) == pbd::Vec3(1.0, 2.0, 3.5));
  CHECK(record.holds[1].body == "ball/0");
  CHECK(record.holds[1].way.size() == 1);
  CHECK(hand_record_from_text(kHead + "0 end", "mine.txt").holds.empty());
  CHECK(hand_record_from_text("tandem-hand 1\r\nroom a\r\nrate 60\r\n0 end\r\n", "mine.txt").room ==
        "a");
}

TEST_CASE("hand record: each bad thing is refused by file, line, field and value",
          "[demos][fault]") {
  struct Bad {
    std::string text;
    std::vector<std::string> told;
  };
  const std::string grab = kHead + "1 grab cube/9 0 0 0 1 2 3\n";
  const std::string name(65, 'x');
  const Bad all[] = {
      {"", {"line 1", "last line", "TIME end"}},
      {"tandem-hands 1\n", {"line 1", "first word", "tandem-hand", "'tandem-hands'"}},
      {"tandem-hand 2\n", {"line 1", "version", "'2'"}},
      {"tandem-hand 1\nrate 60\n", {"line 2", "first word", "room", "'rate'"}},
      {"tandem-hand 1\nroom " + name + "\n", {"line 2", "room", "64"}},
      {"tandem-hand 1\nroom a\nrate 0\n", {"line 3", "rate", "240", "'0'"}},
      {"tandem-hand 1\nroom a\nrate 60.5\n", {"line 3", "rate", "integer", "'60.5'"}},
      {kHead + "nan end\n", {"line 4", "time", "600", "'nan'"}},
      {kHead + "-1 end\n", {"line 4", "time", "'-1'"}},
      {kHead + "600.1 end\n", {"line 4", "time", "600", "'600.1'"}},
      {kHead + "0 jump 1 2 3\n", {"line 4", "kind", "grab", "'jump'"}},
      {kHead + "0 move 1 2 3\n", {"line 4", "kind", "nothing is held", "'move'"}},
      {kHead + "0 let\n", {"line 4", "kind", "'let'"}},
      {kHead + "0 grab b 0 0 0 1 2\n", {"line 4", "wanted", "three numbers", "''"}},
      {kHead + "0 grab b 0 0 inf 1 2 3\n", {"line 4", "attachment", "'inf'"}},
      {kHead + "0 grab \x01 0 0 0 1 2 3\n", {"line 4", "body", "printable", "'?'"}},
      {grab + "1.1 move 1e9 2 3\n", {"line 5", "wanted", "100", "'1e9'"}},
      {grab + "1.1 move 1e999 2 3\n", {"line 5", "wanted", "'1e999'"}},
      {grab + "1.1 move 1 nan 3\n", {"line 5", "wanted", "'nan'"}},
      {grab + "0.9 move 1 2 3\n", {"line 5", "time", "not before", "0.9"}},
      {grab + "1.1 move 1 2 3 4\n", {"line 5", "end of the line", "'4'"}},
      {grab + "2 end\n", {"line 5", "kind", "while something is held", "'end'"}},
      {grab + "2 grab b 0 0 0 1 2 3\n", {"line 5", "kind", "'grab'"}},
      {grab + "2 let\n", {"line 6", "last line", "end"}},
      {grab + "2 let\n3 end\n3 end\n", {"line 7", "end", "last line"}},
  };
  for (const Bad& bad : all) {
    CAPTURE(bad.text);
    const std::string told = refusal(bad.text);
    CAPTURE(told);
    CHECK(told.find("mine.txt") == 0);
    for (const std::string& piece : bad.told) CHECK(told.find(piece) != std::string::npos);
  }
}

TEST_CASE("hand record: more holds than a scene could tell apart are refused", "[demos][fault]") {
  std::string text = kHead;
  for (int i = 0; i < 4096; ++i) text += "1 grab a 0 0 0 0 0 0\n1 let\n";
  CHECK(hand_record_from_text(text + "1 end\n", "mine.txt").holds.size() == 4096);
  CHECK_THROWS_WITH(hand_record_from_text(text + "1 grab a 0 0 0 0 0 0\n", "mine.txt"),
                    Catch::Contains("at most 4096"));
}

TEST_CASE("hand record: more than its rate or its longest allow is refused", "[demos][fault]") {
  std::string text = kHead + "0 grab b 0 0 0 1 2 3\n";
  for (int i = 0; i < 62; ++i) text += "1 move 1 2 3\n";
  CHECK(refusal(text + "1 let\n1 end\n").find("number of moves") != std::string::npos);
  CHECK(refusal(text + "1 let\n1.1 end\n").empty());
  const std::string huge(9u << 20, ' ');
  CHECK(refusal(kHead + huge).find("mine.txt: size must be at most 8388608") == 0);
  CHECK_THROWS_AS(read_hand_record("there is no such file"), std::runtime_error);
}

TEST_CASE("hand record: a path that is no regular file is refused at once", "[demos][fault]") {
  const testing::Folder folder;
  const auto refused = [](const std::string& path) {
    try {
      read_hand_record(path);
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  CHECK(read_hand_record(folder.write("hand.txt", kHead + "0 end\n")).room == "sandbox");
  std::filesystem::create_directory(folder.file("folder"));
  CHECK(refused(folder.file("folder")) ==
        folder.file("folder") + ": file must be a regular one, is a folder");
#ifndef _WIN32
  REQUIRE(mkfifo(folder.file("pipe").c_str(), 0600) == 0);
  CHECK(refused(folder.file("pipe")) ==
        folder.file("pipe") + ": file must be a regular one, is a pipe");
  CHECK(refused("/dev/zero") == "/dev/zero: file must be a regular one, is a device or a socket");
#endif
}

}  // namespace
}  // namespace tandem::demos::hand_record_test
