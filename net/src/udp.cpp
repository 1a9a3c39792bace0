// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/net/udp.h"

#include <utility>

#include "node_options.h"
#include "require.h"
#include "udp_socket.h"

namespace tandem::net {

void UdpOptions::validate() const {
  const auto check = [](bool ok, const char* field, auto value, const char* rule) {
    require(ok, "UdpOptions", field, value, rule);
  };
  check(self != 0, "self", self, "not 0");
  check(!listen_address.empty(), "listen_address", listen_address, "an address");
  for (const HostPort& peer : connect) {
    check(!peer.host.empty() && peer.port != 0, "connect", to_string(peer), "HOST:PORT");
  }
  // Keys do not appear in error messages.
  check(session_key != Key{}, "session_key", std::string("zero"), "secret");
  for (const TrustedPeer& each : trusted) {
    check(each.peer != 0 && each.peer != self, "trusted", each.peer, "ids of other peers");
  }
  require_credentials(*this, "UdpOptions");
  check(kbit_per_s >= 8.0 && kbit_per_s <= 1e6, "kbit_per_s", kbit_per_s, "in [8, 1e6]");
  check(min_kbit_per_s > 0.0 && min_kbit_per_s <= kbit_per_s, "min_kbit_per_s", min_kbit_per_s,
        "in (0, kbit_per_s]");
  check(max_datagram >= 548 && max_datagram <= kMaxDatagram, "max_datagram", max_datagram,
        "in [548, 1472]");
  check(max_message_bytes >= 64 && max_message_bytes <= 1024 * 1024, "max_message_bytes",
        max_message_bytes, "in [64, 1 MiB]");
  check(state_queue_bytes >= 2048, "state_queue_bytes", state_queue_bytes, ">= 2048");
  check(reliable_queue_bytes >= 2 * max_message_bytes, "reliable_queue_bytes", reliable_queue_bytes,
        ">= 2 * max_message_bytes");
  check(receive_queue_bytes >= 2 * max_message_bytes, "receive_queue_bytes", receive_queue_bytes,
        ">= 2 * max_message_bytes");
  check(max_peers >= 1 && max_peers <= 1024, "max_peers", max_peers, "in [1, 1024]");
  require_times(*this, "UdpOptions");
}

class __attribute__((visibility("hidden"))) UdpTransport::Impl final : public UdpSocket {
 public:
  explicit Impl(const UdpOptions& options) : UdpSocket(options, node_options(options)) {}
};

UdpTransport::UdpTransport(const UdpOptions& options) : impl_(std::make_unique<Impl>(options)) {}
UdpTransport::~UdpTransport() = default;

void UdpTransport::connect(std::shared_ptr<DatagramPath> path) {
  require(path != nullptr, "UdpTransport::connect", "path", 0, "a path");
  impl_->connect(std::move(path));
}

void UdpTransport::disconnect(const DatagramPath& path) { impl_->disconnect(path); }

consensus::PeerId UdpTransport::self() const { return impl_->options().self; }

bool UdpTransport::post(consensus::PeerId to, std::span<const std::byte> bytes,
                        consensus::Delivery delivery) {
  return impl_->with(
      true, [&](UdpNode& node, std::int64_t now) { return node.post(to, bytes, delivery, now); });
}

std::size_t UdpTransport::max_packet_bytes(consensus::Delivery delivery) const {
  if (delivery == consensus::Delivery::Reliable) return impl_->options().max_message_bytes;
  return impl_->with(false,
                     [](const UdpNode& node, std::int64_t) { return node.max_state_bytes(); });
}

void UdpTransport::drain(std::vector<consensus::Packet>& out) {
  impl_->with(false, [&](UdpNode& node, std::int64_t) { node.drain(out); });
}

void UdpTransport::drop(consensus::PeerId peer, const std::string& reason) {
  impl_->with(true, [&](UdpNode& node, std::int64_t now) { node.drop(peer, reason, now); });
}

std::vector<consensus::PeerStatus> UdpTransport::peers() const {
  return impl_->with(false, [](UdpNode& node, std::int64_t) { return node.peers(); });
}

void UdpTransport::list_peers(std::vector<consensus::PeerStatus>& out) const {
  impl_->with(false, [&out](UdpNode& node, std::int64_t) { node.table().list(out); });
}

bool UdpTransport::change_group(std::span<const std::byte> signed_change) {
  return impl_->with(true, [&](UdpNode& node, std::int64_t now) {
    return node.change_group(signed_change, now) == Credentials::Changed::Yes;
  });
}

std::uint64_t UdpTransport::group() const {
  return impl_->with(false, [](UdpNode& node, std::int64_t) { return node.credentials().group; });
}

SessionTime UdpTransport::session_now() const {
  return impl_->with(false, [](UdpNode& node, std::int64_t now) { return node.session_now(now); });
}

ClockStatus UdpTransport::clock() const {
  return impl_->with(false, [](UdpNode& node, std::int64_t now) { return node.clock(now); });
}

std::uint16_t UdpTransport::local_port() const { return impl_->local_port(); }

UdpRelayed UdpTransport::relayed() const {
  return impl_->with(false, [](UdpNode& node, std::int64_t) { return node.relay().counters(); });
}

consensus::PeerId UdpTransport::relay_of(consensus::PeerId peer) const {
  return impl_->with(false,
                     [peer](UdpNode& node, std::int64_t) { return node.relay().relay_of(peer); });
}

std::vector<UdpLookup> UdpTransport::lookups() const { return impl_->lookups(); }

UdpStrangers UdpTransport::strangers() const {
  return impl_->with(false, [](UdpNode& node, std::int64_t) { return node.strangers(); });
}

}  // namespace tandem::net
