// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "ledger_store.h"

#include <array>
#include <cstring>
#include <string_view>

#include "octets.h"
#include "tandem/pbd/bytes.h"

namespace tandem::nats {

namespace {

using Result = LedgerStore::Result;
using consensus::SharedId;

constexpr std::int64_t kAnswerTime = 1000;  // ms
constexpr std::size_t kMaxInCell = 4096;    // bodies that are looked at
constexpr std::size_t kNewsHeader = 16;     // the id, before the record
constexpr int kWrongLastSequence = 10071;   // of the server's error codes

std::string text_of(const SharedId& id) { return hex(id.high) + hex(id.low); }

std::span<const std::byte> data_of(const natsMsg* message) {
  return {reinterpret_cast<const std::byte*>(natsMsg_GetData(message)),
          static_cast<std::size_t>(natsMsg_GetDataLength(message))};
}

/// Names of streams have no dots.
std::string stream_of(std::string base) {
  for (char& c : base) c = c == '.' ? '_' : c;
  return base + "ledger";
}

}  // namespace

LedgerStore::LedgerStore(NatsHub::Impl& hub, const Subjects& subjects,
                         const net::crypto::Secret& session_key)
    : hub_(hub),
      subjects_(subjects),
      session_key_(session_key),
      random_(net::crypto::system_random()),
      stream_(stream_of(subjects.base())) {}

Result LedgerStore::open() {
  if (open_) return Result::Done;
  if (natsConnection_Status(hub_.connection()) != NATS_CONN_STATUS_CONNECTED) {
    return Result::NoServer;
  }
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
  // The same again is no error.
  const natsStatus status = js_AddStream(&info, context_.get(), &config, nullptr, nullptr);
  const NatsOwned<jsStreamInfo> owned(info);
  open_ = status == NATS_OK;
  return open_ ? Result::Done : Result::NoServer;
}

std::string LedgerStore::record_subject(const SharedId& id) const {
  return subjects_.base() + "body." + text_of(id);
}

std::string LedgerStore::index_subject(const Cell& cell, const std::string& id) const {
  return subjects_.base() + "in." + subjects_.path(cell) + "." + id;
}

Result LedgerStore::publish(const std::string& subject, std::span<const std::byte> bytes,
                            const std::uint64_t* follows, std::uint64_t& revision) {
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
    revision = ack->Sequence;
    return Result::Done;
  }
  if (static_cast<int>(error) == kWrongLastSequence) return Result::Refused;
  open_ = false;  // a server that has lost its store has no stream either
  return Result::NoServer;
}

LedgerStore::Read LedgerStore::read(const SharedId& id) {
  const std::string subject = record_subject(id);
  jsDirectGetMsgOptions options;
  jsDirectGetMsgOptions_Init(&options);
  options.LastBySubject = subject.c_str();
  natsMsg* made = nullptr;
  const natsStatus status =
      js_DirectGetMsg(&made, context_.get(), stream_.c_str(), nullptr, &options);
  const NatsOwned<natsMsg> message(made);
  if (status == NATS_NOT_FOUND) return {Result::Done, std::nullopt};
  if (status != NATS_OK) return {};
  auto opened = open_record(data_of(made), id, session_key_);
  if (opened) opened->record.revision = natsMsg_GetSequence(made);
  return {Result::Done, std::move(opened)};
}

Result LedgerStore::write(LedgerRecord& record, const Cell& from) {
  if (open() != Result::Done) return Result::NoServer;
  const std::string id = text_of(record.id);
  Token token = 0;
  random_({reinterpret_cast<std::uint8_t*>(&token), sizeof token});
  std::vector<std::byte> sealed;
  seal_record(record, token, session_key_, random_, sealed);
  std::uint64_t revision = 0;
  // First the index of where it will be: it is looked for there as soon as the record says so.
  if (record.cell != from || record.revision == 0) {
    if (publish(index_subject(record.cell, id), {}, nullptr, revision) != Result::Done) {
      return Result::NoServer;
    }
  }
  const Result result = publish(record_subject(record.id), sealed, &record.revision, revision);
  if (result != Result::Done) {
    // An answer that was lost, or somebody else was first.
    const Read now = read(record.id);
    if (now.result != Result::Done || !now.record) return Result::NoServer;
    if (now.record->token != token) {
      if (result != Result::Refused) return Result::NoServer;
      record = now.record->record;
      return Result::Refused;
    }
    revision = now.record->record.revision;
  }
  record.revision = revision;
  tell(record, token, from);
  if (record.cell != from) take_back(index_subject(from, id), revision);
  return Result::Done;
}

void LedgerStore::take_back(const std::string& subject, std::uint64_t revision) {
  jsOptions options;
  jsOptions_Init(&options);
  options.Wait = kAnswerTime;
  options.Stream.Purge.Subject = subject.c_str();
  // Whoever has brought the body back meanwhile has said so after this record.
  options.Stream.Purge.Sequence = revision;
  // Where that fails an index stays that no record confirms.
  js_PurgeStream(context_.get(), stream_.c_str(), &options, nullptr);
}

void LedgerStore::tell(const LedgerRecord& record, Token token, const Cell& from) {
  // Sealed anew: now its revision is known.
  std::vector<std::byte> sealed;
  seal_record(record, token, session_key_, random_, sealed);
  std::vector<std::byte> bytes;
  pbd::ByteWriter writer(bytes);
  writer.u64(record.id.high);
  writer.u64(record.id.low);
  writer.bytes(sealed);
  hub_.publish(news(record.cell), bytes);
  if (from != record.cell) hub_.publish(news(from), bytes);
}

std::optional<LedgerRecord> LedgerStore::read_news(std::span<const std::byte> bytes) const {
  pbd::ByteReader reader(bytes);
  SharedId id;
  id.high = reader.u64();
  id.low = reader.u64();
  if (reader.failed()) return std::nullopt;
  const auto opened = open_record(bytes.subspan(kNewsHeader), id, session_key_);
  return opened ? std::optional(opened->record) : std::nullopt;
}

Result LedgerStore::look(const Cell& cell, const std::function<void(const LedgerRecord&)>& found) {
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
    if (status != NATS_OK) return Result::NoServer;
    next = natsMsg_GetSequence(made) + 1;
    const std::string_view subject = natsMsg_GetSubject(made);
    const auto id = SharedId::parse(subject.substr(subject.rfind('.') + 1));
    if (!id) continue;
    const Read record = read(*id);
    if (record.result != Result::Done) return record.result;
    if (record.record && record.record->record.cell == cell) found(record.record->record);
  }
  return Result::Done;
}

}  // namespace tandem::nats
