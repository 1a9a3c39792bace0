// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// The long-running peer over a server, in wall time.
#include <chrono>
#include <csignal>
#include <string>
#include <thread>

#include "demos/processes.h"
#include "nats/server.h"

namespace tandem::nats::peer_process_test {
namespace {

using namespace testing;
using tandem::demos::Process;
using tandem::testing::eventually;
using tandem::testing::Folder;

/// @param network  further lines of the configuration's table
Process start(const Server& server, const Folder& folder, int id, const std::string& network = "") {
  const std::string name = std::to_string(id);
  const std::string text = "id = " + name + "\n[network]\nkey = \"key\"\nservers = [\"127.0.0.1:" +
                           std::to_string(server.port()) + "\"]\nidentity = \"" + name +
                           ".identity\"\n" + network + "[user]\nfidget = true\n[log]\nfile = \"" +
                           name + ".log\"\n";
  folder.write("key", std::string(64, 'b'));
  folder.write(name + ".identity", std::string(63, 'a') + name);
  return Process("tandem-peer",
                 {"cubes", "--transport", "nats", "--config", folder.write(name + ".toml", text)});
}

TEST_CASE("tandem-peer: two of them hold a session over NATS through a server that is killed",
          "[nats][demos]") {
  if (!has_server()) return;
  Server server;
  const Folder folder;
  Process a = start(server, folder, 1);
  Process b = start(server, folder, 2);
  const auto says = [&](const char* log, const std::string& text) {
    return folder.text(log).find(text) != std::string::npos;
  };
  REQUIRE(eventually([&] {
    return says("1.log", "event=peer_connected peer=2") &&
           says("2.log", "event=peer_connected peer=1");
  }));
  CHECK(says("1.log", "transport=nats"));
  server.kill();
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  server.start();
  std::this_thread::sleep_for(std::chrono::milliseconds(1500));
  CHECK_FALSE(says("1.log", "event=peer_lost"));
  b.send(SIGTERM);
  CHECK(b.wait() == 0);
  CHECK(eventually([&] { return says("1.log", "event=peer_lost peer=2"); }));
  a.send(SIGINT);
  CHECK(a.wait() == 0);
  CHECK_FALSE(says("1.log", "level=error"));
}

TEST_CASE("tandem-peer: with network.listen two outlast the server and lose one without UDP",
          "[nats][demos]") {
  if (!has_server()) return;
  Server server;
  const Folder folder;
  Process a = start(server, folder, 1, "listen = 0\n");
  Process b = start(server, folder, 2, "listen = 0\n");
  Process c = start(server, folder, 3);
  const auto says = [&](const std::string& text) {
    return folder.text("1.log").find(text) != std::string::npos;
  };
  REQUIRE(eventually(
      [&] { return says("event=peer_connected peer=2") && says("event=peer_connected peer=3"); }));
  std::this_thread::sleep_for(std::chrono::seconds(4));  // they find the way
  server.kill();
  REQUIRE(eventually([&] { return says("event=peer_lost peer=3"); }, std::chrono::seconds(20)));
  std::this_thread::sleep_for(std::chrono::seconds(1));
  CHECK_FALSE(says("event=peer_lost peer=2"));
  server.start();
  for (Process* each : {&a, &b, &c}) {
    each->send(SIGTERM);
    CHECK(each->wait() == 0);
  }
}

}  // namespace
}  // namespace tandem::nats::peer_process_test
