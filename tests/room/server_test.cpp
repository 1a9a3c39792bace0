// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <unistd.h>

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "server/room_server.h"
#include "support/catch.h"
#include "support/hostile_requests.h"
#include "support/web_client.h"

namespace tandem::room::room_server_test {
namespace {

using Files = std::map<std::string, std::string>;
using testing::WebClient;

std::string text_of(const std::vector<std::uint8_t>& bytes) { return {bytes.begin(), bytes.end()}; }
std::string said(Wire kind, std::uint64_t id, const std::string& more = "") {
  return text_of(message(kind, id)) + more;
}

struct Fixture {
  explicit Fixture(const ServerOptions& options = {})
      : server(options,
               PageFiles(Files{{"index.html", "page"}, {"main.js", "script"}, {"secret", "x"}})) {}
  RoomServer server;
  std::string host = "127.0.0.1:" + std::to_string(server.port());
  std::string root = server.url().substr(server.url().find(host) + host.size());

  std::unique_ptr<WebClient> socket(const std::string& room = "sandbox", int status = 101,
                                    const std::string& extra = "", int receive_bytes = 0) {
    auto client = std::make_unique<WebClient>("127.0.0.1", server.port(), receive_bytes);
    REQUIRE(client->open(root + "socket/" + room, host, extra) == status);
    return client;
  }
  std::unique_ptr<WebClient> member(std::uint64_t id, const std::string& room = "sandbox",
                                    int receive_bytes = 0) {
    auto client = socket(room, 101, "", receive_bytes);
    REQUIRE(client->say(said(Wire::Join, id), true));
    const auto welcome = client->hear();
    REQUIRE(welcome);
    REQUIRE(static_cast<Wire>(welcome->bytes[0]) == Wire::Welcome);
    return client;
  }
};

TEST_CASE("room server: hostile requests") {
  ServerOptions options;
  options.max_connections = 6;
  Fixture room(options);
  const testing::Served served{.port = room.server.port(),
                               .root = room.root,
                               .socket = "socket/sandbox",
                               .help = "whole link as it was sent",
                               .has_https = true};
  SECTION("tokens") {
    testing::check_tokens(served);
    CHECK(testing::status_of(served, room.root + "?room=piano", room.host) == 200);
    CHECK(testing::status_of(served, room.root + "secret", room.host) == 404);
  }
  SECTION("names") { testing::check_names(served); }
  SECTION("malformed") { testing::check_malformed(served); }
  SECTION("flood") { testing::check_flood(served, 6); }
}

TEST_CASE("room server: it answers to the name that it has, and has the rooms that it has") {
  ServerOptions options;
  options.name = "play.example.org";
  Fixture room(options);
  room.root = room.server.url().substr(room.server.url().find(options.name) + options.name.size());
  const auto status = [&room](const std::string& host, const std::string& extra = "") {
    return WebClient("127.0.0.1", room.server.port()).get(room.root, host, extra);
  };
  CHECK(status("play.example.org") == 200);
  CHECK(status("evil.example.org") == 404);
  CHECK(status(room.host, "Host: play.example.org\r\n") == 404);
  room.socket("cellar", 503);
}

TEST_CASE("room server: a message goes to the named members, with its sender's name") {
  Fixture room;
  auto a = room.member(1);
  auto b = room.member(2);
  auto elsewhere = room.member(3, "piano");
  CHECK(a->hear()->bytes == said(Wire::Came, 2));
  REQUIRE(a->say(said(Wire::Newest, 2, "sealed"), true));
  CHECK(b->hear()->bytes == said(Wire::Newest, 1, "sealed"));
  REQUIRE(b->say(said(Wire::Reliable, 0, "to all"), true));
  CHECK(a->hear()->bytes == said(Wire::Reliable, 2, "to all"));
  REQUIRE(a->say(said(Wire::Newest, 3, "another room"), true));
  REQUIRE(a->say(said(Wire::Time, 42), true));
  const auto time = a->hear();
  REQUIRE(time);
  CHECK(time->bytes.substr(0, 9) == said(Wire::Time, 42));
  CHECK(time->bytes.size() == 17);
  b->close();
  CHECK(a->hear()->bytes == said(Wire::Gone, 2));
  REQUIRE(elsewhere->say(said(Wire::Time, 1), true));
  CHECK(elsewhere->hear()->bytes.substr(0, 9) == said(Wire::Time, 1));  // and nothing before it
}

TEST_CASE("room server: a member that breaks a rule is cut off, the others go on") {
  Fixture room;
  auto a = room.member(1);
  const std::vector<std::string> bad = {
      said(Wire::Newest, 1, "before joining"),
      said(Wire::Join, 0),
      said(Wire::Join, 1),  // another's id
      said(Wire::Join, 5, "more"),
      "",
      std::string(1, '\x01'),
      said(static_cast<Wire>(99), 5),
      said(Wire::Welcome, 5),
  };
  for (const std::string& words : bad) {
    auto client = room.socket();
    client->say(words, true);
    CHECK_FALSE(client->hear());
  }
  auto text = room.socket();
  text->say("{\"join\":5}");
  CHECK_FALSE(text->hear());
  const std::vector<std::string> bad_later = {said(Wire::Join, 6), said(Wire::Gone, 1),
                                              said(Wire::Newest, 1), std::string(70000, 'x')};
  for (const std::string& words : bad_later) {
    auto client = room.member(5);
    client->say(words, true);
    CHECK_FALSE(client->hear());
  }
  auto b = room.member(2);
  REQUIRE(b->say(said(Wire::Reliable, 1, "still here"), true));
  std::optional<WebClient::Message> last;
  do last = a->hear();
  while (last && static_cast<Wire>(last->bytes[0]) != Wire::Reliable);
  REQUIRE(last);
  CHECK(last->bytes == said(Wire::Reliable, 2, "still here"));
}

TEST_CASE("room server: a flood ends its sender, and nobody else") {
  ServerOptions options;
  options.member.messages_per_s = 200.0;
  Fixture room(options);
  auto a = room.member(1);
  auto b = room.member(2);
  auto flood = room.member(3);
  for (int i = 0; i < 2000 && flood->say(said(Wire::Newest, 0, "junk"), true); ++i) {
  }
  while (flood->hear()) {
  }
  REQUIRE(b->say(said(Wire::Reliable, 1, "word"), true));
  bool heard = false;
  bool gone = false;
  while (!heard) {
    const auto next = a->hear();
    REQUIRE(next);
    gone = gone || next->bytes == said(Wire::Gone, 3);
    heard = next->bytes == said(Wire::Reliable, 2, "word");
  }
  CHECK(gone);
  CHECK(room.server.counters().relayed < 1000);
}

TEST_CASE("room server: a member that does not read loses Newest messages, then its place") {
  ServerOptions options;
  options.member.messages_per_s = 1e6;
  options.member.bytes_per_s = 1e9;
  options.member.queue_bytes = 100000;
  options.member.reliable_bytes = 400000;
  Fixture room(options);
  auto a = room.member(1);
  auto slow = room.member(2, "sandbox", 4096);
  const std::string much(20000, 'x');
  for (int i = 0; i < 100; ++i) REQUIRE(a->say(said(Wire::Newest, 2, much), true));
  REQUIRE(a->say(said(Wire::Time, 1), true));
  do {
  } while (static_cast<Wire>(a->hear()->bytes[0]) != Wire::Time);
  CHECK(room.server.counters().dropped > 20);
  CHECK(room.server.counters().members == 2);
  for (int i = 0; i < 100; ++i) REQUIRE(a->say(said(Wire::Reliable, 2, much), true));
  CHECK(a->hear()->bytes == said(Wire::Gone, 2));
}

TEST_CASE("room server: a room, an address and the server are full at some time, and free again") {
  ServerOptions options;
  options.max_members = 2;
  options.max_connections = 6;
  Fixture room(options);
  {
    auto a = room.member(1);
    auto b = room.member(2);
    room.socket("sandbox", 503);
    auto c = room.member(3, "piano");
    std::vector<std::unique_ptr<WebClient>> idle;
    for (int i = 0; i < 8; ++i)
      idle.push_back(std::make_unique<WebClient>("127.0.0.1", room.server.port()));
    WebClient late("127.0.0.1", room.server.port());
    CHECK(late.get(room.root, room.host) == 200);  // in place of the first that said nothing
    CHECK(idle.front()->get(room.root, room.host) == 0);
    REQUIRE(a->say(said(Wire::Reliable, 2, "word"), true));
    CHECK(b->hear()->bytes == said(Wire::Reliable, 1, "word"));
    CHECK(room.server.counters().refused > 0);
  }
  for (int i = 0; i < 100 && room.server.counters().connections > 0; ++i) usleep(20000);
  auto again = room.member(1);
  CHECK(again);
}

TEST_CASE("room server: invalid options are refused by name") {
  const PageFiles files(Files{{"index.html", "page"}});
  ServerOptions options;
  options.address = "localhost";
  CHECK_THROWS_WITH(RoomServer(options, files),
                    Catch::Contains("address") && Catch::Contains("localhost"));
  options = {};
  options.token = "short";
  CHECK_THROWS_WITH(RoomServer(options, files), Catch::Contains("token must be 32 hex digits"));
  CHECK_THROWS_WITH(PageFiles(std::string("nowhere")),
                    Catch::Contains("there is no page in 'nowhere'"));
}

}  // namespace
}  // namespace tandem::room::room_server_test
