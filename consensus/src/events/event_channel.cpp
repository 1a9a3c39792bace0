// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <algorithm>
#include <deque>
#include <utility>

#include "common/ranges.h"
#include "common/session_time.h"
#include "events/event_wire.h"
#include "tandem/consensus/events.h"
#include "tandem/consensus/update.h"
#include "tandem/pbd/token_bucket.h"
#include "tandem/pbd/validate.h"

namespace tandem::consensus {
namespace {

/// Bytes in flight to one peer without an acknowledgement: a quarter of the receiver's default
/// budget per second, so that events refused by a slow peer are not sent again and again.
constexpr std::size_t kWindow = 64 * 1024;

/// Round trips after which an acknowledgement is late: a reliable packet that is lost once takes
/// two.
constexpr std::int64_t kLateTrips = 4;

/// ns, interval at which an idle channel looks for peers: that costs the transport a list.
constexpr SessionTime kIdle = 1'000'000'000;

/// Bytes charged for each event beside its contents.
constexpr std::size_t kOverhead = 64;

}  // namespace

void EventOptions::validate() const {
  using pbd::detail::require;
  require(kept_bytes >= 1024, "EventOptions", "kept_bytes", static_cast<double>(kept_bytes),
          ">= 1024");
  require(bytes_per_s >= 1024.0 && bytes_per_s <= 1e12, "EventOptions", "bytes_per_s", bytes_per_s,
          "from 1024 to 1e12");
  require(resend > 0.0 && resend <= 3600.0, "EventOptions", "resend", resend,
          "above 0 and at most 3600 s");
  require(absence >= 0.0 && absence <= 86400.0, "EventOptions", "absence", absence,
          "from 0 to 86400 s");
}

class __attribute__((visibility("hidden"))) EventChannel::Impl {
 public:
  struct Content {
    SessionTime stamp = 0;
    std::string topic;
    std::vector<std::byte> payload;
    std::size_t bytes() const { return topic.size() + payload.size() + kOverhead; }
  };

  /// Another peer: events waiting for it, and how far its own were received.
  struct Other {
    PeerId id = 0;
    bool connected = false;
    SessionTime seen = 0;  ///< ns, when it was last connected
    std::int64_t round_trip = -1;

    SessionTime epoch = 0;     ///< ns, when the list was begun
    std::uint64_t first = 0;   ///< number of the first event kept
    std::uint64_t posted = 0;  ///< number of the next event to post
    SessionTime progress = 0;  ///< ns, of the last transmission or acknowledgement
    std::size_t bytes = 0;     ///< of the events kept
    std::deque<std::shared_ptr<const Content>> kept;

    SessionTime heard_epoch = -kMaxStamp;
    std::uint64_t next = 0;  ///< number of the next expected event
    bool owes = false;       ///< whether an acknowledgement is due
    pbd::TokenBucket budget;
  };

  Impl(Transport& below, const EventOptions& given) : transport(below), options(given) {}

  /// Receive packets and separate events from the rest.
  void pull() {
    const std::size_t before = passed.size();
    transport.drain(passed);
    const auto rest =
        std::stable_partition(passed.begin() + static_cast<std::ptrdiff_t>(before), passed.end(),
                              [](const Packet& packet) { return !is_event_packet(packet.bytes); });
    arrived.insert(arrived.end(), std::make_move_iterator(rest),
                   std::make_move_iterator(passed.end()));
    passed.erase(rest, passed.end());
  }
  void meet();
  bool is_idle() const {
    return arrived.empty() && std::none_of(others.begin(), others.end(), [](const Other& other) {
             return other.owes || !other.kept.empty();
           });
  }
  void take(const Packet& packet);
  void take_event(const EventMessage& message, const Packet& packet, Other& from);
  void keep(Other& to, const std::shared_ptr<const Content>& content);
  void send_due(Other& to);
  bool post(const Other& to, std::uint64_t number);

  Transport& transport;
  EventOptions options;
  SessionTime now = 0;
  SessionTime met = -kIdle;   ///< ns, when the peers were last listed
  std::vector<Other> others;  ///< by id
  std::vector<Event> received;
  std::vector<Packet> passed;   ///< for drain()
  std::vector<Packet> arrived;  ///< events, until the next poll()
  std::vector<std::byte> buffer;
  std::uint64_t lost = 0;
  std::uint64_t rejected = 0;
};

/// Update which peers are connected, and drop those absent for too long.
void EventChannel::Impl::meet() {
  met = now;
  const std::vector<PeerStatus> peers = transport.peers();
  for (Other& other : others) other.connected = false;
  for (const PeerStatus& peer : peers) {
    if (!peer.connected) continue;
    auto at = ranges::lower_bound(others, peer.id, &Other::id);
    if (at == others.end() || at->id != peer.id) {
      at = others.insert(at, Other{});
      at->id = peer.id;
      at->epoch = now;
      at->budget = pbd::TokenBucket(options.bytes_per_s, options.bytes_per_s);
    }
    at->connected = true;
    at->seen = now;
    at->round_trip = peer.round_trip;
  }
  std::erase_if(others, [&](const Other& other) {
    return !other.connected && now - other.seen > to_ns(options.absence);
  });
}

void EventChannel::Impl::take(const Packet& packet) {
  const auto at = ranges::lower_bound(others, packet.from, &Other::id);
  if (at == others.end() || at->id != packet.from) return;  // it has left
  const auto message = decode_event(packet.bytes);
  if (!message) {
    ++rejected;
    return;
  }
  if (message->kind == EventMessage::Kind::Event) return take_event(*message, packet, *at);
  const bool known = message->epoch == at->epoch && message->number > at->first &&
                     message->number - at->first <= at->kept.size();
  if (!known) return;
  for (; at->first < message->number; ++at->first) {
    at->bytes -= at->kept.front()->bytes();
    at->kept.pop_front();
  }
  at->posted = std::max(at->posted, at->first);
  at->progress = now;
}

void EventChannel::Impl::take_event(const EventMessage& message, const Packet& packet,
                                    Other& from) {
  if (!from.budget.fill(now)) return;  // the sender will repeat it
  from.budget.spend(static_cast<double>(packet.bytes.size() + kOverhead));
  if (message.epoch != from.heard_epoch) {  // the sender restarted, or dropped its list for this
                                            // peer
    from.heard_epoch = message.epoch;
    from.next = message.first;
  }
  if (message.first > from.next) {
    lost += message.first - from.next;
    from.next = message.first;
  }
  from.owes = true;
  if (message.number != from.next) return;
  ++from.next;
  received.push_back({.from = packet.from,
                      .role = packet.role,
                      .stamp = message.stamp,
                      .topic = std::string(message.topic),
                      .payload = {message.payload.begin(), message.payload.end()}});
}

void EventChannel::Impl::keep(Other& to, const std::shared_ptr<const Content>& content) {
  to.kept.push_back(content);
  to.bytes += content->bytes();
  while (to.bytes > options.kept_bytes && to.kept.size() > 1) {
    to.bytes -= to.kept.front()->bytes();
    to.kept.pop_front();
    ++to.first;
    ++lost;
  }
  to.posted = std::max(to.posted, to.first);
}

bool EventChannel::Impl::post(const Other& to, std::uint64_t number) {
  const Content& content = *to.kept[static_cast<std::size_t>(number - to.first)];
  buffer.clear();
  encode({.kind = EventMessage::Kind::Event,
          .epoch = to.epoch,
          .number = number,
          .first = to.first,
          .stamp = content.stamp,
          .topic = content.topic,
          .payload = content.payload},
         buffer);
  return transport.post(to.id, buffer, Delivery::Reliable);
}

void EventChannel::Impl::send_due(Other& to) {
  if (!to.connected) return;
  if (std::exchange(to.owes, false)) {
    buffer.clear();
    encode(
        {.kind = EventMessage::Kind::Acknowledgement, .epoch = to.heard_epoch, .number = to.next},
        buffer);
    transport.post(to.id, buffer, Delivery::Newest);
  }
  if (to.posted == to.first) {
    to.progress = now;
  } else if (now - to.progress > std::max(to_ns(options.resend), kLateTrips * to.round_trip)) {
    to.posted = to.first;  // go back: all from there on again, in order
    to.progress = now;
  }
  std::size_t on_its_way = 0;
  for (std::size_t i = 0; i < to.kept.size() && on_its_way < kWindow; ++i) {
    const std::uint64_t number = to.first + i;
    if (number == to.posted) {
      if (!post(to, number)) return;
      ++to.posted;
    }
    on_its_way += to.kept[i]->bytes();
  }
}

EventChannel::EventChannel(Transport& transport, const EventOptions& options) {
  options.validate();
  impl_ = std::make_unique<Impl>(transport, options);
}
EventChannel::~EventChannel() = default;

std::size_t EventChannel::send(std::string_view topic, std::span<const std::byte> payload,
                               PeerId to) {
  const std::size_t most = max_packet_bytes(Delivery::Reliable) - kEventBytes - topic.size();
  if (topic.size() > kMaxTopicBytes) {
    pbd::detail::refuse("EventChannel::send: bytes of topic", "at most 64",
                        static_cast<double>(topic.size()));
  }
  if (payload.size() > most) {
    pbd::detail::refuse("EventChannel::send: bytes of payload", "at most " + std::to_string(most),
                        static_cast<double>(payload.size()));
  }
  const auto content = std::make_shared<const Impl::Content>(
      Impl::Content{impl_->now, std::string(topic), {payload.begin(), payload.end()}});
  impl_->meet();
  std::size_t count = 0;
  for (Impl::Other& other : impl_->others) {
    if (to != kToAll && other.id != to) continue;
    impl_->keep(other, content);
    ++count;
  }
  return count;
}

void EventChannel::poll(SessionTime now) {
  impl_->pull();
  impl_->now = now;
  if (!impl_->is_idle() || now < impl_->met || now - impl_->met >= kIdle) impl_->meet();
  impl_->received.clear();
  for (const Packet& packet : impl_->arrived) impl_->take(packet);
  impl_->arrived.clear();
  for (Impl::Other& other : impl_->others) impl_->send_due(other);
}

std::span<const Event> EventChannel::received() const { return impl_->received; }
std::uint64_t EventChannel::lost() const { return impl_->lost; }
std::uint64_t EventChannel::rejected() const { return impl_->rejected; }

PeerId EventChannel::self() const { return impl_->transport.self(); }
bool EventChannel::post(PeerId to, std::span<const std::byte> bytes, Delivery delivery) {
  return impl_->transport.post(to, bytes, delivery);
}
std::size_t EventChannel::max_packet_bytes(Delivery delivery) const {
  return impl_->transport.max_packet_bytes(delivery);
}
void EventChannel::drain(std::vector<Packet>& out) {
  impl_->pull();
  out.insert(out.end(), std::make_move_iterator(impl_->passed.begin()),
             std::make_move_iterator(impl_->passed.end()));
  impl_->passed.clear();
}
void EventChannel::drop(PeerId peer, const std::string& reason) {
  impl_->transport.drop(peer, reason);
}
void EventChannel::list_peers(std::vector<PeerStatus>& out) const {
  impl_->transport.list_peers(out);
}
std::vector<PeerStatus> EventChannel::peers() const { return impl_->transport.peers(); }

}  // namespace tandem::consensus
