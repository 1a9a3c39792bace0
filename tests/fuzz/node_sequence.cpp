// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Packet sequences: three nodes with a network that the input decides on. It delivers, loses,
// repeats, exchanges, cuts and changes datagrams, sends them to others and from other addresses,
// starts nodes again, and makes datagrams up.
#include <deque>
#include <map>
#include <memory>
#include <utility>

#include "net/protocol_support.h"
#include "target.h"
#include "udp_node.h"

namespace fuzz {

using namespace tandem::net;
using tandem::consensus::Delivery;
using tandem::consensus::PeerId;

namespace {

struct Flying {
  PeerId from = 0;
  PeerId to = 0;
  Bytes datagram;
};

class Network {
 public:
  Network() {
    for (PeerId peer = 1; peer <= 3; ++peer) start(peer);
  }

  void start(PeerId peer) {
    UdpNodeOptions options;
    options.handshake.self = peer;
    options.handshake.incarnation = ++starts_;
    options.handshake.session_key = protocol::secret(1);
    options.handshake.identity = crypto::make_key_pair(protocol::seeded(100 + starts_));
    // The work for an id is most of what an input costs, and the same for all inputs.
    static std::map<std::pair<PeerId, std::uint64_t>, std::uint64_t> stamps;
    std::uint64_t& stamp = stamps[{peer, starts_}];
    if (stamp == 0) stamp = work_for(peer, options.handshake.identity.public_key);
    options.handshake.stamp = stamp;
    options.start = now;
    options.max_peers = 4;
    auto& node = nodes_[peer % 3];
    node = std::make_unique<UdpNode>(
        options, protocol::seeded(200 + starts_),
        [this, peer](std::span<const std::byte> datagram, const Address& to) {
          require(datagram.size() <= kMaxDatagram);
          const PeerId target = to.ip[15];
          if (flying.size() < 200) flying.push_back({peer, target, protocol::copy(datagram)});
        });
    // 3 is told of 2 by 1.
    if (peer != 1) node->dial(protocol::address_of(1), now);
  }
  UdpNode& node(PeerId peer) { return *nodes_[peer % 3]; }
  void poll() {
    for (auto& node : nodes_) node->poll(now);
  }
  void deliver(const Flying& packet) {
    if (packet.to < 1 || packet.to > 3) return;
    (void)node(packet.to).on_datagram(packet.datagram, protocol::address_of(packet.from), now);
  }

  std::int64_t now = 0;
  std::deque<Flying> flying;

 private:
  std::unique_ptr<UdpNode> nodes_[3];
  std::uint64_t starts_ = 0;
};

}  // namespace

void run(std::span<const std::byte> input) {
  Choices choices(input);
  Network network;
  std::vector<tandem::consensus::Packet> packets;
  int steps = 0;
  while (!choices.done() && ++steps < 2000) {
    const unsigned what = choices.byte();
    const PeerId peer = 1 + what / 16 % 3;
    auto& flying = network.flying;
    const std::size_t at = flying.empty() ? 0 : what / 16 % flying.size();
    switch (what % 16) {
      case 0:
      case 1:
      case 2:
      case 3: {  // all that is under way, in order
        network.now += 5'000'000 * (1 + what / 16);
        network.poll();
        for (std::size_t count = flying.size(); count > 0; --count) {
          const Flying packet = std::move(flying.front());
          flying.pop_front();
          network.deliver(packet);
        }
        break;
      }
      case 4:
        if (!flying.empty()) flying.erase(flying.begin() + static_cast<std::ptrdiff_t>(at));
        break;
      case 5:
        if (!flying.empty()) network.deliver(Flying(flying[at]));
        break;
      case 6:
        if (!flying.empty() && !flying[at].datagram.empty()) {
          const std::size_t place = choices.number(2) % flying[at].datagram.size();
          flying[at].datagram[place] ^= static_cast<std::byte>(choices.byte());
        }
        break;
      case 7:
        if (!flying.empty()) {
          const std::size_t size = choices.number(2) % (flying[at].datagram.size() + 20);
          flying[at].datagram.resize(size);
        }
        break;
      case 8:
        if (!flying.empty()) flying[at].from = choices.byte() % 5;
        break;
      case 9:
        if (!flying.empty()) flying[at].to = choices.byte() % 5;
        break;
      case 10: {
        const auto bytes = choices.bytes(choices.byte());
        network.deliver(
            {.from = choices.byte() % 5u, .to = peer, .datagram = protocol::copy(bytes)});
        break;
      }
      case 11:
        (void)network.node(peer).post(1 + choices.byte() % 3, Bytes(choices.number(2) % 1400),
                                      Delivery::Newest, network.now);
        break;
      case 12:
        (void)network.node(peer).post(1 + choices.byte() % 3, Bytes(choices.number(2) % 9000),
                                      Delivery::Reliable, network.now);
        break;
      case 13:
        network.now += 100'000'000 * (1 + what / 16);
        network.poll();
        break;
      case 14: {
        // As a member would: told of somebody, handed a datagram of somebody.
        const PeerId other = choices.byte() % 5;
        if (choices.byte() % 2 == 0) {
          network.node(peer).told(
              other, {.peer = choices.byte() % 6u, .address = protocol::address_of(other)},
              network.now);
        } else {
          network.node(peer).passed_on(
              other, {.peer = choices.byte() % 6u, .datagram = choices.bytes(choices.byte())},
              network.now);
        }
        break;
      }
      default: {
        const unsigned kind = choices.byte() % 8;
        if (kind == 0) network.start(peer);
        if (kind == 1) network.node(peer).drop(1 + choices.byte() % 3, "", network.now);
        if (kind == 2) network.node(peer).leave("", network.now);
        packets.clear();
        network.node(peer).drain(packets);
        (void)network.node(peer).peers();
        (void)network.node(peer).clock(network.now);
        break;
      }
    }
    for (PeerId each = 1; each <= 3; ++each) {
      require(network.node(each).connections() <= 8);
      require(network.node(each).next_due(network.now) >= 0);
    }
  }
}

std::vector<Bytes> seeds() {
  const auto script = [](std::initializer_list<int> steps) {
    Bytes out;
    for (const int step : steps) out.push_back(static_cast<std::byte>(step));
    return out;
  };
  const Bytes connect(12, std::byte{0x10});
  std::vector<Bytes> out{connect};
  for (const Bytes& then :
       {script({0x0b, 1, 100, 0, 0x1c, 0, 0x20, 3, 0, 0, 0, 0x0f, 3, 0x1f, 3}),
        script({0x0c, 1, 0, 32, 0, 5, 0, 4, 0, 8, 2, 0, 6, 40, 0, 1, 0, 0, 0}),
        script({0x0f, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}),
        script({0xfd, 0xfd, 0xfd, 0xfd, 0, 0, 0, 0, 0, 0, 0, 0, 0}),
        script({0x1e, 2, 0, 3, 0x1e, 2, 1, 3, 20, 1, 0x54, 0x4e, 0x44, 0x55, 1, 0, 0, 0, 0, 0, 0}),
        script({0x0f, 1, 1, 0, 0, 0, 0xfd, 0, 0, 0, 0, 0, 0x0f, 2, 0, 0, 0})}) {
    out.push_back(connect);
    out.back().insert(out.back().end(), then.begin(), then.end());
  }
  return out;
}

}  // namespace fuzz
