// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <string>

#include "peer/link.h"
#include "peer/room_scene.h"
#include "support/catch.h"

namespace tandem::room::room_peer_test {
namespace {

const std::string kToken(32, 'a');
const std::string kKey(43, 'A');

TEST_CASE("room link: its parts, and errors by name") {
  const Address address = read_address("http://127.0.0.1:80/" + kToken + "/?room=piano#" + kKey);
  CHECK(address.host == "127.0.0.1");
  CHECK(address.port == "80");
  CHECK(address.room == "piano");
  CHECK(address.key == Bytes(32));
  CHECK(read_address("http://[::1]:81/" + kToken + "/#" + kKey).host == "::1");
  CHECK(read_address("http://[::1]/" + kToken + "/#" + kKey).port == "80");
  const auto fails = [](const std::string& link, const char* rule) {
    CHECK_THROWS_WITH(read_address(link), Catch::Contains(rule));
  };
  fails("https://a/" + kToken + "/#" + kKey, "http://");
  fails("http://a/" + kToken + "/", "key");
  fails("http://a/" + kToken + "/#" + kKey + "A", "43 letters");
  fails("http://a/" + kToken + "/#short", "43 letters");
  fails("http://a/1234/#" + kKey, "32 digits");
  fails("http:///" + kToken + "/#" + kKey, "host");
  fails("http://a/" + kToken + "/?x=1#" + kKey, "room");
}

constexpr const char* kRoom = R"({"bodies":[
  {"name":"ground","type":"static","shape":{"type":"halfSpace","normal":[0,0,1]}},
  {"name":"cube","shape":{"type":"box","halfExtents":[0.1,0.1,0.1]},"density":500,"position":[0,0,1]}]})";

TEST_CASE("room scene: bodies as the file has them") {
  RoomScene room(kRoom);
  REQUIRE(room.find("cube") != nullptr);
  CHECK(room.find("cube")->mass == Approx(4.0));  // 500 kg/m^3, 0.2 m
  CHECK(room.find("ground")->mass == 0.0);
  for (int i = 0; i < 120; ++i) room.scene().step(1.0 / 60.0);
  CHECK(room.scene().world().pose(room.find("cube")->body).position.z() ==
        Approx(0.1).margin(1e-3));
  CHECK_THROWS_AS(RoomScene("{}"), std::invalid_argument);
  CHECK_THROWS_AS(RoomScene("no json"), std::invalid_argument);
}

TEST_CASE("room scene: members make allowed bodies alone") {
  RoomScene room(kRoom);
  CHECK(room.make(
      R"({"name":"made/1","shape":{"type":"box","halfExtents":[0.1,0.1,0.1]},"position":[0,0,1]})"));
  const char* const bad[] = {
      R"({"name":"made/1","shape":{"type":"sphere","radius":0.1},"position":[0,0,1]})",  // there
                                                                                         // already
      R"({"name":"cube","shape":{"type":"sphere","radius":0.1},"position":[0,0,1]})",
      R"({"name":"made/2","shape":{"type":"sphere","radius":9},"position":[0,0,1]})",
      R"({"name":"made/2","shape":{"type":"sphere","radius":"9"},"position":[0,0,1]})",
      R"({"name":"made/2","shape":{"type":"sphere","radius":0.1},"position":[0,0,-1]})",
      R"({"name":"made/2","shape":{"type":"sphere","radius":0.1},"position":[0,0]})",
      R"({"name":"made/2","shape":{"type":"sphere","radius":0.1},"position":[1e300,0,1]})",
      R"({"name":"made/2","shape":{"type":"sphere","radius":0.1},"position":[0,0,1],"mass":1e9})",
      R"({"name":"made/2","shape":{"type":"mesh"},"position":[0,0,1]})",
      R"({"name":"made/2","shape":{"type":"box","halfExtents":[0.1,0.1,1e-9]},"position":[0,0,1]})",
      R"({"name":7,"shape":{"type":"sphere","radius":0.1},"position":[0,0,1]})",
      R"([1,2,3])",
      R"({"name")",
  };
  for (const char* const text : bad) {
    INFO(text);
    CHECK(room.make(text) == nullptr);
  }
  for (int i = 0; i < 400; ++i) {
    room.make(R"({"name":"made/x)" + std::to_string(i) +
              R"(","shape":{"type":"sphere","radius":0.05},"position":[0,0,1]})");
  }
  CHECK(room.bodies().size() == 320);
}

}  // namespace
}  // namespace tandem::room::room_peer_test
