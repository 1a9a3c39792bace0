// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#ifndef _WIN32
#include <ifaddrs.h>
#endif

#include <array>
#include <chrono>
#include <functional>
#include <nlohmann/json.hpp>
#include <thread>

#include "support/catch.h"
#include "support/hostile_requests.h"
#include "support/web_client.h"
#include "view/server.h"
#include "view_frames.h"

namespace tandem::demos::view::view_server_test {
namespace {

using testing::WebClient;

constexpr std::array<Asset, 2> kAssets = {
    {{"", "text/html", "<p>here</p>"}, {"main.js", "text/javascript", "let x = 1;"}}};

Layout layout_of(std::size_t bodies) {
  Layout layout;
  layout.position_unit = 20.0 / 0x100000;
  layout.panes.resize(1);
  layout.bodies.resize(bodies);
  return layout;
}

struct Fixture {
  explicit Fixture(std::size_t bodies = 3, const ServerOptions& options = {})
      : server(options, layout_of(bodies), kAssets) {
    server.set_hello(R"({"type":"hello"})");
  }
  Server server;
  std::string host = "127.0.0.1:" + std::to_string(server.port());
  std::string root = '/' + server.token() + '/';

  /// A page that was greeted.
  std::unique_ptr<WebClient> page(int receive_bytes = 0) {
    auto client = std::make_unique<WebClient>("127.0.0.1", server.port(), receive_bytes);
    REQUIRE(client->open(root + "socket", host) == 101);
    const auto hello = client->hear();
    REQUIRE(hello);
    CHECK(hello->bytes == R"({"type":"hello"})");
    return client;
  }
  void show(std::size_t bodies, double where) {
    Frame frame;
    frame.time = where;
    frame.panes.resize(1);
    frame.panes[0].poses.resize(bodies);
    for (pbd::Pose& pose : frame.panes[0].poses) pose.position.setConstant(where);
    server.show(frame);
  }
  /// Pages' commands, once there are any.
  std::vector<PageEvent> events(std::size_t least = 1) {
    std::vector<PageEvent> all;
    for (int i = 0; i < 500 && all.size() < least; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
      server.take(all);
    }
    return all;
  }
};

TEST_CASE("view server: hostile requests", "[demos][view][socket]") {
  Fixture f(1, {.max_connections = 6});
  CHECK(f.server.token().size() == 32);
  CHECK(f.server.token().find_first_not_of("0123456789abcdef") == std::string::npos);
  CHECK(f.server.url() == "http://" + f.host + f.root);
  CHECK(Fixture().server.token() != f.server.token());
  const testing::Served served{.port = f.server.port(),
                               .root = f.root,
                               .socket = "socket",
                               .help = "whole address that the program printed"};
  SECTION("tokens") {
    testing::check_tokens(served);
    CHECK(f.server.counters().refused >= 10);
  }
  SECTION("names") { testing::check_names(served); }
  SECTION("malformed") { testing::check_malformed(served); }
  SECTION("flood") { testing::check_flood(served, 6); }
}

TEST_CASE("view server: a program that ends says so to its pages", "[demos][view][socket]") {
  auto f = std::make_unique<Fixture>();
  auto page = f->page();
  // A page sees the code of a close: 1001, going away.
  std::thread ending([&f] { f.reset(); });
  const auto start = page->bytes(4);
  page->send(std::string("\x88\x82", 2) + std::string(4, '\0') + "\x03\xe9");
  ending.join();
  REQUIRE(start);
  CHECK(*start == std::string("\x88\x02\x03\xe9", 4));
}

TEST_CASE("view server: it is at its address alone", "[demos][view][socket]") {
  Fixture f;
  CHECK_THROWS(WebClient("127.0.0.2", f.server.port()));
#ifndef _WIN32
  ifaddrs* all = nullptr;
  REQUIRE(getifaddrs(&all) == 0);
  for (const ifaddrs* each = all; each != nullptr; each = each->ifa_next) {
    if (each->ifa_addr == nullptr || each->ifa_addr->sa_family != AF_INET) continue;
    char text[INET_ADDRSTRLEN] = {};
    inet_ntop(AF_INET, &reinterpret_cast<const sockaddr_in*>(each->ifa_addr)->sin_addr, text,
              sizeof(text));
    INFO(text);
    if (std::string(text) == "127.0.0.1") continue;
    CHECK_THROWS(WebClient(text, f.server.port()));
  }
  freeifaddrs(all);
#endif
  CHECK_THROWS_AS(Server({.address = "localhost"}, layout_of(1), kAssets), std::invalid_argument);
  CHECK_THROWS_AS(Server({.port = f.server.port()}, layout_of(1), kAssets), std::runtime_error);
}

TEST_CASE(
    "view server: commands are handed on, refused by name, and cut off where they are too many",
    "[demos][view][socket]") {
  Fixture f;
  auto page = f.page();
  page->say(R"({"type":"grab","id":1,"pane":0,"body":2,"point":[0,0,1]})");
  page->say(R"({"type":"set","name":"influence","value":7})");
  page->say(R"({"type":"ping","time":42})");
  page->say(R"({"type":"want","overlays":true})");
  page->say(R"({"type":"step"})");
  const auto refused = page->hear();
  REQUIRE(refused);
  const auto words = nlohmann::json::parse(refused->bytes);
  CHECK(words["type"] == "refused");
  CHECK(words["text"] == "influence must be from 0 to 0.5, is 7");
  const auto pong = page->hear();
  REQUIRE(pong);
  CHECK(nlohmann::json::parse(pong->bytes)["time"] == 42.0);
  const std::vector<PageEvent> events = f.events(2);
  REQUIRE(events.size() == 2);
  CHECK(std::get<Grab>(std::get<Command>(events[0].what)).body == 2);
  CHECK(std::holds_alternative<Step>(std::get<Command>(events[1].what)));
  CHECK(f.server.wants_overlays());

  for (int i = 0; i < 600; ++i) {
    if (!page->say(R"({"type":"move","id":1,"point":[0,0,1]})")) break;
  }
  while (page->hear()) {
  }
  // Commands within the bounds are executed, then the page is closed.
  std::vector<PageEvent> rest;
  for (int i = 0; i < 100 && (rest.empty() || std::holds_alternative<Command>(rest.back().what));
       ++i) {
    const std::vector<PageEvent> more = f.events();
    rest.insert(rest.end(), more.begin(), more.end());
  }
  REQUIRE_FALSE(rest.empty());
  CHECK(std::holds_alternative<Left>(rest.back().what));
  CHECK(rest.size() < 400);
  CHECK_FALSE(f.server.wants_overlays());
}

TEST_CASE("view server: a page that closes or breaks the protocol is gone",
          "[demos][view][socket]") {
  Fixture f;
  const std::array<std::function<void(WebClient&)>, 6> ways = {
      [](WebClient& page) { page.close(); },
      [](WebClient& page) { page.say(std::string(1025, ' ')); },
      [](WebClient& page) { page.send(std::string("\x82\x80") + "abcd"); },
      [](WebClient& page) { page.send(std::string("\x81\x02") + "{}"); },
      [](WebClient& page) { page.send(std::string("\x88\x80") + "abcd"); },
      [](WebClient& page) { page.send(std::string(40, '\xff')); }};
  std::vector<std::unique_ptr<WebClient>> pages;
  for (const auto& way : ways) {
    pages.push_back(f.page());
    way(*pages.back());
  }
  // To those that break the rules it is said, and some time is given to hear it.
  std::vector<PageEvent> events;
  while (events.size() < ways.size()) {
    const std::vector<PageEvent> more = f.events();
    REQUIRE_FALSE(more.empty());
    events.insert(events.end(), more.begin(), more.end());
  }
  for (const PageEvent& event : events) CHECK(std::holds_alternative<Left>(event.what));
  CHECK(f.server.pages() == 0);
}

TEST_CASE("view server: no more pages than it will have", "[demos][view][socket]") {
  Fixture f(1, {.max_pages = 2});
  auto a = f.page();
  auto b = f.page();
  WebClient third("127.0.0.1", f.server.port());
  CHECK(third.open(f.root + "socket", f.host) == 503);
  a->close();
  REQUIRE(f.events().size() == 1);
  auto c = f.page();
  CHECK(f.server.pages() == 2);
}

TEST_CASE("view server: a thousand connections that ask for nothing keep no page out",
          "[demos][view][socket][fault]") {
  Fixture f;
  std::vector<std::unique_ptr<WebClient>> idle;
  const auto open = [&](int count) {
    for (int i = 0; i < count; ++i) {
      idle.push_back(std::make_unique<WebClient>("127.0.0.1", f.server.port()));
    }
  };
  open(1000);
  auto first = f.page();
  for (int round = 0; round < 5; ++round) {
    // One that is kept open behind the page asks for nothing either.
    WebClient client("127.0.0.1", f.server.port());
    CHECK(client.get(f.root, f.host) == 200);
    open(64);
    auto page = f.page();
    CHECK(f.server.pages() == 2);
    page->close();
    REQUIRE_FALSE(f.events().empty());
  }
  // The page that was open all the time has lost nothing.
  f.show(3, 1.0);
  CHECK(first->hear());
}

TEST_CASE("view server: pages see every frame, or the newest whole", "[demos][view][socket]") {
  constexpr std::size_t kBodies = 2000;
  Fixture f(kBodies);
  auto slow = f.page(4096);
  auto fast = f.page();
  PageReader eager(20.0 / 0x100000, 1, kBodies);
  std::uint32_t last = 0;
  // 24 kB each: far more than sockets hold.
  for (int i = 1; i <= 300; ++i) {
    f.show(kBodies, 0.01 * i);
    const auto frame = fast->hear(true);
    REQUIRE(frame);
    eager.read(frame->bytes);
    CHECK(eager.key == (i == 1));
    CHECK(eager.number == ++last);
  }
  CHECK(f.server.counters().missed > 100);
  PageReader late(20.0 / 0x100000, 1, kBodies);
  std::uint32_t before = 0;
  int keys = 0, seen = 0;
  do {
    const auto frame = slow->hear(true);
    REQUIRE(frame);
    late.read(frame->bytes);
    ++seen;
    keys += late.key ? 1 : 0;
    CHECK((late.key || late.number == before + 1));
    CHECK(late.number > before);
    before = late.number;
  } while (late.number < 300);
  CHECK(keys >= 2);
  CHECK(seen < 200);
  CHECK(late.panes[0].bodies[7].position.x() == Approx(3.0).margin(1e-4));
}

TEST_CASE("view server: a page that comes after all have left sees the present state",
          "[demos][view][socket]") {
  Fixture f;
  auto first = f.page();
  f.show(3, 1.0);
  REQUIRE(first->hear(true));
  first->close();
  REQUIRE(f.events().size() == 1);
  auto second = f.page();
  // Words go before frames, so that an old one might come after any of them.
  for (int i = 0; i < 10; ++i) {
    second->say(R"({"type":"ping","time":1})");
    const auto pong = second->hear();
    REQUIRE(pong);
    REQUIRE_FALSE(pong->binary);
  }
  f.show(3, 4.0);
  const auto frame = second->hear();
  REQUIRE(frame);
  REQUIRE(frame->binary);
  PageReader page(20.0 / 0x100000, 1, 3);
  page.read(frame->bytes);
  CHECK(page.key);
  CHECK(page.time == 4.0);
  CHECK(page.panes[0].bodies[2].position.x() == Approx(4.0).margin(1e-4));
}

TEST_CASE("view server: where nothing moves, frames are few; settings reach all",
          "[demos][view][socket]") {
  Fixture f;
  auto page = f.page();
  auto other = f.page();
  const auto start = std::chrono::steady_clock::now();
  for (int i = 0; i < 20; ++i) {
    f.show(3, 1.0);
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  f.server.tell("said");
  std::size_t frames = 0;
  auto message = page->hear();
  for (; message && message->binary; message = page->hear()) ++frames;
  REQUIRE(message);
  CHECK(message->bytes == "said");
  const auto heard = other->hear(false);
  REQUIRE(heard);
  CHECK(heard->bytes == "said");
  CHECK(frames >= 1);
  // One at once, and one more for each half second.
  const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - start;
  CHECK(static_cast<double>(frames) <= 2.0 + passed.count() / 0.5);
}

}  // namespace
}  // namespace tandem::demos::view::view_server_test
