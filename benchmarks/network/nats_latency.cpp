// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Throughput of one NATS server for messages of a session's size, and latency at a part of that:
//
//   nats_latency PORT [BYTES] [PART]
//
// Four connections exchange messages. First as fast as they can: messages received per second are
// the server's saturation, with its clients on the same machine. Then at PART of it (0.7), in
// bursts of a millisecond; latency is from a message's due time to its delivery.
#include <nats/nats.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace {

using Clock = std::chrono::steady_clock;

constexpr int kConnections = 4;
constexpr std::chrono::seconds kFast{4};
constexpr std::chrono::seconds kPaced{8};

std::int64_t now_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(Clock::now().time_since_epoch())
      .count();
}

void check(natsStatus status, const char* what) {
  if (status == NATS_OK) return;
  std::fprintf(stderr, "%s: %s\n", what, natsStatus_GetText(status));
  std::exit(1);
}

struct End {
  std::atomic<bool>* measures = nullptr;
  natsConnection* connection = nullptr;
  natsSubscription* subscription = nullptr;
  std::atomic<std::uint64_t> heard = 0;
  std::mutex mutex;
  std::vector<std::int64_t> late;  ///< ns
};

struct Ends {
  std::array<End, kConnections> all;
  std::atomic<bool> measures = false;

  End& operator[](int i) { return all[static_cast<std::size_t>(i)]; }
};

void on_message(natsConnection*, natsSubscription*, natsMsg* message, void* closure) {
  End& end = *static_cast<End*>(closure);
  ++end.heard;
  if (*end.measures) {
    std::int64_t due = 0;
    std::memcpy(&due, natsMsg_GetData(message), sizeof due);
    const std::scoped_lock lock(end.mutex);
    end.late.push_back(now_ns() - due);
  }
  natsMsg_Destroy(message);
}

void say(Ends& ends, int from, int to, std::vector<char>& bytes, std::int64_t due) {
  std::memcpy(bytes.data(), &due, sizeof due);
  const std::string subject = "latency." + std::to_string(to);
  natsConnection_Publish(ends[from].connection, subject.c_str(), bytes.data(),
                         static_cast<int>(bytes.size()));
}

std::uint64_t heard(const Ends& ends) {
  std::uint64_t sum = 0;
  for (const End& end : ends.all) sum += end.heard;
  return sum;
}

/// Messages received per second at maximum load.
double saturation(Ends& ends, std::size_t bytes) {
  // With more in flight the server would drop slow receivers.
  constexpr std::uint64_t kUnderWay = 20000;
  std::atomic<bool> stop = false;
  std::atomic<std::uint64_t> said = 0;
  std::vector<std::thread> threads;
  for (int i = 0; i < kConnections; ++i) {
    threads.emplace_back([i, bytes, &ends, &stop, &said] {
      std::vector<char> payload(bytes);
      for (int k = 0; !stop; ++k) {
        if (said - heard(ends) > kUnderWay) {
          std::this_thread::sleep_for(std::chrono::microseconds(200));
          continue;
        }
        ++said;
        say(ends, i, (i + 1 + k % (kConnections - 1)) % kConnections, payload, 0);
      }
    });
  }
  std::this_thread::sleep_for(kFast / 4);
  const std::uint64_t before = heard(ends);
  const auto began = Clock::now();
  std::this_thread::sleep_for(kFast);
  const double rate = static_cast<double>(heard(ends) - before) /
                      std::chrono::duration<double>(Clock::now() - began).count();
  stop = true;
  for (std::thread& thread : threads) thread.join();
  return rate;
}

void pace(Ends& ends, std::size_t bytes, double rate) {
  std::vector<std::thread> threads;
  for (int i = 0; i < kConnections; ++i) {
    threads.emplace_back([i, bytes, rate, &ends] {
      std::vector<char> payload(bytes);
      const auto began = Clock::now();
      double owed = 0.0;
      for (int tick = 0; Clock::now() - began < kPaced; ++tick) {
        const auto due = began + std::chrono::milliseconds(tick);
        std::this_thread::sleep_until(due);
        const std::int64_t when =
            std::chrono::duration_cast<std::chrono::nanoseconds>(due.time_since_epoch()).count();
        owed += 1e-3 * rate / kConnections;
        for (int k = 0; owed >= 1.0; ++k, owed -= 1.0) {
          say(ends, i, (i + 1 + k % (kConnections - 1)) % kConnections, payload, when);
        }
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    std::puts("usage: nats_latency PORT [BYTES] [PART]");
    return 2;
  }
  const std::string url = "nats://127.0.0.1:" + std::string(argv[1]);
  const auto bytes = static_cast<std::size_t>(argc > 2 ? std::atoi(argv[2]) : 130);
  const double part = argc > 3 ? std::atof(argv[3]) : 0.7;
  Ends ends;
  for (int i = 0; i < kConnections; ++i) {
    End& end = ends[i];
    end.measures = &ends.measures;
    check(natsConnection_ConnectTo(&end.connection, url.c_str()), "connect");
    const std::string subject = "latency." + std::to_string(i);
    check(natsConnection_Subscribe(&end.subscription, end.connection, subject.c_str(), on_message,
                                   &end),
          "subscribe");
    natsSubscription_SetPendingLimits(end.subscription, -1, -1);
    check(natsConnection_Flush(end.connection), "flush");
  }
  const double most = saturation(ends, std::max(bytes, sizeof(std::int64_t)));
  // Drain queued messages first.
  for (std::uint64_t last = 0; last != heard(ends);) {
    last = heard(ends);
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
  }
  for (const double load : {0.1, part}) {
    ends.measures = true;
    pace(ends, std::max(bytes, sizeof(std::int64_t)), load * most);
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
    ends.measures = false;
    std::vector<std::int64_t> late;
    for (End& end : ends.all) {
      const std::scoped_lock lock(end.mutex);
      late.insert(late.end(), end.late.begin(), end.late.end());
      end.late.clear();
    }
    if (late.empty()) {
      std::puts("nothing arrived");
      continue;
    }
    std::ranges::sort(late);
    const auto at = [&](double q) {
      return 1e-6 * static_cast<double>(
                        late[static_cast<std::size_t>(q * static_cast<double>(late.size() - 1))]);
    };
    std::printf(
        "saturation %.0f messages/s of %zu bytes; at %.0f %%: p50 %.3f, p95 %.3f, p99 %.3f ms\n",
        most, bytes, 100.0 * load, at(0.5), at(0.95), at(0.99));
  }
  // Libraries' threads may still be delivering: exit without cleanup.
  std::fflush(stdout);
  std::_Exit(0);
}
