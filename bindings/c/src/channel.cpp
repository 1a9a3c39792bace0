// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "convert.h"
#include "guard.h"
#include "sharing.h"
#include "tandem/consensus/events.h"
#include "transport_impl.h"

using namespace tandem;
using namespace tandem::c;

struct tandem_channel {
  explicit tandem_channel(consensus::Transport& below) : channel(below) {
    transport.transport = &channel;
  }
  consensus::EventChannel channel;
  tandem_transport transport;
};

tandem_channel* tandem_channel_create(tandem_transport* transport, tandem_error* error) {
  return made_by(error,
                 [&] { return new tandem_channel(*required(transport, "transport").transport); });
}

void tandem_channel_destroy(tandem_channel* channel) { delete channel; }

tandem_transport* tandem_channel_transport(tandem_channel* channel) {
  return channel != nullptr ? &channel->transport : nullptr;
}

tandem_result tandem_channel_poll(tandem_channel* channel, int64_t now_ns, tandem_error* error) {
  return guarded(
      error, [&] { required(channel, "channel").channel.poll(checked_time("now_ns", now_ns, 1)); });
}

tandem_result tandem_channel_send(tandem_channel* channel, const char* topic, const void* payload,
                                  size_t size, uint64_t to, tandem_error* error) {
  return guarded(error, [&] {
    const auto* const bytes = static_cast<const std::byte*>(payload);
    if (size > 0) required(bytes, "payload");
    required(channel, "channel").channel.send(&required(topic, "topic"), {bytes, size}, to);
  });
}

size_t tandem_channel_events(const tandem_channel* channel, tandem_event* events, size_t capacity) {
  if (channel == nullptr) return 0;
  const auto received = channel->channel.received();
  for (size_t i = 0; i < received.size() && i < capacity && events != nullptr; ++i) {
    events[i] = to_c(received[i]);
  }
  return received.size();
}
