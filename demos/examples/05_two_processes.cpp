// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Two processes over TCP, in two terminals:
//   05_two_processes listen 7777
//   05_two_processes connect localhost:7777
// The second one starts with its cube half a metre off; each ends once both copies are one.
#include <cstdio>
#include <exception>
#include <string>

#include "tandem/net/session.h"
#include "tandem/net/tcp.h"
#include "tandem/session.h"

using namespace tandem;

/// Distance between both copies, whenever the other was heard; read at each step.
class Watch final : public consensus::PeerObserver {
 public:
  explicit Watch(const pbd::World& world, pbd::BodyId body) : world_(world), body_(body) {}
  void on_estimate(const consensus::EstimateEvent& event) override {
    const double apart = (world_.pose(body_).position - event.position).norm();
    if (heard++ % 60 == 0) std::printf("%d: other copy %.4f m away\n", heard, apart);
    last = event.context.now;
    if (apart > 1e-3 || heard == 1) close_since = last;
  }
  /// s, for which both copies have been within a millimetre.
  double together() const { return net::seconds(last - close_since); }
  /// True if they stayed together long enough, or the other peer has gone.
  bool over(consensus::SessionTime now) const {
    return together() >= 3.0 || (heard > 0 && net::seconds(now - last) > 1.0);
  }

  int heard = 0;
  consensus::SessionTime last = 0;  // ns
  consensus::SessionTime close_since = 0;

 private:
  const pbd::World& world_;
  pbd::BodyId body_;
};

int run(bool listens, const std::string& where) {
  net::TcpOptions options;
  options.self = listens ? 1 : 2;
  options.listen_address = "127.0.0.1";
  options.listen_port = listens ? static_cast<std::uint16_t>(std::stoi(where)) : 0;
  if (!listens) options.connect = {net::parse_host_port(where)};
  net::TcpTransport transport(options);
  if (listens) std::printf("port %d\n", static_cast<int>(transport.local_port()));
  std::fflush(stdout);

  // Without shapes a world and a solver are enough.
  pbd::World world({.gravity = pbd::Vec3::Zero()});
  pbd::Solver solver;
  const pbd::BodyId body = world.add_body(
      {.pose = {.position = pbd::Vec3(listens ? 0.0 : 0.5, 0.0, 0.0)}, .linear_damping = 1.0});
  Session session({world, solver}, transport);
  session.share("cube", body);
  Watch watch(world, body);
  session.peer().set_observer(&watch);

  const SessionTime start = session.now();
  session.run([&](SessionTime now) {  // Ctrl-C leaves the session in order
    if (watch.over(now) || net::seconds(now - start) > 30.0) session.stop();
  });
  std::printf("heard %d times, together for %.1f s, at x = %.3f m\n", watch.heard, watch.together(),
              world.pose(body).position.x());
  return watch.together() >= 2.0 ? 0 : 1;
}

int main(int argc, char** argv) {
  try {
    if (argc == 3) return run(std::string(argv[1]) == "listen", argv[2]);
    std::puts("usage: 05_two_processes listen PORT | connect HOST:PORT");
  } catch (const std::exception& error) {
    std::puts(error.what());
  }
  return 2;
}
