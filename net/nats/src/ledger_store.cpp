// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "ledger_store.h"

#include <array>
#include <cstring>
#include <string_view>
#include <utility>

#include "octets.h"
#include "tandem/pbd/bytes.h"

namespace tandem::nats {

namespace {

using Result = LedgerStore::Result;
using consensus::SharedId;

constexpr std::int64_t kAnswerTime = 1000;  // ms
constexpr std::size_t kMaxInCell = 4096;    // bodies that are read
constexpr std::size_t kNewsHeader = 32;     // the id and the place, before the record
constexpr int kAttempts = 8;                // to write, against concurrent writers of the same body
constexpr int kWrongLastSequence = 10071;   // error code of the server

std::string text_of(const SharedId& id) { return hex(id.high) + hex(id.low); }

std::span<const std::byte> data_of(const natsMsg* message) {
  return {reinterpret_cast<const std::byte*>(natsMsg_GetData(message)),
          static_cast<std::size_t>(natsMsg_GetDataLength(message))};
}

}  // namespace

LedgerStore::LedgerStore(NatsHub::Impl& hub, const Subjects& subjects,
                         const net::crypto::Secret& session_key)
    : hub_(hub),
      subjects_(subjects),
      session_key_(session_key),
      random_(net::crypto::system_random()),
      stream_(stream_name(subjects.base(), "ledger")) {}

Result LedgerStore::open() {
  const std::uint64_t now = hub_.life();
  if (now == 0) return Result::NoServer;
  if (open_ == now) return Result::Done;
  if (context_ == nullptr) {
    jsOptions options;
    jsOptions_Init(&options);
    options.Wait = kAnswerTime;
    jsCtx* made = nullptr;
    if (natsConnection_JetStream(&made, hub_.connection(), &options) != NATS_OK) {
      return Result::NoServer;
    }
    context_.reset(made);
  }
  const std::string records = subjects_.base() + "body.*";
  const std::string index = subjects_.base() + "in.>";
  std::array<const char*, 2> both{records.c_str(), index.c_str()};
  jsStreamConfig config;
  jsStreamConfig_Init(&config);
  config.Name = stream_.c_str();
  config.Subjects = both.data();
  config.SubjectsLen = static_cast<int>(both.size());
  config.MaxMsgsPerSubject = 1;
  config.AllowDirect = true;
  jsStreamInfo* info = nullptr;
  // An existing identical stream is no error.
  const natsStatus status = js_AddStream(&info, context_.get(), &config, nullptr, nullptr);
  const NatsOwned<jsStreamInfo> owned(info);
  if (status != NATS_OK) hub_.note_failure("keep the stream " + stream_, status);
  open_ = status == NATS_OK ? now : 0;
  return open_ != 0 ? Result::Done : Result::NoServer;
}

std::string LedgerStore::record_subject(const SharedId& id) const {
  return subjects_.base() + "body." + text_of(id);
}

std::string LedgerStore::index_subject(const Cell& cell, const std::string& id) const {
  return subjects_.base() + "in." + subjects_.path(cell) + "." + id;
}

Result LedgerStore::publish(const std::string& subject, std::span<const std::byte> bytes,
                            const std::uint64_t* follows, std::uint64_t& sequence) {
  jsPubOptions options;
  jsPubOptions_Init(&options);
  options.MaxWait = kAnswerTime;
  if (follows != nullptr && *follows > 0) options.ExpectLastSubjectSeq = *follows;
  if (follows != nullptr && *follows == 0) options.ExpectNoMessage = true;
  jsPubAck* made = nullptr;
  jsErrCode error{};
  const natsStatus status = js_Publish(&made, context_.get(), subject.c_str(), bytes.data(),
                                       static_cast<int>(bytes.size()), &options, &error);
  const NatsOwned<jsPubAck> ack(made);
  if (status == NATS_OK) {
    sequence = ack->Sequence;
    return Result::Done;
  }
  if (static_cast<int>(error) == kWrongLastSequence) return Result::Refused;
  hub_.note_failure("write to the stream " + stream_, status);
  open_ = 0;  // a server that has lost its store has no stream either
  return Result::NoServer;
}

Result LedgerStore::read(const SharedId& id, StoredRecord& out) {
  const std::string subject = record_subject(id);
  jsDirectGetMsgOptions options;
  jsDirectGetMsgOptions_Init(&options);
  options.LastBySubject = subject.c_str();
  natsMsg* made = nullptr;
  const natsStatus status =
      js_DirectGetMsg(&made, context_.get(), stream_.c_str(), nullptr, &options);
  const NatsOwned<natsMsg> message(made);
  out = {};
  if (status == NATS_NOT_FOUND) return Result::Done;
  if (status != NATS_OK) {
    hub_.note_failure("read the stream " + stream_, status);
    return Result::NoServer;
  }
  const auto opened = open_record(data_of(made), id, session_key_);
  if (!opened) return Result::Refused;  // under a session key that is not known here
  out = *opened;
  out.place = {open_, natsMsg_GetSequence(made)};
  return Result::Done;
}

Result LedgerStore::write(StoredRecord& record, const StoredRecord& before) {
  if (open() != Result::Done) return Result::NoServer;
  const std::uint64_t life = open_;
  const std::string id = text_of(record.record.id);
  const Cell cell = record.record.cell;
  std::vector<std::byte> sealed;
  seal_record(record.record, record.token, session_key_, random_, sealed);
  // A restarted server may have lost a record, and reused its sequence for another one.
  bool sure = before.record.revision == 0 || before.place.life == life;
  StoredRecord stands = before;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    if (!sure) {
      const Result result = read(record.record.id, stands);
      if (result == Result::NoServer) return result;
      const bool later =
          stands.version() > before.version() && stands.version() != record.version();
      if (later || result == Result::Refused) {
        record = later ? stands : before;
        return Result::Refused;
      }
    }
    std::uint64_t sequence = 0;
    // The index of the new cell comes first: the body is found there once the record says so.
    if (!sure || before.record.revision == 0 || cell != before.record.cell) {
      const Result result = publish(index_subject(cell, id), {}, nullptr, sequence);
      if (result != Result::Done) return Result::NoServer;
    }
    sequence = stands.place.sequence;
    const bool there = stands.version() == record.version();
    const Result result =
        there ? Result::Done
              : publish(record_subject(record.record.id), sealed, &sequence, sequence);
    if (result == Result::NoServer) return result;
    if (result == Result::Refused) {
      sure = false;  // a lost answer, or another writer was first
      continue;
    }
    record.place = {life, sequence};
    if (there && record.version() == before.version()) return Result::Done;
    tell(record, sealed, cell);
    for (const StoredRecord* older : {&before, &std::as_const(stands)}) {
      if (older->record.revision == 0 || older->record.cell == cell) continue;
      tell(record, sealed, older->record.cell);
      take_back(index_subject(older->record.cell, id), sequence);
      if (stands.record.cell == before.record.cell) break;
    }
    return Result::Done;
  }
  return Result::NoServer;
}

void LedgerStore::take_back(const std::string& subject, std::uint64_t sequence) {
  jsOptions options;
  jsOptions_Init(&options);
  options.Wait = kAnswerTime;
  options.Stream.Purge.Subject = subject.c_str();
  // A later return of the body was written after this record.
  options.Stream.Purge.Sequence = sequence;
  // If that fails, an index stays that no record confirms.
  js_PurgeStream(context_.get(), stream_.c_str(), &options, nullptr);
}

void LedgerStore::tell(const StoredRecord& record, std::span<const std::byte> sealed,
                       const Cell& cell) {
  std::vector<std::byte> bytes;
  pbd::ByteWriter writer(bytes);
  writer.u64(record.record.id.high);
  writer.u64(record.record.id.low);
  writer.u64(record.place.life);
  writer.u64(record.place.sequence);
  writer.bytes(sealed);
  hub_.publish(news(cell), bytes);
}

std::optional<StoredRecord> LedgerStore::read_news(std::span<const std::byte> bytes) const {
  pbd::ByteReader reader(bytes);
  SharedId id;
  id.high = reader.u64();
  id.low = reader.u64();
  Place place;
  place.life = reader.u64();
  place.sequence = reader.u64();
  if (reader.failed()) return std::nullopt;
  auto opened = open_record(bytes.subspan(kNewsHeader), id, session_key_);
  if (opened) opened->place = place;
  return opened;
}

Result LedgerStore::look(const Cell& cell, const std::function<void(const StoredRecord&)>& found) {
  if (open() != Result::Done) return Result::NoServer;
  const std::string all = index_subject(cell, "*");
  std::uint64_t next = 1;
  for (std::size_t i = 0; i < kMaxInCell; ++i) {
    jsDirectGetMsgOptions options;
    jsDirectGetMsgOptions_Init(&options);
    options.Sequence = next;
    options.NextBySubject = all.c_str();
    natsMsg* made = nullptr;
    const natsStatus status =
        js_DirectGetMsg(&made, context_.get(), stream_.c_str(), nullptr, &options);
    const NatsOwned<natsMsg> message(made);
    if (status == NATS_NOT_FOUND) return Result::Done;
    if (status != NATS_OK) {
      hub_.note_failure("read the stream " + stream_, status);
      return Result::NoServer;
    }
    next = natsMsg_GetSequence(made) + 1;
    const std::string_view subject = natsMsg_GetSubject(made);
    const auto id = SharedId::parse(subject.substr(subject.rfind('.') + 1));
    if (!id) continue;
    StoredRecord record;
    const Result result = read(*id, record);
    if (result == Result::NoServer) return result;
    if (record.place.sequence > 0 && record.record.cell == cell) found(record);
  }
  return Result::Done;
}

}  // namespace tandem::nats
