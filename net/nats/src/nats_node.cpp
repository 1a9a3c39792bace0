// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "nats_node.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "node_options.h"
#include "octets.h"
#include "tandem/pbd/bytes.h"

namespace tandem::nats {

namespace crypto = net::crypto;
using net::octets;
namespace {

constexpr std::size_t kSenderBytes = 8;                // before each datagram
constexpr std::int64_t kFollowEvery = 50'000'000;      // ns
constexpr std::int64_t kCoarsePeriod = 500'000'000;    // ns, of levels above 1
constexpr std::int64_t kPartLife = 5'000'000'000;      // ns, of a part's summary
constexpr std::int64_t kPatience = 3'000'000'000;      // ns, for a handshake or a farewell
constexpr std::int64_t kInviteAgain = 15'000'000'000;  // ns, before the same peer is invited again
constexpr std::size_t kMaxInvited = 32;                // within kInviteAgain
constexpr std::int64_t kDoubt = 1'000'000'000;         // ns, to confirm a new session key
constexpr std::size_t kMaxDeparted = 8;                // listed in each step
constexpr std::size_t kMaxPackets = 1024;              // of summaries not drained

net::UdpNodeOptions options_of(const NatsOptions& options, const DirectSocket* direct,
                               std::int64_t now, std::int64_t correction) {
  net::UdpNodeOptions out = net::node_options(options.member);
  out.max_peers = std::min<std::size_t>(1024, 2 * options.cells.max_near + 8);
  out.max_departed = kMaxDeparted;
  out.relay = false;
  out.introduces = false;
  out.path_limit = [](std::uint64_t) { return net::kMaxDatagram; };
  if (direct != nullptr && options.direct_peers > 0) {
    out.direct_addresses = direct->addresses();
    // The MTU of the direct path is unknown.
    out.path_limit = [](std::uint64_t) { return net::MtuSearch::kBase; };
  }
  out.start = now;
  out.correction = correction;
  return out;
}

std::int64_t period(double hz) { return static_cast<std::int64_t>(1e9 / hz); }

}  // namespace

NatsNode::NatsNode(const NatsOptions& options, std::shared_ptr<NatsHub> hub, std::int64_t now,
                   std::int64_t correction, std::function<std::int64_t()> steady)
    : cells_(options.cells),
      self_(options.member.self),
      subjects_(options.prefix, options.member.scene_hash, options.cells),
      hub_(std::move(hub)),
      clocks_{.steady = std::move(steady), .correction = correction},
      node_(options_of(options, hub_->impl().direct(), now, correction), crypto::system_random(),
            [this](std::span<const std::byte> datagram, const net::Address& to) {
              send(datagram, to);
            }),
      hood_(options.cells, options.member.self),
      direct_{.nearest = Nearest(options.direct_peers, options.cells.slack), .hear = nullptr},
      seal_{.sealer = GroupSealer(self_, node_.credentials().incarnation, crypto::system_random()),
            .opener = GroupOpener(now + correction)} {
  if (options.speaker) speaking_.secret.emplace(*options.speaker);
  for (const TrustedSpeaker& each : options.speakers)
    speaking_.trusted[each.peer] = each.public_key;
  for (int level = 1; level < cells_.levels; ++level) levels_.emplace_back(self_, now);
  own_ = subscribe(subjects_.to(self_), Inbox::Kind::Datagram);
  listen_directly();
}

void NatsNode::listen_directly() {
  DirectSocket* const socket = hub_->impl().direct();
  if (socket == nullptr) return;
  direct_.hear = std::make_shared<DirectSocket::Hear>(
      [inbox = direct_.inbox, steady = clocks_.steady](std::span<const std::byte> bytes,
                                                       const net::Address& from) {
        inbox->put(Inbox::Kind::Direct, bytes, steady(), from);
      });
  socket->attach(node_.receiver_prefix(), direct_.hear);
}

NatsOwned<natsSubscription> NatsNode::subscribe(const std::string& subject, Inbox::Kind kind) {
  return hub_->impl().subscribe(
      subject, [inbox = inbox_, steady = clocks_.steady, kind](std::span<const std::byte> bytes) {
        inbox->put(kind, bytes, steady());
      });
}

void NatsNode::send(std::span<const std::byte> datagram, const net::Address& to) {
  if (!net::is_path(to)) {
    DirectSocket* const socket = hub_->impl().direct();
    if (socket == nullptr) return;
    socket->send(datagram, to);
    ++direct_.out;
    direct_.bytes_out += datagram.size();
    return;
  }
  seal_.sealed.clear();
  pbd::ByteWriter writer(seal_.sealed);
  writer.u64(self_);
  writer.bytes(datagram);
  hub_->impl().publish(subjects_.to(net::path_number(to)), seal_.sealed);
}

void NatsNode::tick(std::int64_t now) {
  auto messages = inbox_->take();
  const auto of_server = static_cast<std::ptrdiff_t>(messages.size());
  std::ranges::move(direct_.inbox->take(), std::back_inserter(messages));
  std::ranges::inplace_merge(messages, messages.begin() + of_server, {}, &Inbox::Message::at);
  for (const Inbox::Message& message : messages) {
    // The node's time must not go back, and waiting messages keep their arrival time.
    clocks_.last = std::max(clocks_.last, std::min(message.at, now));
    take_in(message);
  }
  clocks_.last = std::max(clocks_.last, now);
  if (now >= due_.follow) follow(now);
  if (now >= due_.presence) say_where(now);
  speak(now);
  node_.poll(now);
}

void NatsNode::take_in(const Inbox::Message& message) {
  switch (message.kind) {
    case Inbox::Kind::Datagram:
      on_datagram(message);
      break;
    case Inbox::Kind::Direct:
      on_direct(message);
      break;
    case Inbox::Kind::Presence:
      on_presence(message);
      break;
    case Inbox::Kind::Summary:
      on_summary(message);
      break;
  }
}

void NatsNode::on_direct(const Inbox::Message& message) {
  if (!node_.on_datagram(message.bytes, message.from, clocks_.last)) return;
  ++direct_.in;
  direct_.bytes_in += message.bytes.size();
}

void NatsNode::on_datagram(const Inbox::Message& message) {
  pbd::ByteReader reader(message.bytes);
  const PeerId from = reader.u64();
  if (reader.failed() || from == 0 || from == self_) return;
  (void)node_.on_path(std::span(message.bytes).subspan(kSenderBytes), from, clocks_.last);
}

GroupOpener::Opened NatsNode::open(const Inbox::Message& message) {
  const auto connected = [this](PeerId peer) -> std::optional<std::uint64_t> {
    const net::UdpPeers::Record* record = node_.table().record(peer);
    if (record == nullptr || record->connection == nullptr) return std::nullopt;
    return record->incarnation;
  };
  const auto now = clocks_.last + clocks_.correction;
  const auto out = seal_.opener.open(message.bytes, node_.credentials(), now, connected);
  if (out.heard == GroupOpener::Heard::Elsewhen) invite(out.sender, out.key);
  return out;
}

void NatsNode::invite(PeerId peer, std::size_t key) {
  if (peer == self_ || node_.table().attached(peer) != nullptr) return;
  std::erase_if(invited_,
                [this](const auto& each) { return clocks_.last - each.second > kInviteAgain; });
  if (invited_.size() >= kMaxInvited || !invited_.emplace(peer, clocks_.last).second) return;
  amiss_.emplace(peer, clocks_.last);
  node_.dial(net::path_address(peer), clocks_.last, key);
}

void NatsNode::heed_group_change(std::int64_t now) {
  if (seal_.group == node_.credentials().group) return;
  seal_.group = node_.credentials().group;
  hood_.doubt([this](PeerId peer) { return node_.table().attached(peer) == nullptr; },
              now - Neighbourhood::kForget + kDoubt);
}

void NatsNode::on_presence(const Inbox::Message& message) {
  const auto opened = open(message);
  if (opened.heard != GroupOpener::Heard::Now) return;
  const auto presence = decode_presence(opened.plain);
  if (!presence) {
    ++seal_.unbelieved;
  } else if (opened.sender != self_) {
    hood_.hear(opened.sender, *presence, clocks_.last);
  } else if (seal_.sealer.has_sealed(message.bytes)) {
    load_.heard(presence->sent, clocks_.steady());
  }
}

bool NatsNode::is_believed(PeerId sender, const Summary& summary,
                           std::span<const std::byte> plain) const {
  if (speaking_.trusted.empty()) return true;
  const auto trusted = speaking_.trusted.find(sender);
  return trusted != speaking_.trusted.end() &&
         crypto::verify(trusted->second,
                        octets(plain.first(plain.size() - crypto::kSignatureBytes)),
                        summary.signature);
}

void NatsNode::on_summary(const Inbox::Message& message) {
  const auto opened = open(message);
  if (opened.heard != GroupOpener::Heard::Now || opened.sender == self_) return;
  const auto summary = decode_summary(opened.plain);
  if (!summary || summary->cell.level >= cells_.levels ||
      !is_believed(opened.sender, *summary, opened.plain)) {
    ++seal_.unbelieved;
    return;
  }
  const Cell& cell = summary->cell;
  levels_[static_cast<std::size_t>(cell.level) - 1].speaker.hear(cell, opened.sender, clocks_.last);
  if (cell.level + 1 < cells_.levels) {
    Level& above = levels_[static_cast<std::size_t>(cell.level)];
    if (above.of_within == parent_of(cell)) above.people[cell] = {summary->people, clocks_.last};
  }
  const std::vector<std::byte> content(summary->content.begin(), summary->content.end());
  if (summaries_.size() >= NatsTransport::kMaxSummaries) summaries_.erase(summaries_.begin());
  summaries_.push_back({cell, opened.sender, summary->people, content});
  if (content.empty() || packets_.size() >= kMaxPackets) return;
  packets_.push_back(
      {.from = opened.sender, .bytes = content, .received = node_.session_now(clocks_.last)});
}

void NatsNode::follow(std::int64_t now) {
  due_.follow = now + kFollowEvery;
  NatsHub::Impl& hub = hub_->impl();
  const bool connected = hub.connected();
  switch (load_.look(inbox_->dropped() + hub.slow(), connected, now)) {
    case Load::Verdict::Slow:
      hood_.lower_limit();
      break;
    case Load::Verdict::Well:
      hood_.raise_limit();
      break;
    case Load::Verdict::Wait:
      break;
  }
  const Neighbourhood::Changes& changes = hood_.update(connected, now);
  for (const Cell& cell : changes.unlisten) heard_cells_.erase(cell);
  for (const Cell& cell : changes.listen) {
    heard_cells_[cell] = cell.level == 0 ? subscribe(subjects_.who(cell), Inbox::Kind::Presence)
                                         : subscribe(subjects_.summary(cell), Inbox::Kind::Summary);
  }
  // Both ends notice each other at about the same time; the lower id dials.
  for (const PeerId peer : changes.meet)
    if (self_ < peer) node_.dial(net::path_address(peer), now);
  for (const PeerId peer : changes.part) node_.hang_up(peer, "too far away", now);
  heed_group_change(now);
  reconcile(now);
  if (direct_.hear != nullptr) {
    node_.table().prefer_direct(direct_.nearest.choose(hood_.met_peers(), hood_.position()), now);
  }
  for (int level = 1; level < cells_.levels; ++level) {
    Level& each = levels_[static_cast<std::size_t>(level) - 1];
    each.speaker.enter(cell_at(cells_, hood_.position(), level), now);
    listen_within(each, level, now);
  }
}

void NatsNode::reconcile(std::int64_t now) {
  std::map<PeerId, std::int64_t> amiss;
  const auto note = [&](PeerId peer) {
    const auto before = amiss_.find(peer);
    const std::int64_t since = before != amiss_.end() ? before->second : now;
    if (now - since < kPatience) {
      amiss[peer] = since;
    } else {
      node_.hang_up(peer, "too far away", now);
      hood_.lose(peer);
    }
  };
  std::vector<PeerId> unlike;
  node_.table().for_each_attached([&](PeerId peer) {
    if (!hood_.is_met(peer)) unlike.push_back(peer);
  });
  for (const auto& [peer, position] : hood_.met_peers()) {
    if (node_.table().attached(peer) == nullptr) unlike.push_back(peer);
  }
  for (const auto& [peer, at] : invited_) {
    const bool asked = amiss_.contains(peer) && node_.table().attached(peer) == nullptr;
    if (asked && !hood_.is_met(peer)) unlike.push_back(peer);
  }
  for (const PeerId peer : unlike) note(peer);
  amiss_ = std::move(amiss);
}

void NatsNode::publish_sealed(const std::string& subject, std::span<const std::byte> plain) {
  seal_.sealer.seal(plain, node_.credentials().session_key, clocks_.last + clocks_.correction,
                    seal_.sealed);
  hub_->impl().publish(subject, seal_.sealed);
}

void NatsNode::say_where(std::int64_t now) {
  const std::int64_t every = period(cells_.presence_hz);
  // Spread over time, even if peers start together.
  if (due_.presence == INT64_MIN)
    due_.presence = now + static_cast<std::int64_t>(self_ % 16) * every / 16 - every;
  due_.presence = std::max(due_.presence + every, now);
  seal_.plain.clear();
  encode(Presence{.sent = clocks_.steady(), .position = hood_.position(), .hears = hood_.hears()},
         seal_.plain);
  publish_sealed(subjects_.who(cell_at(cells_, hood_.position())), seal_.plain);
  load_.said(now);
}

bool NatsNode::speaks(int level, std::int64_t now) const {
  if (level < 1 || level >= cells_.levels) return false;
  if (!speaking_.trusted.empty() && !(speaking_.trusted.contains(self_) && speaking_.secret))
    return false;
  return levels_[static_cast<std::size_t>(level) - 1].speaker.speaks(now);
}

void NatsNode::listen_within(Level& level, int number, std::int64_t now) {
  const bool wanted = speaks(number, now);
  const Cell cell = level.speaker.cell();
  if (wanted == (level.within != nullptr) && (!wanted || level.of_within == cell)) return;
  level.within.reset();
  level.people.clear();
  level.of_within = {-1, 0, 0};
  if (!wanted) return;
  level.of_within = cell;
  level.within = number == 1 ? subscribe(subjects_.who_within(cell), Inbox::Kind::Presence)
                             : subscribe(subjects_.summaries_within(cell), Inbox::Kind::Summary);
}

std::uint32_t NatsNode::people_of(Level& level, const Cell& cell, std::int64_t now) {
  if (cell.level == 1) return static_cast<std::uint32_t>(hood_.people_in(cell));
  std::erase_if(level.people,
                [now](const auto& entry) { return now - entry.second.second > kPartLife; });
  std::uint64_t sum = 0;
  for (const auto& [part, people] : level.people) sum += people.first;
  return static_cast<std::uint32_t>(std::min<std::uint64_t>(sum, UINT32_MAX));
}

void NatsNode::speak(std::int64_t now) {
  for (int number = 1; number < cells_.levels; ++number) {
    Level& level = levels_[static_cast<std::size_t>(number) - 1];
    const std::int64_t every = number == 1 ? period(cells_.summary_hz) : kCoarsePeriod;
    if (!speaks(number, now) || !level.speaker.due(every, now)) continue;
    const Cell cell = level.speaker.cell();
    Summary summary{.cell = cell, .people = people_of(level, cell, now), .content = level.content};
    seal_.plain.clear();
    encode(summary, seal_.plain);
    if (speaking_.secret)
      summary.signature =
          crypto::sign(*speaking_.secret, octets(std::span(std::as_const(seal_.plain))));
    pbd::ByteWriter(seal_.plain).bytes(std::as_bytes(std::span(summary.signature)));
    publish_sealed(subjects_.summary(cell), seal_.plain);
    if (number + 1 < cells_.levels) {
      Level& above = levels_[static_cast<std::size_t>(number)];
      if (above.of_within == parent_of(cell)) above.people[cell] = {summary.people, now};
    }
  }
}

bool NatsNode::set_summary(int level, std::span<const std::byte> content) {
  if (level < 1 || level >= cells_.levels || content.size() > kMaxContent) return false;
  levels_[static_cast<std::size_t>(level) - 1].content.assign(content.begin(), content.end());
  return true;
}

void NatsNode::drain(std::vector<consensus::Packet>& out) {
  node_.drain(out);
  for (consensus::Packet& packet : packets_) {
    if (node_.table().attached(packet.from) == nullptr) out.push_back(std::move(packet));
  }
  packets_.clear();
}

void NatsNode::take_summaries(std::vector<CellSummary>& out) {
  std::ranges::move(summaries_, std::back_inserter(out));
  summaries_.clear();
}

NatsStatus NatsNode::status() {
  return {.hub = hub_->status(),
          .hears = hood_.hears(),
          .limit = hood_.limit(),
          .met = hood_.met(),
          .direct = node_.table().direct(),
          .contacts = hood_.contacts(),
          .cells = hood_.cells(),
          .lag = load_.lag(),
          .direct_out = direct_.out,
          .direct_bytes_out = direct_.bytes_out,
          .direct_in = direct_.in,
          .direct_bytes_in = direct_.bytes_in,
          .dropped = inbox_->dropped() + direct_.inbox->dropped(),
          .refused = seal_.opener.refused() + seal_.unbelieved,
          .unknown = node_.unknown()};
}

}  // namespace tandem::nats
