// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "event_store.h"

#include <algorithm>

#include "group_seal.h"
#include "octets.h"
#include "tandem/pbd/bytes.h"

namespace tandem::nats {

namespace {

constexpr std::int64_t kEventPatience = 1000;          // ms
constexpr std::size_t kMaxAtOnce = 4096;               // events per read
constexpr std::int64_t kLongestAge = 120'000'000'000;  // ns, of names that the server remembers
constexpr std::uint8_t kEvent = 3;  // presences and summaries, under the same key, are 1 and 2

}  // namespace

void encode(const NumberedEvent& event, std::vector<std::byte>& out) {
  pbd::ByteWriter writer(out);
  writer.u8(kEvent);
  writer.u64(event.source);
  writer.u64(event.number);
  writer.u32(static_cast<std::uint32_t>(event.event.cell.x));
  writer.u32(static_cast<std::uint32_t>(event.event.cell.y));
  writer.i64(event.event.stamp);
  writer.u8(static_cast<std::uint8_t>(event.event.topic.size()));
  writer.bytes(std::as_bytes(std::span(event.event.topic)));
  writer.bytes(event.event.payload);
}

std::optional<NumberedEvent> decode_event(std::span<const std::byte> bytes) {
  pbd::ByteReader reader(bytes);
  NumberedEvent out;
  const bool right = reader.u8() == kEvent;
  out.source = reader.u64();
  out.number = reader.u64();
  out.event.cell.x = static_cast<std::int32_t>(reader.u32());
  out.event.cell.y = static_cast<std::int32_t>(reader.u32());
  out.event.stamp = reader.i64();
  const std::size_t topic = reader.u8();
  if (topic > CellEvents::kMaxTopicBytes) return std::nullopt;
  for (const std::byte each : reader.bytes(topic)) {
    out.event.topic.push_back(static_cast<char>(each));
  }
  if (!right || reader.failed() || reader.remaining() > CellEvents::kMaxPayloadBytes) {
    return std::nullopt;
  }
  const auto payload = reader.bytes(reader.remaining());
  out.event.payload.assign(payload.begin(), payload.end());
  return out;
}

bool EventLog::is_new(const NumberedEvent& event) {
  const auto known = sources_.find(event.source);
  if (known != sources_.end() && event.number <= known->second.latest) return false;
  if (known == sources_.end() && sources_.size() >= kMaxSources) {
    sources_.erase(std::ranges::min_element(sources_, {},
                                            [](const auto& entry) { return entry.second.heard; }));
  }
  sources_[event.source] = {event.number, ++turn_};
  return true;
}

EventStore::EventStore(NatsHub::Impl& hub, const Subjects& subjects,
                       const CellEventOptions& options)
    : hub_(hub),
      subjects_(subjects),
      session_key_(options.session_key),
      kept_(std::chrono::nanoseconds(options.kept).count()),
      stream_(stream_name(subjects.base(), "events")) {}

bool EventStore::open() {
  const std::uint64_t now = hub_.life();
  if (now == 0) return false;
  if (open_ == now) return true;
  if (context_ == nullptr) {
    jsOptions options;
    jsOptions_Init(&options);
    options.Wait = kEventPatience;
    jsCtx* made = nullptr;
    if (natsConnection_JetStream(&made, hub_.connection(), &options) != NATS_OK) return false;
    context_.reset(made);
  }
  const std::string all = subjects_.base() + "ev.>";
  const char* const texts = all.c_str();
  jsStreamConfig config;
  jsStreamConfig_Init(&config);
  config.Name = stream_.c_str();
  config.Subjects = const_cast<const char**>(&texts);
  config.SubjectsLen = 1;
  config.MaxAge = kept_;
  config.Duplicates = std::min(kept_, kLongestAge);
  config.AllowDirect = true;
  jsStreamInfo* info = nullptr;
  // An existing identical stream is no error.
  const natsStatus status = js_AddStream(&info, context_.get(), &config, nullptr, nullptr);
  const NatsOwned<jsStreamInfo> owned(info);
  if (status != NATS_OK) hub_.note_failure("keep the stream " + stream_, status);
  open_ = status == NATS_OK ? now : 0;
  return open_ != 0;
}

bool EventStore::write(const Cell& cell, const std::string& name,
                       std::span<const std::byte> sealed) {
  if (!open()) return false;
  jsPubOptions options;
  jsPubOptions_Init(&options);
  options.MaxWait = kEventPatience;
  options.MsgId = name.c_str();
  jsPubAck* made = nullptr;
  const natsStatus status = js_Publish(&made, context_.get(), subject(cell).c_str(), sealed.data(),
                                       static_cast<int>(sealed.size()), &options, nullptr);
  const NatsOwned<jsPubAck> ack(made);
  if (status != NATS_OK) {
    hub_.note_failure("write to the stream " + stream_, status);
    open_ = 0;  // a server that has lost its store has no stream either
    return false;
  }
  hub_.publish(news(cell), {});
  return true;
}

bool EventStore::read(const Cell& cell, EventLog& log,
                      const std::function<bool(const CellEvent&)>& found) {
  if (!open()) return false;
  // A server that has lost events reuses their sequences.
  if (log.life != open_) log.next = 1;
  log.life = open_;
  const std::string all = subject(cell);
  for (std::size_t i = 0; i < kMaxAtOnce; ++i) {
    jsDirectGetMsgOptions options;
    jsDirectGetMsgOptions_Init(&options);
    options.Sequence = log.next;
    options.NextBySubject = all.c_str();
    natsMsg* made = nullptr;
    const natsStatus status =
        js_DirectGetMsg(&made, context_.get(), stream_.c_str(), nullptr, &options);
    const NatsOwned<natsMsg> message(made);
    if (status == NATS_NOT_FOUND) return true;
    if (status != NATS_OK) {
      hub_.note_failure("read the stream " + stream_, status);
      open_ = 0;
      return false;
    }
    log.next = natsMsg_GetSequence(made) + 1;
    const std::span bytes(reinterpret_cast<const std::byte*>(natsMsg_GetData(made)),
                          static_cast<std::size_t>(natsMsg_GetDataLength(made)));
    // Duplicates are recognised by the numbers within, which hold for all lives of a server.
    const auto opened = open_group_record(bytes, session_key_);
    auto event = opened ? decode_event(opened->plain) : std::nullopt;
    if (!event || event->event.cell != cell) {
      ++refused_;
      continue;
    }
    if (!log.is_new(*event)) continue;
    event->event.from = opened->sender;
    if (!found(event->event)) return true;
  }
  return true;
}

}  // namespace tandem::nats
