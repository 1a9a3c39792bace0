// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <nats/nats.h>

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "direct_socket.h"
#include "job_queue.h"
#include "tandem/nats/hub.h"

namespace tandem::nats {

struct NatsFree {
  void operator()(natsOptions* options) const { natsOptions_Destroy(options); }
  void operator()(natsConnection* connection) const { natsConnection_Destroy(connection); }
  void operator()(natsSubscription* subscription) const { natsSubscription_Destroy(subscription); }
  void operator()(natsMsg* message) const { natsMsg_Destroy(message); }
  void operator()(jsCtx* context) const { jsCtx_Destroy(context); }
  void operator()(jsPubAck* ack) const { jsPubAck_Destroy(ack); }
  void operator()(natsStatistics* counts) const { natsStatistics_Destroy(counts); }
  void operator()(jsStreamInfo* info) const { jsStreamInfo_Destroy(info); }
};
template <class T>
using NatsOwned = std::unique_ptr<T, NatsFree>;

/// Called with a subscription's messages, on a thread of the client library; must not block.
using Hear = std::function<void(std::span<const std::byte>)>;

/// Driven by the hub's thread.
class Driven {
 public:
  virtual ~Driven() = default;
  /// Called every few ms. Must not block.
  virtual void drive() = 0;
};

class __attribute__((visibility("hidden"))) NatsHub::Impl {
 public:
  explicit Impl(const HubOptions& options);
  ~Impl();
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  /// Lost without a server.
  void publish(const std::string& subject, std::span<const std::byte> bytes);
  /// Lasts until the subscription is destroyed, with perhaps one more call at its end: data held by
  /// `hear` lives as long as `hear`. Null if the connection is closed for good.
  NatsOwned<natsSubscription> subscribe(const std::string& subject, Hear hear);

  void attach(Driven& driven);
  /// drive() is not running when this returns.
  void detach(Driven& driven);
  /// Something was posted: drive soon.
  void wake();

  /// Jobs that wait for the server. Those left when the hub is destroyed are not done.
  JobQueue& jobs() { return jobs_; }
  /// A connected server has failed. On the requesting thread.
  void note_failure(const std::string& what, natsStatus status);

  HubStatus status() const;
  /// As status(), without the rest.
  bool connected() const;
  /// Incremented before connected() returns true.
  std::uint64_t reconnects() const;
  /// Life of the connected server, different after each of its starts; 0: none.
  std::uint64_t life() const;
  std::uint64_t slow() const { return slow_; }
  /// Null if there is none.
  DirectSocket* direct() { return direct_.get(); }
  natsConnection* connection() { return connection_.get(); }

 private:
  void run();
  /// Adds the client library's counts.
  void count(HubStatus& out) const;

  const bool driven_by_thread_;
  std::unique_ptr<DirectSocket> direct_;
  NatsOwned<natsConnection> connection_;
  std::atomic<std::uint64_t> lost_ = 0;
  std::atomic<std::uint64_t> slow_ = 0;
  mutable std::mutex counting_;
  NatsOwned<natsStatistics> statistics_;  ///< scratch
  std::string reason_;

  std::mutex mutex_;
  std::condition_variable woken_;
  std::vector<Driven*> all_;
  std::atomic<bool> awake_ = false;
  bool stop_ = false;
  std::thread thread_;

  JobQueue jobs_;
};

}  // namespace tandem::nats
