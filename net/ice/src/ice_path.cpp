// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/ice/ice_path.h"

#include <netdb.h>
#include <netinet/in.h>
#include <nice/agent.h>
#include <sys/socket.h>

#include <array>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <utility>

#include "description.h"

namespace tandem::ice {

// A member of IcePath::Impl, hence named outside of this file.
struct GlibUnref {
  void operator()(NiceAgent* agent) const { g_object_unref(agent); }
  void operator()(GMainContext* context) const { g_main_context_unref(context); }
  void operator()(GMainLoop* loop) const { g_main_loop_unref(loop); }
  void operator()(GSocket* socket) const { g_object_unref(socket); }
  void operator()(NiceCandidate* candidate) const { nice_candidate_free(candidate); }
  void operator()(gchar* text) const { g_free(text); }
};
template <class T>
using GlibOwned = std::unique_ptr<T, GlibUnref>;

namespace {

constexpr guint kComponent = 1;
constexpr std::size_t kWhole = 1472;   // bytes, an Ethernet frame
constexpr guint kClosePatience = 500;  // ms, to tell TURN servers that a relay is released

void free_candidates(GSList* list) {
  g_slist_free_full(list,
                    [](gpointer each) { nice_candidate_free(static_cast<NiceCandidate*>(each)); });
}

/// Resolves a host name: libnice needs numeric addresses.
std::string numeric(const net::HostPort& address) {
  addrinfo hints{};
  hints.ai_family = AF_UNSPEC;
  hints.ai_socktype = SOCK_DGRAM;
  addrinfo* found = nullptr;
  const int error = ::getaddrinfo(address.host.c_str(), nullptr, &hints, &found);
  if (error != 0) {
    throw std::runtime_error("IcePath: cannot look up " + address.host + ": " +
                             ::gai_strerror(error));
  }
  std::array<char, NI_MAXHOST> text{};
  const int named = ::getnameinfo(found->ai_addr, found->ai_addrlen, text.data(), text.size(),
                                  nullptr, 0, NI_NUMERICHOST);
  ::freeaddrinfo(found);
  if (named != 0) throw std::runtime_error("IcePath: cannot look up " + address.host);
  return text.data();
}

/// Forbids fragmentation on this socket, and ignores others' reports about the path MTU. False if
/// this system cannot.
bool forbid_fragments(int socket) {
#ifdef __linux__
  const int v6 = IPV6_PMTUDISC_PROBE;
  const int v4 = IP_PMTUDISC_PROBE;
  const bool is_v6 = ::setsockopt(socket, IPPROTO_IPV6, IPV6_MTU_DISCOVER, &v6, sizeof v6) == 0;
  const bool is_v4 = ::setsockopt(socket, IPPROTO_IP, IP_MTU_DISCOVER, &v4, sizeof v4) == 0;
  return is_v6 || is_v4;
#else
  static_cast<void>(socket);
  return false;
#endif
}

void require(bool ok, const char* field, const std::string& value, const char* rule) {
  if (ok) return;
  throw std::invalid_argument(std::string("IceOptions: ") + field + " must be " + rule + ", is " +
                              value);
}

}  // namespace

void IceOptions::validate() const {
  require(stun.size() <= 1, "stun", std::to_string(stun.size()) + " servers", "at most one server");
  for (const net::HostPort& server : stun) {
    require(!server.host.empty() && server.port != 0, "stun", net::to_string(server), "HOST:PORT");
  }
  for (const TurnServer& server : turn) {
    require(!server.address.host.empty() && server.address.port != 0, "turn",
            net::to_string(server.address), "HOST:PORT");
    require(!server.user.empty() && !server.password.empty(), "turn",
            net::to_string(server.address) + " without", "given with user and password");
  }
  require(!relay_only || !turn.empty(), "relay_only", "true", "false without turn");
  if (!address.empty()) {
    NiceAddress parsed;
    nice_address_init(&parsed);
    require(nice_address_set_from_string(&parsed, address.c_str()) != FALSE, "address", address,
            "a numeric address");
  }
}

class __attribute__((visibility("hidden"))) IcePath::Impl {
 public:
  explicit Impl(const IceOptions& options)
      : context_(g_main_context_new()),
        loop_(g_main_loop_new(context_.get(), FALSE)),
        agent_(nice_agent_new(context_.get(), NICE_COMPATIBILITY_RFC5245)) {
    options.validate();
    NiceAgent* const agent = agent_.get();
    g_object_set(agent, "upnp", FALSE, "ice-tcp", FALSE, "keepalive-conncheck", TRUE, "force-relay",
                 options.relay_only ? TRUE : FALSE, nullptr);
    if (!options.stun.empty()) {
      g_object_set(agent, "stun-server", numeric(options.stun.front()).c_str(), "stun-server-port",
                   static_cast<guint>(options.stun.front().port), nullptr);
    }
    if (!options.address.empty()) {
      NiceAddress own;
      nice_address_init(&own);
      nice_address_set_from_string(&own, options.address.c_str());
      nice_agent_add_local_address(agent, &own);
    }
    stream_ = nice_agent_add_stream(agent, kComponent);
    for (const TurnServer& server : options.turn) {
      nice_agent_set_relay_info(agent, stream_, kComponent, numeric(server.address).c_str(),
                                server.address.port, server.user.c_str(), server.password.c_str(),
                                NICE_RELAY_TYPE_TURN_UDP);
    }
    g_signal_connect(agent, "candidate-gathering-done", G_CALLBACK(&Impl::on_gathered), this);
    g_signal_connect(agent, "component-state-changed", G_CALLBACK(&Impl::on_state), this);
    nice_agent_attach_recv(agent, stream_, kComponent, context_.get(), &Impl::on_receive, this);
    if (nice_agent_gather_candidates(agent, stream_) == FALSE) {
      throw std::runtime_error("IcePath: no address of this host can be used");
    }
    thread_ = std::thread([this] {
      g_main_context_push_thread_default(context_.get());
      g_main_loop_run(loop_.get());
      g_main_context_pop_thread_default(context_.get());
    });
  }

  ~Impl() {
    nice_agent_attach_recv(agent_.get(), stream_, kComponent, context_.get(), nullptr, nullptr);
    g_signal_handlers_disconnect_by_data(agent_.get(), this);
    // On its own thread: the messages to TURN servers need the loop.
    g_main_context_invoke(
        context_.get(),
        [](gpointer self) -> gboolean {
          static_cast<Impl*>(self)->close();
          return G_SOURCE_REMOVE;
        },
        this);
    thread_.join();
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  State state() const {
    const std::scoped_lock lock(mutex_);
    return state_;
  }
  std::string description() const {
    const std::scoped_lock lock(mutex_);
    return description_;
  }
  std::string route() const {
    NiceCandidate* local = nullptr;
    NiceCandidate* remote = nullptr;
    if (state() != State::Connected ||
        nice_agent_get_selected_pair(agent_.get(), stream_, kComponent, &local, &remote) == FALSE) {
      return {};
    }
    return std::string(nice_candidate_type_to_string(local->type)) + " to " +
           nice_candidate_type_to_string(remote->type);
  }

  /// Whether the path is direct and never fragments.
  bool is_whole() const {
    NiceCandidate* local = nullptr;
    NiceCandidate* remote = nullptr;
    if (nice_agent_get_selected_pair(agent_.get(), stream_, kComponent, &local, &remote) == FALSE ||
        local->type == NICE_CANDIDATE_TYPE_RELAYED || remote->type == NICE_CANDIDATE_TYPE_RELAYED) {
      return false;
    }
    const GlibOwned<GSocket> socket(
        nice_agent_get_selected_socket(agent_.get(), stream_, kComponent));
    return socket && forbid_fragments(g_socket_get_fd(socket.get()));
  }

  void connect(std::string_view text) {
    const Description remote = parse_description(text);
    NiceAgent* const agent = agent_.get();
    GSList* candidates = nullptr;
    for (const std::string& line : remote.candidates) {
      NiceCandidate* const each =
          nice_agent_parse_remote_candidate_sdp(agent, stream_, ("a=" + line).c_str());
      if (each != nullptr) candidates = g_slist_prepend(candidates, each);
    }
    const std::unique_ptr<GSList, decltype(&free_candidates)> owner(candidates, free_candidates);
    if (candidates == nullptr) {
      throw std::invalid_argument("ICE description: must have a candidate that can be read");
    }
    {
      const std::scoped_lock lock(mutex_);
      if (state_ != State::Ready) {
        throw std::invalid_argument("IcePath::connect: must be called once, when Ready, is " +
                                    std::string(to_string(state_)));
      }
      state_ = State::Connecting;
    }
    // Both begin as controlling; tie-breakers settle it (RFC 8445, Sec. 7.3.1.1).
    const bool good = nice_agent_set_remote_credentials(agent, stream_, remote.ufrag.c_str(),
                                                        remote.password.c_str()) != FALSE &&
                      nice_agent_set_remote_candidates(agent, stream_, kComponent, candidates) > 0;
    if (good) return;
    const std::scoped_lock lock(mutex_);
    state_ = State::Failed;
  }

  void send(std::span<const std::byte> datagram) {
    nice_agent_send(agent_.get(), stream_, kComponent, static_cast<guint>(datagram.size()),
                    reinterpret_cast<const gchar*>(datagram.data()));
  }
  void receive(Receive receive) {
    const std::scoped_lock lock(receiving_);
    receive_ = std::move(receive);
  }

 private:
  static void on_gathered(NiceAgent* /*agent*/, guint /*stream*/, gpointer self) {
    static_cast<Impl*>(self)->gathered();
  }
  static void on_state(NiceAgent* /*agent*/, guint /*stream*/, guint /*component*/, guint state,
                       gpointer self) {
    static_cast<Impl*>(self)->changed(state);
  }
  static void on_receive(NiceAgent* /*agent*/, guint /*stream*/, guint /*component*/, guint length,
                         gchar* bytes, gpointer self) {
    Impl& impl = *static_cast<Impl*>(self);
    const std::scoped_lock lock(impl.receiving_);
    if (impl.receive_) impl.receive_(std::as_bytes(std::span(bytes, length)));
  }

  void gathered() {
    Description own;
    gchar* ufrag = nullptr;
    gchar* password = nullptr;
    if (nice_agent_get_local_credentials(agent_.get(), stream_, &ufrag, &password) != FALSE) {
      own.ufrag = ufrag;
      own.password = password;
    }
    g_free(ufrag);
    g_free(password);
    GSList* const list = nice_agent_get_local_candidates(agent_.get(), stream_, kComponent);
    for (const GSList* at = list; at != nullptr; at = at->next) {
      const GlibOwned<gchar> line(nice_agent_generate_local_candidate_sdp(
          agent_.get(), static_cast<NiceCandidate*>(at->data)));
      // Strips "a=", which belongs to SDP.
      if (line) own.candidates.emplace_back(line.get() + 2);
    }
    free_candidates(list);
    const std::scoped_lock lock(mutex_);
    if (state_ != State::Gathering) return;
    state_ = own.candidates.empty() ? State::Failed : State::Ready;
    if (!own.candidates.empty()) description_ = encode(own);
  }

  void changed(guint state) {
    const std::scoped_lock lock(mutex_);
    if (state_ == State::Gathering || state_ == State::Ready) return;
    if (state == NICE_COMPONENT_STATE_READY || state == NICE_COMPONENT_STATE_CONNECTED) {
      state_ = State::Connected;
    } else if (state == NICE_COMPONENT_STATE_FAILED) {
      state_ = State::Failed;
    }
  }

  /// On the loop's thread: ends the loop soon.
  void close() {
    nice_agent_close_async(
        agent_.get(),
        [](GObject* /*agent*/, GAsyncResult* /*result*/, gpointer loop) {
          g_main_loop_quit(static_cast<GMainLoop*>(loop));
        },
        loop_.get());
    GSource* const patience = g_timeout_source_new(kClosePatience);
    g_source_set_callback(
        patience,
        [](gpointer loop) -> gboolean {
          g_main_loop_quit(static_cast<GMainLoop*>(loop));
          return G_SOURCE_REMOVE;
        },
        loop_.get(), nullptr);
    g_source_attach(patience, context_.get());
    g_source_unref(patience);
  }

  GlibOwned<GMainContext> context_;
  GlibOwned<GMainLoop> loop_;
  GlibOwned<NiceAgent> agent_;
  guint stream_ = 0;
  mutable std::mutex mutex_;
  State state_ = State::Gathering;
  std::string description_;
  std::mutex receiving_;
  Receive receive_;
  std::thread thread_;
};

IcePath::IcePath(const IceOptions& options) : impl_(std::make_unique<Impl>(options)) {}
IcePath::~IcePath() = default;

IcePath::State IcePath::state() const { return impl_->state(); }
std::string IcePath::description() const { return impl_->description(); }
void IcePath::connect(std::string_view remote) { impl_->connect(remote); }
std::string IcePath::route() const { return impl_->route(); }
void IcePath::send(std::span<const std::byte> datagram) { impl_->send(datagram); }
void IcePath::receive(Receive receive) { impl_->receive(std::move(receive)); }
std::size_t IcePath::max_datagram() const {
  return impl_->is_whole() ? kWhole : DatagramPath::max_datagram();
}

std::string_view to_string(IcePath::State state) {
  switch (state) {
    case IcePath::State::Gathering:
      return "gathering";
    case IcePath::State::Ready:
      return "ready";
    case IcePath::State::Connecting:
      return "connecting";
    case IcePath::State::Connected:
      return "connected";
    case IcePath::State::Failed:
      return "failed";
  }
  return "";
}

}  // namespace tandem::ice
