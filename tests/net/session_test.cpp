// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/net/session.h"

#ifdef _WIN32
#include <windows.h>
#endif

#include <csignal>
#include <stdexcept>
#include <string>

#include "raw_peer.h"
#include "support/catch.h"

namespace session_test {

using namespace tandem::net;

TEST_CASE("session: addresses are read and written alike", "[net][unit]") {
  CHECK(parse_host_port("localhost:5000") == HostPort{"localhost", 5000});
  CHECK(parse_host_port("10.0.0.7:1") == HostPort{"10.0.0.7", 1});
  CHECK(parse_host_port("[::1]:65535") == HostPort{"::1", 65535});
  for (const std::string address : {"localhost:5000", "10.0.0.7:1", "[::1]:65535"}) {
    CHECK(to_string(parse_host_port(address)) == address);
  }
}

TEST_CASE("session: an invalid address is refused with its text", "[net][fault]") {
  for (const std::string text :
       {"", ":", "localhost", "localhost:", ":5000", "localhost:0", "localhost:65536",
        "localhost:-1", "localhost:80x", "::1:80", "[]:80", "localhost: 80"}) {
    CHECK_THROWS_WITH(parse_host_port(text), Catch::Matchers::Contains('"' + text + '"'));
  }
}

TEST_CASE("session: a signal stops, and leaves nothing behind", "[net][unit]") {
  for (const int signal : {SIGINT, SIGTERM}) {
    StopSignal stop;
    CHECK_FALSE(stop.requested());
    CHECK_FALSE(stop.wait(std::chrono::nanoseconds(1)));
    std::raise(signal);
    CHECK(stop.wait(std::chrono::seconds(20)));
    CHECK(stop.requested());
  }
  // From the first use on the process keeps a pipe for signals, whoever listens: counted after it.
  const raw::LeakCheck leaks;
  StopSignal stop;
  stop.request();
  CHECK(stop.requested());
}

#ifdef _WIN32
TEST_CASE("session: a console that closes stops", "[net][unit]") {
  StopSignal stop;
  // Windows runs this in a thread of each process of the console. The thread stays until the
  // process ends.
  const auto routine = reinterpret_cast<LPTHREAD_START_ROUTINE>(
      reinterpret_cast<void*>(GetProcAddress(GetModuleHandleW(L"kernelbase"), "CtrlRoutine")));
  REQUIRE(routine != nullptr);
  const auto event = reinterpret_cast<void*>(static_cast<std::uintptr_t>(CTRL_CLOSE_EVENT));
  const HANDLE thread = CreateThread(nullptr, 0, routine, event, 0, nullptr);
  REQUIRE(thread != nullptr);
  CHECK(stop.wait(std::chrono::seconds(20)));
  CHECK(WaitForSingleObject(thread, 100) == WAIT_TIMEOUT);  // it would end the process
  CloseHandle(thread);
}
#endif

}  // namespace session_test
