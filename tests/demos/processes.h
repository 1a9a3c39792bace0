// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <fcntl.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <string>
#include <vector>

#include "support/catch.h"
#include "support/eventually.h"
#include "support/folder.h"
#include "support/free_port.h"

extern char** environ;

namespace tandem::demos {

using testing::Folder;
using testing::free_port;

/// A running program of the build. It ends with the object.
class Process {
 public:
  /// @param out  file for what it prints; "" = ours
  Process(const std::string& program, const std::vector<std::string>& arguments,
          const std::string& out = "") {
    std::vector<std::string> words{std::string(TANDEM_DEMO_FOLDER) + program};
    words.insert(words.end(), arguments.begin(), arguments.end());
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    REQUIRE(posix_spawn_file_actions_init(&actions) == 0);
    if (!out.empty()) {
      posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, out.c_str(),
                                       O_WRONLY | O_CREAT | O_TRUNC, 0600);
    }
    const int error = posix_spawn(&pid_, argv[0], &actions, nullptr, argv.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    REQUIRE(error == 0);
  }
  ~Process() {
    if (pid_ > 0) kill();
  }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  void kill() {
    send(SIGKILL);
    wait();
  }
  void send(int signal) { ::kill(pid_, signal); }
  /// As waitpid has it.
  int wait() {
    int status = 0;
    waitpid(pid_, &status, 0);
    pid_ = -1;
    return status;
  }

 private:
  pid_t pid_ = -1;
};

using tandem::testing::eventually;

/// The number of `key` within the object `object` of a result.
inline double number(const Folder& folder, const std::string& file, const std::string& object,
                     const std::string& key) {
  const std::string json = folder.text(file);
  const std::size_t begin = json.find('"' + object + "\":");
  REQUIRE(begin != std::string::npos);
  const std::size_t at = json.find('"' + key + "\":", begin);
  REQUIRE(at != std::string::npos);
  return std::strtod(json.c_str() + at + key.size() + 3, nullptr);
}

}  // namespace tandem::demos
