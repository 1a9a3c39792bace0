// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Real datagrams over a bad network: what arrives at a port goes on to another address, and back,
// with the virtual link's seeded delay, jitter, loss, doubling, reordering and rate.
//
//   proxy [--profile N] [--latency MS] [--jitter MS] [--loss P] [--duplicate P] [--reorder P]
//         [--bandwidth BIT_S] [--seed N] [--host ADDRESS] PORT=HOST:PORT...
//
// Options hold for the routes after them. A port of 0 takes a free one; the ports are printed. At
// the end (SIGINT, SIGTERM) it says what became of the datagrams.
#include <algorithm>
#include <array>
#include <asio/buffer.hpp>
#include <asio/io_context.hpp>
#include <asio/ip/udp.hpp>
#include <asio/signal_set.hpp>
#include <charconv>
#include <cstdio>
#include <exception>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "proxy/flow.h"

namespace {

using namespace tandem::demos;
using asio::ip::udp;
using tandem::consensus::LinkOptions;

constexpr std::size_t kMostFlows = 64;            // clients of one route
constexpr std::chrono::seconds kForgetAfter{60};  // a client that is silent

struct Settings {
  LinkOptions link;
  std::uint64_t seed = 1;
  std::string host = "127.0.0.1";  ///< address of the entrance
};

template <class Number>
Number number(std::string_view name, std::string_view text, Number low, Number high) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !(value >= low) ||
      !(value <= high)) {
    throw std::invalid_argument(std::string(name) + " = " + std::string(text) +
                                ": must be a number from " + std::to_string(low) + " to " +
                                std::to_string(high));
  }
  return value;
}

/// One port, and where what comes there goes.
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
    if (flows_.size() == kMostFlows) return;
    // Each flow draws numbers of its own.
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
    throw std::invalid_argument("route = " + std::string(text) + ": must be PORT=HOST:PORT");
  }
  const auto port = number<std::uint16_t>("port", text.substr(0, equals), 0, 65535);
  const std::string host(text.substr(equals + 1, colon - equals - 1));
  const std::string service(text.substr(colon + 1));
  number<std::uint16_t>("target's port", service, 1, 65535);
  const auto found = udp::resolver(io).resolve(udp::v4(), host, service);
  return std::make_unique<Route>(io, settings, port, *found.begin());
}

void set(Settings& settings, std::string_view name, std::string_view value) {
  LinkOptions& link = settings.link;
  if (name == "--profile") {
    const int profile = number(name, value, 0, 5);
    const LinkOptions known =
        profile > 0 ? tandem::consensus::network_profile(profile) : LinkOptions{};
    link.latency = known.latency;
    link.jitter = known.jitter;
  } else if (name == "--latency") {
    link.latency = 1e-3 * number(name, value, 0.0, 1e4);
  } else if (name == "--jitter") {
    link.jitter = 1e-3 * number(name, value, 0.0, 1e4);
  } else if (name == "--loss") {
    link.loss = number(name, value, 0.0, 0.99);
  } else if (name == "--duplicate") {
    link.duplicate = number(name, value, 0.0, 1.0);
  } else if (name == "--reorder") {
    link.reorder = number(name, value, 0.0, 1.0);
  } else if (name == "--bandwidth") {
    link.bandwidth = number(name, value, 0.0, 1e12);
  } else if (name == "--seed") {
    settings.seed = number<std::uint64_t>(name, value, 0, ~std::uint64_t{0});
  } else if (name == "--host") {
    settings.host = value;
  } else {
    throw std::invalid_argument("option = " + std::string(name) + ": is not one of this program's");
  }
}

int run(const std::vector<std::string_view>& arguments) {
  asio::io_context io(1);
  Settings settings;
  std::vector<std::unique_ptr<Route>> routes;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    if (!arguments[i].starts_with("--")) {
      routes.push_back(route(io, settings, arguments[i]));
      std::printf("%u\n", routes.back()->port());
      continue;
    }
    if (i + 1 == arguments.size()) {
      throw std::invalid_argument(std::string(arguments[i]) + ": needs a value");
    }
    set(settings, arguments[i], arguments[i + 1]);
    ++i;
  }
  if (routes.empty()) throw std::invalid_argument("routes: at least one PORT=HOST:PORT");
  std::fflush(stdout);
  asio::signal_set signals(io, SIGINT, SIGTERM);
  signals.async_wait([&](const std::error_code&, int) {
    for (const auto& each : routes) each->end();
  });
  io.run();
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run({argv + 1, argv + argc});
  } catch (const std::exception& error) {
    std::fprintf(stderr, "proxy: %s\n", error.what());
    return 2;
  }
}
