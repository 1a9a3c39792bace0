// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/net/tcp.h"

#include <chrono>
#include <utility>

#include "loopback.h"
#include "peer_table.h"
#include "require.h"
#include "tcp_mesh.h"
#include "tcp_report.h"
#include "tcp_security.h"

namespace tandem::net {

void TcpOptions::validate() const {
  using std::chrono::milliseconds;
  const auto check = [](bool ok, const char* field, auto value, const char* rule) {
    require(ok, "TcpOptions", field, value, rule);
  };
  constexpr std::uint32_t kMebi = 1024 * 1024;
  check(self != 0, "self", self, "not 0");
  check(!listen_port || !listen_address.empty(), "listen_address", listen_address, "an address");
  for (const HostPort& address : connect) {
    check(!address.host.empty() && address.port != 0, "connect", to_string(address), "HOST:PORT");
  }
  // Keys do not appear in error messages.
  const std::string given = "given";
  if (session_key) {
    check(crypto::is_available(), "session_key", given, "none in a build without libsodium");
    check(*session_key != Key{}, "session_key", std::string("zero"), "secret");
    check(!insecure, "insecure", std::string("true"), "false with a session_key");
  } else {
    check(!identity, "identity", given, "none without a session_key");
    check(trusted.empty(), "trusted", given, "empty without a session_key");
    check(!organiser, "organiser", given, "none without a session_key");
  }
  if (session_key && crypto::is_available()) require_credentials(*this, "TcpOptions");
  for (const TrustedPeer& each : trusted) {
    check(each.peer != 0 && each.peer != self, "trusted", each.peer, "ids of other peers");
  }
  if (!session_key && !insecure) {
    constexpr const char* kRule = "of this machine where there is neither session_key nor insecure";
    check(!listen_port || is_loopback(listen_address), "listen_address", listen_address, kRule);
    for (const HostPort& address : connect) {
      check(is_loopback(address.host), "connect", to_string(address), kRule);
    }
  }
  check(max_message_bytes >= 64 && max_message_bytes <= 16 * kMebi, "max_message_bytes",
        max_message_bytes, "in [64, 16 MiB]");
  const std::size_t least_queue = 2 * static_cast<std::size_t>(max_message_bytes);
  check(send_queue_bytes >= least_queue, "send_queue_bytes", send_queue_bytes,
        ">= 2 * max_message_bytes");
  check(receive_queue_bytes >= least_queue, "receive_queue_bytes", receive_queue_bytes,
        ">= 2 * max_message_bytes");
  check(max_peers >= 1 && max_peers <= 1024, "max_peers", max_peers, "in [1, 1024]");
  check(socket_buffer_bytes >= 4096 && socket_buffer_bytes <= 64 * kMebi, "socket_buffer_bytes",
        socket_buffer_bytes, "in [4096, 64 MiB]");
  check(handshake_timeout >= milliseconds(1) && handshake_timeout <= std::chrono::hours(1),
        "handshake_timeout", handshake_timeout.count(), "in [1 ms, 1 h]");
  require_times(*this, "TcpOptions");
}

namespace {

TcpOptions complete(TcpOptions options) {
  options.validate();
  options.session_key.reset();  // TcpSecurity has the keys
  options.identity.reset();
  if (options.incarnation == 0) {
    const auto now = std::chrono::system_clock::now().time_since_epoch();
    options.incarnation = static_cast<std::uint64_t>(
        std::chrono::duration_cast<std::chrono::nanoseconds>(now).count());
  }
  return options;
}

}  // namespace

class __attribute__((visibility("hidden"))) TcpTransport::Impl {
 public:
  explicit Impl(const TcpOptions& given)
      : options(complete(given)),
        table(options),
        mesh(options, table, report,
             given.session_key ? std::make_unique<TcpSecurity>(given) : nullptr) {}

  const TcpOptions options;
  PeerTable table;
  TcpReport report;
  TcpMesh mesh;
};

TcpTransport::TcpTransport(const TcpOptions& options) : impl_(std::make_unique<Impl>(options)) {}

TcpTransport::~TcpTransport() = default;

PeerId TcpTransport::self() const { return impl_->options.self; }

bool TcpTransport::post(PeerId to, std::span<const std::byte> bytes, consensus::Delivery delivery) {
  const auto result = impl_->table.post(to, bytes, delivery);
  if (result.wake) impl_->mesh.wake(to);
  if (result.cut_link != 0) impl_->mesh.cut(result.cut_link, "does not keep up");
  return result.accepted;
}

void TcpTransport::drain(std::vector<consensus::Packet>& out) { impl_->table.drain(out); }

void TcpTransport::drop(PeerId peer, const std::string& reason) {
  const std::uint64_t link = impl_->table.drop(peer, reason, std::chrono::steady_clock::now());
  if (link != 0) impl_->mesh.cut(link, "dropped: " + reason);
}

std::vector<consensus::PeerStatus> TcpTransport::peers() const { return impl_->table.peers(); }
void TcpTransport::change_group(std::span<const std::byte> signed_change) {
  impl_->mesh.change_group({signed_change.begin(), signed_change.end()});
}
std::uint64_t TcpTransport::group() const { return impl_->mesh.group(); }
std::vector<DialStatus> TcpTransport::dials() const {
  std::vector<DialStatus> out = impl_->report.dials();
  for (DialStatus& dial : out) dial.connected = impl_->table.link_of(dial.peer) != 0;
  return out;
}
StrangerStatus TcpTransport::strangers() const { return impl_->report.strangers(); }
std::uint16_t TcpTransport::local_port() const { return impl_->mesh.local_port(); }
std::uint64_t TcpTransport::incarnation(PeerId peer) const {
  return impl_->table.incarnation(peer);
}

}  // namespace tandem::net
