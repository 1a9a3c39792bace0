// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Simulates a bad network: forwards datagrams from a port to another address and back, with the
// virtual link's seeded delay, jitter, loss, duplication, reordering and rate.
#include <algorithm>
#include <array>
#include <asio/buffer.hpp>
#include <asio/io_context.hpp>
#include <asio/ip/udp.hpp>
#include <asio/signal_set.hpp>
#include <cstdio>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "arguments/arguments.h"
#include "proxy/flow.h"

namespace {

using namespace tandem::demos;
using asio::ip::udp;
using tandem::consensus::LinkOptions;

constexpr std::size_t kMaxFlows = 64;             // clients per route
constexpr std::chrono::seconds kForgetAfter{60};  // of a client's silence

constexpr std::string_view kUsage =
    "usage: proxy [options] PORT=HOST:PORT...\n"
    "Forwards datagrams from each port to another address, and back. A port of 0 takes a free "
    "one;\n"
    "the ports are printed. Ctrl-c ends it and prints counts of the datagrams. Options hold for\n"
    "the routes after them:\n"
    "  --profile 0..5    latency and jitter: 0, 3.5, 6, 28.5, 63.5 or 123.5 ms one way (0)\n"
    "  --latency MS --jitter MS\n"
    "  --loss P --duplicate P --reorder P   chances for each datagram (0)\n"
    "  --bandwidth B     bit/s in each direction (0 = unlimited)\n"
    "  --seed N          of all random numbers (1)\n"
    "  --host ADDRESS    of the ports (127.0.0.1)\n";

struct Settings {
  LinkOptions link;
  std::uint64_t seed = 1;
  std::string host = "127.0.0.1";  ///< address of the entrance
};

/// One port, and its target.
class Route {
 public:
  Route(asio::io_context& io, const Settings& settings, std::uint16_t port,
        const udp::endpoint& target)
      : io_(io),
        settings_(settings),
        target_(target),
        entrance_(io, udp::endpoint(asio::ip::make_address(settings.host), port)) {
    receive();
  }
  std::uint16_t port() const { return entrance_.local_endpoint().port(); }
  void end() {
    std::error_code ignored;
    entrance_.close(ignored);
    for (const auto& flow : flows_) {
      for (const auto& way : flow->counters()) add(way);
      flow->end();
    }
    std::printf(
        "port %u to %s:%u: %llu in, %llu out, %llu lost, %llu doubled, %llu held back, "
        "%llu over the rate\n",
        port_, target_.address().to_string().c_str(), target_.port(),
        static_cast<unsigned long long>(total_.posted),
        static_cast<unsigned long long>(total_.delivered),
        static_cast<unsigned long long>(total_.lost),
        static_cast<unsigned long long>(total_.duplicated),
        static_cast<unsigned long long>(total_.held_back),
        static_cast<unsigned long long>(total_.queue_full));
  }

 private:
  void receive() {
    entrance_.async_receive_from(asio::buffer(buffer_), client_,
                                 [this](const std::error_code& error, std::size_t size) {
                                   if (!entrance_.is_open()) return;
                                   if (!error) take(std::span(buffer_).first(size));
                                   receive();
                                 });
  }

  void take(std::span<const std::byte> datagram) {
    for (const auto& flow : flows_) {
      if (flow->client() == client_) {
        flow->forward(datagram);
        return;
      }
    }
    const auto now = Flow::Clock::now();
    std::erase_if(flows_, [&](const std::shared_ptr<Flow>& flow) {
      const bool gone = now - flow->last_heard() > kForgetAfter;
      if (gone) {
        for (const auto& way : flow->counters()) add(way);
        flow->end();
      }
      return gone;
    });
    if (flows_.size() == kMaxFlows) return;
    // Each flow has its own random numbers.
    flows_.push_back(std::make_shared<Flow>(io_, entrance_, client_, target_, settings_.link,
                                            settings_.seed + 1000 * made_++));
    flows_.back()->begin();
    flows_.back()->forward(datagram);
  }

  void add(const tandem::consensus::LinkCounters& way) {
    total_.posted += way.posted;
    total_.delivered += way.delivered;
    total_.lost += way.lost;
    total_.duplicated += way.duplicated;
    total_.held_back += way.held_back;
    total_.queue_full += way.queue_full;
  }

  asio::io_context& io_;
  Settings settings_;
  udp::endpoint target_;
  udp::socket entrance_;
  std::uint16_t port_ = entrance_.local_endpoint().port();
  udp::endpoint client_;
  std::vector<std::shared_ptr<Flow>> flows_;
  std::uint64_t made_ = 0;
  tandem::consensus::LinkCounters total_;
  std::array<std::byte, 65536> buffer_{};
};

std::unique_ptr<Route> route(asio::io_context& io, const Settings& settings,
                             std::string_view text) {
  const std::size_t equals = text.find('=');
  const std::size_t colon = text.rfind(':');
  if (equals == std::string_view::npos || colon == std::string_view::npos || colon < equals) {
    refuse("a route", text, "PORT=HOST:PORT");
  }
  const auto port = number<std::uint16_t>("the port of a route", text.substr(0, equals), 0, 65535,
                                          "from 0 (any) to 65535");
  const std::string host(text.substr(equals + 1, colon - equals - 1));
  const std::string service(text.substr(colon + 1));
  number<std::uint16_t>("the target's port", service, 1, 65535, "from 1 to 65535");
  const auto found = udp::resolver(io).resolve(udp::v4(), host, service);
  return std::make_unique<Route>(io, settings, port, *found.begin());
}

std::vector<Option> link_options(Settings& settings) {
  LinkOptions& link = settings.link;
  const auto chance = [](std::string_view name, double most, double& into) {
    return Option{name, [=, &into](Argument& in) {
                    into = in.number(0.0, most, most < 1.0 ? "from 0 to 0.99" : "from 0 to 1");
                  }};
  };
  const auto milliseconds = [](std::string_view name, double& into) {
    return Option{name, [&into](Argument& in) {
                    into = 1e-3 * in.number(0.0, 1e4, "a number from 0 to 10000 ms");
                  }};
  };
  return {{"--profile",
           [&link](Argument& in) {
             const int profile = in.number(0, 5, "an integer from 0 to 5");
             const LinkOptions known =
                 profile > 0 ? tandem::consensus::network_profile(profile) : LinkOptions{};
             link.latency = known.latency;
             link.jitter = known.jitter;
           }},
          milliseconds("--latency", link.latency),
          milliseconds("--jitter", link.jitter),
          chance("--loss", 0.99, link.loss),
          chance("--duplicate", 1.0, link.duplicate),
          chance("--reorder", 1.0, link.reorder),
          {"--bandwidth",
           [&link](Argument& in) {
             link.bandwidth = in.number(0.0, 1e12, "a number from 0 to 1e12 bit/s");
           }},
          {"--seed",
           [&settings](Argument& in) {
             settings.seed = in.number(std::uint64_t{0}, ~std::uint64_t{0}, "an integer >= 0");
           }},
          {"--host", [&settings](Argument& in) { settings.host = in.text(); }}};
}

int run(std::span<const std::string_view> words) {
  asio::io_context io(1);
  Settings settings;
  std::vector<std::unique_ptr<Route>> routes;
  read_arguments(words, link_options(settings), [&](std::string_view word) {
    routes.push_back(route(io, settings, word));
    std::printf("%u\n", routes.back()->port());
  });
  if (routes.empty()) throw UsageError("at least one PORT=HOST:PORT must be given");
  std::fflush(stdout);
  asio::signal_set signals(io, SIGINT, SIGTERM);
  signals.async_wait([&](const std::error_code&, int) {
    for (const auto& each : routes) each->end();
  });
  io.run();
  return 0;
}

}  // namespace

int main(int argc, char** argv) { return program_main(argc, argv, kUsage, run); }
