// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "peer/config.h"

#include <toml++/toml.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <initializer_list>
#include <limits>
#include <sstream>
#include <vector>

#include "session/session_key.h"
#include "tandem/net/keys.h"
#include "tandem/net/membership.h"
#include "tandem/net/session.h"
#include "tandem/pbd/parse_number.h"
#include "tandem/pbd/validate.h"

namespace tandem::demos {

namespace {

/// One table of a file: checks values and refuses unknown keys.
class Section {
 public:
  /// @param prefix  of the keys' full names
  Section(const toml::table& table, std::string file, std::string prefix)
      : table_(table), file_(std::move(file)), prefix_(std::move(prefix)) {}

  [[noreturn]] void refuse(std::string_view key, const std::string& rule) const {
    const toml::node* const node = table_.get(key);
    const std::string line = node == nullptr ? "" : ':' + std::to_string(node->source().begin.line);
    throw ConfigError(file_ + line + ": " +
                      pbd::detail::must_be(prefix_ + std::string(key), rule, text(node)));
  }

  /// Null if absent.
  const toml::node* take(std::string_view key) const { return table_.get(key); }
  bool has(std::string_view key) const { return table_.get(key) != nullptr; }

  void read(std::string_view key, bool& into) {
    const toml::node* const node = take(key);
    if (node == nullptr) return;
    if (!node->is_boolean()) refuse(key, "true or false");
    into = node->value_or(false);
  }
  void read(std::string_view key, std::string& into) {
    const toml::node* const node = take(key);
    if (node == nullptr) return;
    if (!node->is_string()) refuse(key, "a text in quotation marks");
    into = node->value_or(std::string());
  }
  void read(std::string_view key, double& into, double low, double high, const char* rule) {
    const toml::node* const node = take(key);
    if (node == nullptr) return;
    const std::optional<double> value = node->is_number() ? node->value<double>() : std::nullopt;
    // Written so that NaN is refused too.
    if (!value || !(*value >= low && *value <= high)) refuse(key, rule);
    into = *value;
  }
  template <class Integer>
  void read(std::string_view key, Integer& into, std::int64_t low, std::int64_t high,
            const char* rule) {
    const toml::node* const node = take(key);
    if (node == nullptr) return;
    const std::optional<std::int64_t> value =
        node->is_integer() ? node->value<std::int64_t>() : std::nullopt;
    if (!value || *value < low || *value > high) refuse(key, rule);
    into = static_cast<Integer>(*value);
  }
  /// A list of strings, each accepted by `good`.
  void read(std::string_view key, std::vector<std::string>& into, const char* rule,
            const std::function<bool(const std::string&)>& good) {
    const toml::node* const node = take(key);
    if (node == nullptr) return;
    const toml::array* const list = node->as_array();
    if (list == nullptr) refuse(key, rule);
    for (const toml::node& each : *list) {
      const std::string value = each.value_or(std::string());
      if (!each.is_string() || !good(value)) refuse(key, rule);
      into.push_back(value);
    }
  }

  /// All keys of this table with their string values.
  void read_each(const std::function<void(const std::string&, const std::string&)>& take_one) {
    for (const auto& entry : table_) {
      const std::string key(entry.first.str());
      if (!entry.second.is_string()) refuse(key, "a text in quotation marks");
      take_one(key, entry.second.value_or(std::string()));
    }
  }

  /// A subtable, empty if absent.
  Section section(std::string_view key) {
    static const toml::table kEmpty;
    const toml::node* const node = take(key);
    if (node != nullptr && !node->is_table()) refuse(key, "a table");
    return {node == nullptr ? kEmpty : *node->as_table(), file_, prefix_ + std::string(key) + '.'};
  }

  /// Refuses unknown keys, since a misspelt key would silently have no effect. Call it before
  /// reading, to name the misspelt key rather than a missing one.
  void expect(std::initializer_list<std::string_view> known) const {
    for (const auto& entry : table_) {
      const std::string_view key = entry.first.str();
      if (std::find(known.begin(), known.end(), key) != known.end()) continue;
      std::string all = "keys here are ";
      for (const std::string_view name : known) {
        all += (name.data() == known.begin()->data() ? "" : ", ") + std::string(name);
      }
      throw ConfigError(
          file_ + ':' + std::to_string(entry.second.source().begin.line) + ": " +
          unknown("key", prefix_ + std::string(key), {known.begin(), known.end()}, prefix_, all));
    }
  }

 private:
  static std::string text(const toml::node* node) {
    if (node == nullptr) return "nothing";
    std::ostringstream out;
    node->visit([&out](const auto& value) { out << value; });
    constexpr std::size_t kLongest = 80;
    std::string result = out.str();
    if (result.size() > kLongest) result = result.substr(0, kLongest) + "..";
    return result;
  }

  const toml::table& table_;
  std::string file_;
  std::string prefix_;
};

bool is_host_port(const std::string& text) {
  try {
    net::parse_host_port(text);
  } catch (const std::invalid_argument&) {
    return false;
  }
  return true;
}

void read_key_file(const Section& in, const char* key, const std::filesystem::path& folder,
                   std::string& name) {
  if (name.empty()) return;
  name = (folder / name).string();
  try {
    read_session_key(name);
  } catch (const std::invalid_argument& error) {
    in.refuse(key, error.what());
  }
}

void read_organiser(Section& in, const std::filesystem::path& folder, PeerConfig& config) {
  DemoOptions& o = config.session;
  std::string digits;
  in.read("organiser", digits);
  in.read("certificate", o.certificate);
  in.read("group", config.group_file);
  if (!digits.empty()) {
    o.organiser = key_from_hex(digits);
    if (!o.organiser) in.refuse("organiser", "a public key, 64 hex digits, see tandem-key");
  }
  for (const char* key : {"certificate", "group"}) {
    if (in.has(key) && !o.organiser) in.refuse(key, "absent without organiser");
  }
  if (!config.group_file.empty()) config.group_file = (folder / config.group_file).string();
  if (o.certificate.empty()) return;
  o.certificate = (folder / o.certificate).string();
  try {
    (void)read_hex_file(o.certificate);
  } catch (const std::invalid_argument& error) {
    in.refuse("certificate", error.what());
  }
}

/// Reads the keys for connections through NATs.
void read_ice(Section& in, const std::filesystem::path& folder, PeerConfig& config) {
  std::string stun;
  std::string turn;
  in.read("stun", stun);
  in.read("turn", turn);
  if (!stun.empty()) {
    if (!is_host_port(stun)) in.refuse("stun", "\"HOST:PORT\"");
    config.stun = net::parse_host_port(stun);
  }
  if (!turn.empty()) {
    const std::size_t colon = turn.find(':');
    const std::size_t at = turn.rfind('@');
    const bool good = colon != std::string::npos && at != std::string::npos && colon > 0 &&
                      colon + 1 < at && is_host_port(turn.substr(at + 1));
    if (!good) in.refuse("turn", "\"USER:PASSWORD@HOST:PORT\"");
    config.turn = PeerConfig::Turn{net::parse_host_port(turn.substr(at + 1)), turn.substr(0, colon),
                                   turn.substr(colon + 1, at - colon - 1)};
  }
  Section files = in.section("ice");
  files.read_each([&](const std::string& own, const std::string& other) {
    if (own.empty() || other.empty() || own == other) files.refuse(own, "two files");
    config.meetings.emplace_back((folder / own).string(), (folder / other).string());
  });
  for (const char* key : {"stun", "turn"}) {
    if (in.has(key) && config.meetings.empty()) in.refuse(key, "absent without ice");
  }
  if (config.session.wire == Wire::Nats && in.has("ice")) {
    in.refuse("ice", "absent with transport = \"nats\"");
  }
}

void read_network(Section in, const std::filesystem::path& file, const std::string& chosen,
                  PeerConfig& config) {
  const std::filesystem::path folder = file.parent_path();
  DemoOptions& o = config.session;
  in.expect({"transport", "listen", "connect", "servers", "key", "identity", "insecure", "clock",
             "kbit_per_s", "compact", "tolerance", "near", "trusted", "organiser", "certificate",
             "group", "ice", "stun", "turn"});
  std::string transport = "udp";
  in.read("transport", transport);
  if (!chosen.empty()) transport = chosen;
  if (transport != "udp" && transport != "tcp" && transport != "nats") {
    in.refuse("transport", "\"udp\", \"tcp\" or \"nats\"");
  }
  o.wire = transport == "tcp" ? Wire::Tcp : transport == "nats" ? Wire::Nats : Wire::Udp;
  std::uint16_t port = 0;
  in.read("listen", port, 0, 65535, "a port from 0 (any) to 65535");
  if (in.has("listen")) o.listen = port;
  in.read("connect", o.connect, "a list of \"HOST:PORT\", port 1 to 65535", is_host_port);
  in.read("servers", o.servers, "a list of \"HOST:PORT\", port 1 to 65535", is_host_port);
  if (!o.over_network()) in.refuse("listen", "given where connect is not");
  if (o.wire == Wire::Nats && o.servers.empty()) {
    in.refuse("servers", "given with transport = \"nats\"");
  }
  in.read("key", o.key);
  in.read("identity", o.identity);
  in.read("insecure", o.insecure);
  std::string clock = "session";
  in.read("clock", clock);
  if (clock != "session" && clock != "system" && clock != "none") {
    in.refuse("clock", "\"session\", \"system\" or \"none\"");
  }
  o.timeline = clock == "none"     ? Timeline::None
               : clock == "system" ? Timeline::System
                                   : Timeline::Session;
  in.read("kbit_per_s", o.budget, 32.0, 1e6, "a number from 32 to 1e6 kbit/s");
  in.read("compact", o.compact);
  in.read("tolerance", o.tolerance, 0.0, 10.0, "a number from 0 to 10 m");
  in.read("near", o.interest_radius, 0.0, 1e4, "a number from 0 to 1e4 m");
  if (o.wire == Wire::Tcp) {
    for (const char* key : {"clock", "kbit_per_s", "ice", "stun", "turn"}) {
      if (in.has(key)) in.refuse(key, "absent with transport = \"tcp\"");
    }
  }
  if (o.key.empty() == !o.insecure) {
    in.refuse("key", "a file with the session's key, or insecure = true on one machine");
  }
  read_key_file(in, "key", folder, o.key);
  read_key_file(in, "identity", folder, o.identity);
  read_organiser(in, folder, config);
  read_ice(in, folder, config);
  // The first start creates it.
  if (!o.key.empty() && o.identity.empty()) {
    o.identity = (folder / file.stem()).string() + ".identity";
  }
  Section trusted = in.section("trusted");
  trusted.read_each([&](const std::string& id, const std::string& digits) {
    const std::optional<Key> key = key_from_hex(digits);
    std::uint64_t peer = 0;
    if (!pbd::detail::parse_number(id, peer) || peer == 0 || peer == o.peer_id || !key) {
      trusted.refuse(id, "another peer's id and its public key, 64 hex digits");
    }
    o.trusted.emplace_back(peer, *key);
  });
  if (o.insecure && (!o.identity.empty() || !o.trusted.empty() || o.organiser)) {
    in.refuse("insecure", "absent with identity, trusted or organiser");
  }
  for (const std::string& address : o.connect) {
    if (o.insecure && !is_loopback(net::parse_host_port(address).host)) {
      in.refuse("connect", "addresses of this machine, with insecure = true");
    }
  }
}

PeerConfig read(const toml::table& table, const std::string& name, const std::string& transport) {
  const std::filesystem::path folder = std::filesystem::path(name).parent_path();
  PeerConfig config;
  DemoOptions& o = config.session;
  Section top(table, name, "");
  top.expect({"id", "seed", "step_hz", "update_hz", "network", "user", "log", "status", "metrics",
              "view"});
  constexpr std::int64_t kMax = std::numeric_limits<std::int64_t>::max();
  top.read("id", o.peer_id, 1, std::int64_t{1} << 62, "an integer >= 1, unique in the session");
  top.read("seed", o.seed, 0, kMax, "an integer >= 0");
  top.read("step_hz", o.rates.front(), 10.0, 1000.0, "a number from 10 to 1000");
  top.read("update_hz", o.update_hz, 0.1, 1000.0, "a number from 0.1 to 1000");
  read_network(top.section("network"), name, transport, config);
  if (!top.has("id") && o.insecure) top.refuse("id", "given, unique in the session, without a key");

  Section user = top.section("user");
  user.expect({"fidget", "seed"});
  user.read("fidget", config.fidget);
  user.read("seed", config.user_seed, 0, kMax, "an integer >= 0");

  Section log = top.section("log");
  log.expect({"file", "level"});
  log.read("file", config.log_file);
  if (!config.log_file.empty()) config.log_file = (folder / config.log_file).string();
  std::string level(to_string(config.log_level));
  log.read("level", level);
  if (!parse_level(level, config.log_level)) {
    log.refuse("level", "\"debug\", \"info\", \"warn\" or \"error\"");
  }

  Section status = top.section("status");
  status.expect({"line"});
  status.read("line", config.status_line);

  Section metrics = top.section("metrics");
  metrics.expect({"port", "address"});
  std::uint16_t port = 0;
  metrics.read("port", port, 0, 65535, "a port from 0 (any) to 65535");
  if (metrics.has("port")) config.metrics_port = port;
  metrics.read("address", config.metrics_address);

  Section view = top.section("view");
  view.expect({"port", "address"});
  std::uint16_t page = 0;
  view.read("port", page, 0, 65535, "a port from 0 (any) to 65535");
  if (view.has("port")) o.view = page;
  view.read("address", o.view_address);
  return config;
}

}  // namespace

PeerConfig parse_config(std::string_view text, const std::string& name,
                        const std::string& transport) {
  try {
    return read(toml::parse(text, name), name, transport);
  } catch (const toml::parse_error& error) {
    throw ConfigError(name + ':' + std::to_string(error.source().begin.line) +
                      ": no TOML: " + std::string(error.description()));
  }
}

void derive_id(PeerConfig& config) {
  DemoOptions& o = config.session;
  if (o.peer_id != 0) return;
  try {
    o.peer_id = net::derived_id(net::public_key(keep_identity(o.identity, net::make_key)));
  } catch (const std::system_error& error) {
    // Without a stored key each start would be another member.
    throw ConfigError("id must be given where no identity can be kept: " +
                      std::string(error.what()));
  }
}

PeerConfig read_config(const std::string& path, const std::string& transport) {
  std::ifstream file(path, std::ios::binary);
  std::stringstream text;
  text << file.rdbuf();
  if (!file) throw ConfigError(path + ": cannot be read");
  return parse_config(text.str(), path, transport);
}

}  // namespace tandem::demos
