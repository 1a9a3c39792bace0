// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Sessions over TCP with a key, on loopback, and somebody on the path.
#include <algorithm>
#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <random>

#include "raw_peer.h"
#include "support/catch.h"
#include "tandem/net/keys.h"

namespace tcp_protected_test {

using namespace tandem::net;
using raw::connected;
using raw::eventually;
using raw::linked;
using raw::operator+;
using raw::status;
using std::chrono::milliseconds;
using tandem::consensus::Delivery;
using tandem::consensus::Packet;

namespace {

constexpr std::uint8_t kKeyRequest = 9;

Key key(std::uint8_t fill) {
  Key out{};
  out.fill(fill);
  return out;
}

TcpOptions keyed(PeerId self, std::vector<std::uint16_t> connect = {}) {
  TcpOptions out = raw::options(self, std::move(connect));
  out.session_key = key(7);
  return out;
}

/// One that nobody can dial.
TcpOptions silent(TcpOptions options) {
  options.listen_port.reset();
  return options;
}

raw::Bytes random_bytes(std::size_t size, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  raw::Bytes out(size);
  for (std::byte& b : out) b = static_cast<std::byte>(random());
  return out;
}

/// Somebody on the path to `target`: passes connections on, keeps what is said, and changes the
/// frames of whoever dials as he is told to.
class Middle {
 public:
  using Change = std::function<raw::Bytes(const raw::Bytes& frame)>;
  struct Record {
    raw::Bytes up;  // from the dialler
    raw::Bytes down;
  };

  explicit Middle(std::uint16_t target) : target_(target), thread_([this] { run(); }) {}
  ~Middle() {
    stop_ = true;
    thread_.join();
  }

  std::uint16_t port() const { return listener_.port(); }
  void set(Change change) {
    const std::lock_guard lock(mutex_);
    change_ = std::move(change);
  }
  std::vector<Record> records() const {
    const std::lock_guard lock(mutex_);
    return records_;
  }

 private:
  /// No assertions: they belong to the test's thread.
  class End {
   public:
    explicit End(int fd) : fd_(fd) {}
    ~End() { tandem::testing::close_socket(fd_); }
    End(const End&) = delete;
    End& operator=(const End&) = delete;

    int fd() const { return fd_; }
    bool readable() const {
      pollfd poll{.fd = fd_, .events = POLLIN, .revents = 0};
      return ::poll(&poll, 1, 1) > 0;
    }
    bool read(raw::Bytes& out) const {
      out.resize(65536);
      const ssize_t n = ::recv(fd_, out.data(), out.size(), 0);
      out.resize(n > 0 ? static_cast<std::size_t>(n) : 0);
      return n > 0;
    }
    bool send(const raw::Bytes& bytes) const {
      for (std::size_t at = 0; at < bytes.size();) {
        const ssize_t n = ::send(fd_, bytes.data() + at, bytes.size() - at, MSG_NOSIGNAL);
        if (n <= 0) return false;
        at += static_cast<std::size_t>(n);
      }
      return true;
    }

   private:
    const int fd_;
  };
  class Door : public raw::Listener {
   public:
    int fd() const { return fd_; }
  };

  void run() {
    while (!stop_) {
      if (!listener_.readable(2)) continue;
      const End dialler(::accept(listener_.fd(), nullptr, nullptr));
      sockaddr_in to{};
      to.sin_family = AF_INET;
      to.sin_port = htons(target_);
      to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
      const End listener(::socket(AF_INET, SOCK_STREAM, 0));
      if (::connect(listener.fd(), reinterpret_cast<const sockaddr*>(&to), sizeof to) != 0) {
        continue;
      }
      {
        const std::lock_guard lock(mutex_);
        records_.emplace_back();
      }
      raw::Bytes chunk, waiting;
      while (!stop_) {
        if (dialler.readable()) {
          if (!dialler.read(chunk)) break;
          waiting.insert(waiting.end(), chunk.begin(), chunk.end());
          if (!listener.send(changed(waiting))) break;
        }
        if (listener.readable()) {
          if (!listener.read(chunk)) break;
          const std::lock_guard lock(mutex_);
          records_.back().down = std::move(records_.back().down) + chunk;
          if (!dialler.send(chunk)) break;
        }
      }
    }
  }

  /// Takes the whole frames out of `waiting`.
  raw::Bytes changed(raw::Bytes& waiting) {
    const std::lock_guard lock(mutex_);
    raw::Bytes out;
    while (waiting.size() >= 4) {
      const std::size_t size = 4 + raw::number(std::span(waiting).first(4));
      if (waiting.size() < size) break;
      const raw::Bytes frame(waiting.begin(), waiting.begin() + static_cast<std::ptrdiff_t>(size));
      waiting.erase(waiting.begin(), waiting.begin() + static_cast<std::ptrdiff_t>(size));
      records_.back().up = std::move(records_.back().up) + frame;
      out = std::move(out) + (change_ ? change_(frame) : frame);
    }
    return out;
  }

  const std::uint16_t target_;
  Door listener_;
  mutable std::mutex mutex_;
  Change change_;
  std::vector<Record> records_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

bool contains(const raw::Bytes& where, const raw::Bytes& what) {
  return std::search(where.begin(), where.end(), what.begin(), what.end()) != where.end();
}

raw::Bytes first_frame(const raw::Bytes& stream) {
  REQUIRE(stream.size() > 4);
  const std::size_t size = 4 + raw::number(std::span(stream).first(4));
  REQUIRE(stream.size() >= size);
  return {stream.begin(), stream.begin() + static_cast<std::ptrdiff_t>(size)};
}

std::string reason_of_dial(const TcpTransport& transport) {
  const auto dials = transport.dials();
  return dials.empty() ? std::string() : dials.front().reason;
}

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

}  // namespace

TEST_CASE("protected tcp: frames arrive whole and in order, and nobody on the path reads them",
          "[net][socket]") {
  const raw::LeakCheck leaks;
  const raw::Bytes secret = random_bytes(64, 5);
  for (const bool protect : {true, false}) {  // in the clear they are found: the search works
    CAPTURE(protect);
    TcpTransport a(protect ? keyed(1) : raw::options(1));
    Middle middle(a.local_port());
    TcpTransport b(silent(protect ? keyed(2, {middle.port()}) : raw::options(2, {middle.port()})));
    REQUIRE(eventually([&] { return linked(a, b); }));
    const std::vector<std::size_t> sizes = {0, 1, 65536, 65535, 17};
    for (std::size_t i = 0; i < sizes.size(); ++i) {
      const auto delivery = i % 2 == 0 ? Delivery::Newest : Delivery::Reliable;
      REQUIRE(b.post(1, random_bytes(sizes[i], i), delivery));
      REQUIRE(a.post(2, random_bytes(sizes[i], i), delivery));
    }
    REQUIRE(b.post(1, secret, Delivery::Reliable));
    REQUIRE(a.post(2, secret, Delivery::Reliable));
    for (TcpTransport* each : {&a, &b}) {
      const std::vector<Packet> got = raw::receive(*each, sizes.size() + 1);
      REQUIRE(got.size() == sizes.size() + 1);
      for (std::size_t i = 0; i < sizes.size(); ++i) {
        CHECK(got[i].bytes == random_bytes(sizes[i], i));
      }
      CHECK(got.back().bytes == secret);
    }
    CHECK_FALSE(b.post(1, random_bytes(65537, 0), Delivery::Reliable));
    REQUIRE(middle.records().size() == 1);
    const Middle::Record record = middle.records().front();
    CHECK(contains(record.up, secret) == !protect);
    CHECK(contains(record.down, secret) == !protect);
  }
}

TEST_CASE("protected tcp: one address is enough for a full mesh", "[net][socket]") {
  const raw::LeakCheck leaks;
  TcpTransport a(keyed(3));
  TcpTransport b(keyed(1, {a.local_port()}));
  TcpTransport c(keyed(2, {a.local_port()}));
  CHECK(eventually([&] { return linked(a, b) && linked(a, c) && linked(b, c); }));
}

TEST_CASE("protected tcp: a peer without the key is refused with a reason",
          "[net][socket][fault]") {
  const raw::LeakCheck leaks;
  TcpTransport a(keyed(1));
  {
    TcpOptions other = keyed(2, {a.local_port()});
    other.session_key = key(8);
    TcpTransport b(other);
    CHECK(eventually([&] { return a.strangers().bad_proof >= 2; }));  // he goes on trying
    CHECK(eventually([&] { return has(reason_of_dial(b), "has it the same session key?"); }));
    CHECK_FALSE(connected(b, 1));
  }
  {
    TcpTransport b(raw::options(3, {a.local_port()}));
    CHECK(eventually([&] { return has(reason_of_dial(b), "a session key is needed"); }));
  }
  CHECK(a.peers().empty());  // nothing is kept of them
  CHECK(a.strangers().malformed == 0);
  {
    TcpTransport plain(raw::options(4));
    TcpTransport b(keyed(5, {plain.local_port()}));
    CHECK(eventually([&] { return reason_of_dial(b) == "peer: this end has no session key"; }));
    CHECK(plain.peers().empty());
  }
  TcpTransport member(keyed(6, {a.local_port()}));
  CHECK(eventually([&] { return linked(a, member); }));
}

TEST_CASE("protected tcp: a frame that was tampered with ends the connection and is counted",
          "[net][socket][fault]") {
  const raw::LeakCheck leaks;
  // Each is asked once for each frame after it is armed, and may change the first ones.
  raw::Bytes held;
  bool done = false;
  const auto once = [&done](auto change) {
    return Middle::Change([&done, change](const raw::Bytes& frame) {
      return std::exchange(done, true) ? frame : change(frame);
    });
  };
  const std::vector<std::pair<std::string, Middle::Change>> attacks = {
      {"changed", once([](raw::Bytes frame) {
         frame[frame.size() / 2] ^= std::byte{1};
         return frame;
       })},
      {"repeated", once([](const raw::Bytes& frame) { return frame + frame; })},
      {"left out", once([](const raw::Bytes&) { return raw::Bytes(); })},
      {"shortened", once([](const raw::Bytes& frame) {
         return raw::le(frame.size() - 5, 4) + raw::Bytes(frame.begin() + 4, frame.end() - 1);
       })},
      {"too long to be one", once([](const raw::Bytes&) { return raw::le(0x7fffffff, 4); })},
      {"in the clear",
       once([](const raw::Bytes&) { return raw::frame(raw::kNewest, raw::Bytes(20)); })},
      {"in another order", [&](const raw::Bytes& frame) {
         if (done) return frame;
         if (held.empty()) {
           held = frame;
           return raw::Bytes();
         }
         done = true;
         return frame + std::exchange(held, {});
       }}};
  for (const auto& [name, attack] : attacks) {
    CAPTURE(name);
    held.clear();
    done = false;
    TcpTransport a(keyed(1));
    Middle middle(a.local_port());
    TcpTransport b(silent(keyed(2, {middle.port()})));
    REQUIRE(eventually([&] { return linked(a, b); }));
    REQUIRE(a.strangers().forged == 0);
    middle.set(attack);
    constexpr std::uint64_t kCount = 50;
    for (std::uint64_t i = 0; i < kCount; ++i) {
      REQUIRE(eventually([&] { return b.post(1, raw::le(i, 8), Delivery::Reliable); }));
      std::this_thread::sleep_for(milliseconds(1));  // frames of their own reads
    }
    CHECK(eventually([&] { return a.strangers().forged == 1; }));
    // Set up again, and what was sent reliably arrives all the same, once and in order.
    const std::vector<Packet> got = raw::receive(a, kCount);
    REQUIRE(got.size() == kCount);
    for (std::uint64_t i = 0; i < kCount; ++i) REQUIRE(raw::number(got[i].bytes) == i);
    CHECK(status(a, 2).rejected == 0);  // it was not the peer
    CHECK(eventually([&] { return linked(a, b); }));
    CHECK(a.strangers().forged == 1);
  }
}

TEST_CASE("protected tcp: a replayed recording has no effect, least of all on a new process",
          "[net][socket][fault]") {
  const raw::LeakCheck leaks;
  Middle::Record record;
  {
    TcpTransport a(keyed(1));
    Middle middle(a.local_port());
    {
      TcpTransport b(silent(keyed(2, {middle.port()})));
      REQUIRE(eventually([&] { return linked(a, b); }));
      REQUIRE(b.post(1, raw::text("lift"), Delivery::Reliable));
      CHECK(raw::receive(a, 1).size() == 1);
    }
    CHECK(eventually([&] { return !connected(a, 2); }));
    record = middle.records().front();
    // To the process that it was made of.
    raw::Socket again = raw::Socket::connect(a.local_port());
    again.send(record.up);
    CHECK(again.ends());
    CHECK(eventually([&] { return a.strangers().forged == 1; }));
    CHECK_FALSE(connected(a, 2));
  }
  TcpTransport a(keyed(1));
  raw::Socket again = raw::Socket::connect(a.local_port());
  again.send(record.up);
  CHECK(again.ends());
  CHECK(eventually([&] { return a.strangers().forged == 1; }));
  CHECK(a.peers().empty());
  std::vector<Packet> got;
  a.drain(got);
  CHECK(got.empty());

  // And the other way, to one that dials.
  raw::Listener listener;
  TcpTransport b(silent(keyed(2, {listener.port()})));
  raw::Socket dialled = listener.accept();
  REQUIRE(dialled.read(kKeyRequest));
  dialled.send(record.down);
  CHECK(dialled.ends());
  CHECK(eventually([&] { return has(reason_of_dial(b), "session key differs"); }));
  CHECK(b.peers().empty());
}

TEST_CASE("protected tcp: a restarted peer takes over, with keys of its own", "[net][socket]") {
  const raw::LeakCheck leaks;
  TcpTransport a(keyed(1));
  Middle middle(a.local_port());
  TcpOptions second = silent(keyed(2, {middle.port()}));
  second.identity = key(3);  // the same, and so is all else that could make keys
  for (std::uint64_t life = 1; life <= 2; ++life) {
    second.incarnation = life;
    TcpTransport b(second);
    REQUIRE(eventually([&] { return linked(a, b) && a.incarnation(2) == life; }));
    REQUIRE(b.post(1, raw::text("here"), Delivery::Reliable));
    const auto got = raw::receive(a, 1);
    CHECK(raw::as_text(got.back().bytes) == "here");
  }
  const auto records = middle.records();
  REQUIRE(records.size() >= 2);
  // Both ends' ephemeral keys stand in the clear, after length, type, magic and version.
  const auto ephemeral = [](const raw::Bytes& stream) {
    const raw::Bytes frame = first_frame(stream);
    return raw::Bytes(frame.begin() + 11, frame.begin() + 43);
  };
  CHECK(ephemeral(records[0].up) != ephemeral(records[1].up));
  CHECK(ephemeral(records[0].down) != ephemeral(records[1].down));
}

TEST_CASE("protected tcp: with public keys no member can be another", "[net][socket][fault]") {
  const raw::LeakCheck leaks;
  const auto member = [](PeerId self, std::vector<std::uint16_t> connect) {
    TcpOptions out = keyed(self, std::move(connect));
    out.identity = key(static_cast<std::uint8_t>(self));
    for (const PeerId other : {1, 2, 3}) {
      if (other == self) continue;
      out.trusted.push_back(
          {.peer = other, .public_key = public_key(key(static_cast<std::uint8_t>(other)))});
    }
    return out;
  };
  TcpTransport a(member(1, {}));
  TcpTransport b(member(2, {a.local_port()}));
  REQUIRE(eventually([&] { return linked(a, b); }));
  // Peer 3 calls itself 2, and later than that.
  TcpOptions liar = silent(member(3, {a.local_port()}));
  liar.self = 2;
  liar.incarnation = ~std::uint64_t{0};
  liar.trusted = {};
  {
    TcpTransport mallory(liar);
    CHECK(eventually([&] { return a.strangers().refused >= 1; }));
    CHECK(eventually(
        [&] { return has(reason_of_dial(mallory), "public key is not that of the peer (2)"); }));
    CHECK(linked(a, b));
    CHECK(status(a, 2).rejected == 0);
  }
  TcpTransport c(member(3, {a.local_port()}));
  CHECK(eventually([&] { return linked(a, c) && linked(b, c); }));
}

TEST_CASE("protected tcp: strangers cost little, and members get in beside them",
          "[net][socket][fault]") {
  const raw::LeakCheck leaks;
  TcpOptions hasty = keyed(1);
  hasty.handshake_timeout = milliseconds(300);
  TcpTransport a(hasty);
  {
    raw::Socket mute = raw::Socket::connect(a.local_port());
    CHECK(mute.ends());
    CHECK(a.strangers().timed_out == 1);
    raw::Socket babble = raw::Socket::connect(a.local_port());
    babble.send(raw::frame(kKeyRequest, raw::Bytes(300)));
    CHECK(babble.ends());
    CHECK(eventually([&] { return a.strangers().malformed == 1; }));
    raw::Socket later = raw::Socket::connect(a.local_port());
    later.send(raw::frame(kKeyRequest, raw::text("TNDK") + raw::le(9, 2) + raw::Bytes(96)));
    const auto goodbye = later.read(raw::kGoodbye);
    REQUIRE(goodbye);
    CHECK(raw::as_text(goodbye->payload) == "key exchange version 9 differs from 2");
  }
  std::vector<raw::Socket> crowd;
  for (int i = 0; i < 60; ++i) crowd.push_back(raw::Socket::connect(a.local_port()));
  CHECK(eventually([&] { return a.strangers().limited > 0; }));
  TcpTransport b(keyed(2, {a.local_port()}));
  CHECK(eventually([&] { return linked(a, b); }));
}

TEST_CASE("protected tcp: frames in the clear stay on this machine unless that is asked for",
          "[net][fault]") {
  const std::string rule =
      "TcpOptions: listen_address must be of this machine where there is neither session_key nor "
      "insecure, is ";
  const auto error = [](const TcpOptions& options) {
    try {
      options.validate();
    } catch (const std::invalid_argument& thrown) {
      return std::string(thrown.what());
    }
    return std::string();
  };
  TcpOptions options{.self = 1, .listen_port = 0};
  CHECK(error(options) == rule + "0.0.0.0");
  options.insecure = true;
  CHECK(error(options).empty());
  options.session_key = key(1);
  CHECK(error(options) == "TcpOptions: insecure must be false with a session_key, is true");
  options.insecure = false;
  CHECK(error(options).empty());
  options.session_key = Key{};
  CHECK(error(options) == "TcpOptions: session_key must be secret, is zero");
  options.session_key.reset();
  for (const char* here : {"127.0.0.1", "127.3.2.1", "::1", "::ffff:127.0.0.1"}) {
    options.listen_address = here;
    CHECK(error(options).empty());
  }
  for (const char* there : {"::", "192.0.2.1", "127.0.0.1.example.org", "::ffff:192.0.2.1"}) {
    options.listen_address = there;
    CHECK(error(options) == rule + there);
  }
  options.listen_port.reset();
  CHECK(error(options).empty());  // of no meaning then
  options.connect = {{"localhost", 5}};
  CHECK(error(options).empty());
  options.connect = {{"example.org", 5}};
  CHECK(error(options) ==
        "TcpOptions: connect must be of this machine where there is neither session_key nor "
        "insecure, is example.org:5");
  options.insecure = true;
  CHECK(error(options).empty());
  options.identity = key(2);
  CHECK(error(options) == "TcpOptions: identity must be none without a session_key, is given");
  options.identity.reset();
  options.trusted = {{.peer = 2, .public_key = key(3)}};
  CHECK(error(options) == "TcpOptions: trusted must be empty without a session_key, is given");
  options.session_key = key(1);
  options.insecure = false;
  options.trusted[0].peer = 1;
  CHECK(error(options) == "TcpOptions: trusted must be ids of other peers, is 1");
}

}  // namespace tcp_protected_test
