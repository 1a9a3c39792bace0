// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <arpa/inet.h>
#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "support/eventually.h"
#include "support/folder.h"
#include "support/free_port.h"

extern char** environ;

namespace tandem::nats::testing {

/// Debian installs it outside users' paths.
inline std::string server_program() {
  for (const char* path :
       {"/usr/sbin/nats-server", "/usr/bin/nats-server", "/usr/local/bin/nats-server"}) {
    if (access(path, X_OK) == 0) return path;
  }
  return {};
}

/// A nats-server of the test's own on loopback, with JetStream in a folder of the test's.
class Server {
 public:
  Server() { start(); }
  ~Server() { kill(); }
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  void start() {
    const std::string program = server_program();
    const std::string port = std::to_string(port_);
    const std::string store = folder_.file("jetstream");
    std::vector<std::string> words = {program, "-a", "127.0.0.1", "-p", port, "-js", "-sd", store};
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, 2, "/dev/null", O_WRONLY, 0);
    REQUIRE(posix_spawn(&pid_, program.c_str(), &actions, nullptr, arguments.data(), environ) == 0);
    posix_spawn_file_actions_destroy(&actions);
    REQUIRE(tandem::testing::eventually([this] { return answers(); }));
  }
  /// At once, as a crash does.
  void kill() { end(SIGKILL); }
  /// Keeps a copy of what it has stored by now, which lose() brings back.
  void keep() {
    end(SIGTERM);
    std::filesystem::remove_all(folder_.file("kept"));
    std::filesystem::copy(folder_.file("jetstream"), folder_.file("kept"),
                          std::filesystem::copy_options::recursive);
    start();
  }
  /// Kills it; all that it has acknowledged since keep() is lost, and all where that was not
  /// called. So does a machine that fails, since nats-server 2.9 syncs its files every two minutes.
  void lose() {
    kill();
    std::filesystem::remove_all(folder_.file("jetstream"));
    if (!std::filesystem::exists(folder_.file("kept"))) return;
    std::filesystem::copy(folder_.file("kept"), folder_.file("jetstream"),
                          std::filesystem::copy_options::recursive);
  }
  std::uint16_t port() const { return port_; }

 private:
  void end(int signal) {
    if (pid_ <= 0) return;
    ::kill(pid_, signal);
    waitpid(pid_, nullptr, 0);
    pid_ = -1;
  }
  bool answers() const {
    const int fd = socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(port_);
    const bool connected =
        connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
    close(fd);
    return connected;
  }

  tandem::testing::Folder folder_;
  std::uint16_t port_ = tandem::testing::free_port();
  pid_t pid_ = -1;
};

/// Whether there is a server to start; says so where there is none.
inline bool has_server() {
  if (!server_program().empty()) return true;
  WARN("SKIPPED: nats-server is not installed (cmake/install-deps.sh --with-cluster)");
  return false;
}

}  // namespace tandem::nats::testing
