// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// The long-running peer as a process, in wall time.
#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include <csignal>
#include <string>
#include <vector>

#include "processes.h"
#include "support/catch.h"

namespace tandem::demos::peer_process_test {
namespace {

/// Answer of a web server on loopback; empty if there is none.
std::string fetch(int port, const std::string& path) {
  const int fd = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  std::string answer;
  if (connect(fd, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0) {
    const std::string request = "GET " + path + " HTTP/1.1\r\nHost: localhost\r\n\r\n";
    send(fd, request.data(), request.size(), 0);
    char part[4096];
    for (ssize_t n = 0; (n = recv(fd, part, sizeof part, 0)) > 0;) {
      answer.append(part, static_cast<std::size_t>(n));
    }
  }
  close(fd);
  return answer;
}

/// The value of a metric, "name{labels} value"; -1 where it is not there.
double metric(const std::string& page, const std::string& name) {
  const std::size_t at = page.find('\n' + name + ' ');
  return at == std::string::npos ? -1.0 : std::strtod(page.c_str() + at + name.size() + 2, nullptr);
}

std::string config(int id, const std::string& network, int metrics) {
  std::string text = "id = " + std::to_string(id) + "\n[network]\n" + network +
                     "[user]\nfidget = true\n[log]\nfile = \"" + std::to_string(id) + ".log\"\n";
#ifdef TANDEM_HAS_METRICS
  text += "[metrics]\nport = " + std::to_string(metrics) + '\n';
#else
  static_cast<void>(metrics);
#endif
  return text;
}

/// Two of them find each other, tell it, and one leaves in order; both are replayed bit for bit.
void hold_session(const Folder& folder, const std::string& first, const std::string& second) {
  const int port_a = free_port();
  const int port_b = free_port();
  Process a("tandem-peer", {"cubes", "--trace", folder.file("1.trace"), "--config",
                            folder.write("1.toml", config(1, first, port_a))});
  Process b("tandem-peer", {"cubes", "--trace", folder.file("2.trace"), "--config",
                            folder.write("2.toml", config(2, second, port_b))});
  REQUIRE(eventually([&] {
    return folder.text("1.log").find("event=peer_connected peer=2") != std::string::npos &&
           folder.text("2.log").find("event=peer_connected peer=1") != std::string::npos;
  }));
#ifdef TANDEM_HAS_METRICS
  const std::string divergence = "tandem_peer_divergence_metres_count{peer=\"2\"}";
  CHECK(eventually([&] { return metric(fetch(port_a, "/metrics"), divergence) > 1000.0; }));
  const std::string page = fetch(port_a, "/metrics");
  CHECK(page.starts_with("HTTP/1.1 200 OK"));
  CHECK(metric(page, "tandem_peers_connected") == 1.0);
  CHECK(metric(page, "tandem_peer_connected{peer=\"2\"}") == 1.0);
  CHECK(metric(page, "tandem_packets_received_total{peer=\"2\"}") > 10.0);
  CHECK(metric(page, "tandem_packets_rejected_total{peer=\"2\"}") == 0.0);
  CHECK(metric(page, "tandem_step_seconds{quantile=\"0.99\"}") > 0.0);
  CHECK(metric(page, "tandem_faults_total") == 0.0);
  CHECK(fetch(port_a, "/").starts_with("HTTP/1.1 404"));
#endif
  b.send(SIGTERM);
  CHECK(b.wait() == 0);
  CHECK(folder.text("2.log").find("event=stopped") != std::string::npos);
  CHECK(eventually(
      [&] { return folder.text("1.log").find("event=peer_lost peer=2") != std::string::npos; }));
  a.send(SIGINT);
  CHECK(a.wait() == 0);
  CHECK(folder.text("1.log").find("level=error") == std::string::npos);
  // With a session key alone it says what one member could do.
  const bool open = first.find("insecure") == std::string::npos;
  CHECK((folder.text("1.log").find("event=no_lists") != std::string::npos) == open);
  for (const char* trace : {"1.trace", "2.trace"}) {
    Process replay("tandem-replay", {folder.file(trace)}, folder.file("said"));
    CHECK(replay.wait() == 0);
    CHECK(folder.text("said").find(" steps, bit-exact\n") != std::string::npos);
  }
}

#ifdef TANDEM_HAS_METRICS
TEST_CASE("tandem-peer: slow clients keep nobody from its metrics, and a port in use is said",
          "[demos][socket][fault]") {
  const Folder folder;
  const int port = free_port();
  const std::string network = "listen = " + std::to_string(free_port()) + "\ninsecure = true\n";
  Process peer("tandem-peer",
               {"cubes", "--config", folder.write("1.toml", config(1, network, port))});
  REQUIRE(eventually([&] { return !fetch(port, "/metrics").empty(); }));
  // More than it serves at a time, who begin a request and never end it.
  std::vector<int> slow;
  for (int i = 0; i < 40; ++i) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    slow.push_back(socket(AF_INET, SOCK_STREAM, 0));
    REQUIRE(connect(slow.back(), reinterpret_cast<sockaddr*>(&address), sizeof address) == 0);
    send(slow.back(), "GET", 3, 0);
  }
  CHECK(fetch(port, "/metrics").starts_with("HTTP/1.1 200 OK"));
  for (const int fd : slow) close(fd);

  Process second("tandem-peer",
                 {"cubes", "--config", folder.write("2.toml", config(2, network, port))},
                 folder.file("said"));
  CHECK(second.wait() != 0);
  peer.send(SIGTERM);
  CHECK(peer.wait() == 0);
}
#endif

TEST_CASE("tandem-peer: two of them hold a session over TCP with a key", "[demos][socket]") {
#ifndef TANDEM_HAS_UDP
  WARN("skipped: built without libsodium");
#else
  const Folder folder;
  folder.write("key", std::string(64, 'b'));
  const std::string port = std::to_string(free_port());
  hold_session(folder, "transport = \"tcp\"\nlisten = " + port + "\nkey = \"key\"\n",
               "transport = \"tcp\"\nconnect = [\"127.0.0.1:" + port + "\"]\nkey = \"key\"\n");
#endif
}

TEST_CASE("tandem-peer: two of them hold a session over TCP, tell of it and leave in order",
          "[demos][socket]") {
  const Folder folder;
  const std::string port = std::to_string(free_port());
  hold_session(folder, "transport = \"tcp\"\ninsecure = true\nlisten = " + port + '\n',
               "transport = \"tcp\"\ninsecure = true\nconnect = [\"127.0.0.1:" + port + "\"]\n");
}

TEST_CASE("tandem-peer: two of them hold a session over UDP, encrypted", "[demos][socket]") {
#ifndef TANDEM_HAS_UDP
  WARN("skipped: built without libsodium");
#else
  const Folder folder;
  folder.write("key", std::string(64, 'b'));
  const std::string port = std::to_string(free_port(SOCK_DGRAM));
  hold_session(folder, "listen = " + port + "\nkey = \"key\"\n",
               "connect = [\"127.0.0.1:" + port + "\"]\nkey = \"key\"\n");
#endif
}

TEST_CASE("tandem-peer: a file that is not good ends it at once, with 2", "[demos][fault]") {
  const Folder folder;
  Process bad("tandem-peer", {"cubes", "--config", folder.write("bad.toml", "id = 0\n")});
  CHECK(WEXITSTATUS(bad.wait()) == 2);
  Process unknown("tandem-peer", {"chess", "--config", folder.file("bad.toml")});
  CHECK(WEXITSTATUS(unknown.wait()) == 2);
  const std::string good = folder.write("good.toml",
                                        "id = 1\n[network]\nlisten = 0\n"
                                        "transport = \"tcp\"\ninsecure = true\n");
  Process check("tandem-peer", {"room", "--config", good, "--check"});
  CHECK(check.wait() == 0);
}

}  // namespace
}  // namespace tandem::demos::peer_process_test
