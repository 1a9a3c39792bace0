// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <filesystem>
#include <string>

#include "peer/config.h"
#include "session/key_file.h"
#include "support/catch.h"
#include "tandem/net/membership.h"

namespace tandem::demos::peer_config_test {
namespace {

const std::string kNetwork = "[network]\nlisten = 7777\ninsecure = true\n";

void write_key(const std::filesystem::path& path, const std::string& text) {
  std::filesystem::remove(path);
  write_for_owner_alone(path.string(), text);
}

/// The error for a file of this text; empty if there is none.
std::string refusal(const std::string& text) {
  try {
    parse_config(text, "peers.toml");
  } catch (const ConfigError& error) {
    return error.what();
  }
  return {};
}

TEST_CASE("peer config: the least that is needed is an id and a way to others", "[demos][unit]") {
  const PeerConfig c = parse_config("id = 3\n" + kNetwork, "peers.toml");
  CHECK(c.session.peer_id == 3);
  CHECK(c.session.listen == std::uint16_t{7777});
  CHECK(c.session.udp());
  CHECK_FALSE(c.fidget);
  CHECK_FALSE(c.metrics_port.has_value());
  CHECK(c.metrics_address == "127.0.0.1");
}

TEST_CASE("peer config: over NATS a server is needed and no port", "[demos][unit]") {
  const std::string servers =
      "id = 3\n[network]\nservers = [\"localhost:4222\"]\ninsecure = true\n";
  const PeerConfig c = parse_config(servers + "transport = \"nats\"\n", "peers.toml");
  CHECK(c.session.wire == Wire::Nats);
  CHECK(c.session.servers == std::vector<std::string>{"localhost:4222"});
  CHECK_FALSE(c.session.udp());
  CHECK(parse_config(servers, "peers.toml", "nats").session.wire == Wire::Nats);
  CHECK(refusal(servers).find("network.listen must be given") != std::string::npos);
  CHECK(refusal("id = 3\n" + kNetwork + "transport = \"nats\"\n").find("network.servers must be") !=
        std::string::npos);
  CHECK(refusal("id = 3\n" + kNetwork + "transport = \"pigeon\"\n")
            .find("network.transport must be \"udp\", \"tcp\" or \"nats\"") != std::string::npos);
}

TEST_CASE("peer config: without an id a peer has the one of its key, which is kept",
          "[demos][unit]") {
  const std::filesystem::path folder = std::filesystem::temp_directory_path();
  const std::filesystem::path identity = folder / "tandem_config_derived.identity";
  const std::filesystem::path key = folder / "tandem_config_derived.key";
  std::filesystem::remove(identity);
  write_key(key, std::string(64, 'a'));
  const auto started = [&] {
    PeerConfig c = parse_config(
        "[network]\nlisten = 0\nkey = \"tandem_config_derived.key\"\n"
        "[network.ice]\n\"own\" = \"other\"\n",
        (folder / "tandem_config_derived.toml").string());
    CHECK(c.session.peer_id == 0);
    derive_id(c);
    CHECK(c.meetings.size() == 1);
    return c.session.peer_id;
  };
  const std::uint64_t first = started();
  CHECK(tandem::net::is_derived(first));
  CHECK(started() == first);
  std::filesystem::remove(identity);
  CHECK(started() != first);
  PeerConfig given;
  given.session.peer_id = 7;
  derive_id(given);
  CHECK(given.session.peer_id == 7);
  std::filesystem::remove(identity);
  std::filesystem::remove(key);
}

TEST_CASE("peer config: every key reaches its field", "[demos][unit]") {
  const std::filesystem::path folder = std::filesystem::temp_directory_path();
  write_key(folder / "tandem_config_key", std::string(64, 'a'));
  const PeerConfig c = parse_config(R"(
id = 2
seed = 9
step_hz = 72
update_hz = 30.5
[network]
transport = "udp"
listen = 0
connect = ["localhost:1", "[::1]:2"]
key = "tandem_config_key"
kbit_per_s = 256
compact = true
tolerance = 0.002
identity = "tandem_config_key"
[network.trusted]
7 = "0101010101010101010101010101010101010101010101010101010101010102"
[user]
fidget = true
seed = 5
[log]
file = "peer.log"
level = "warn"
[status]
line = false
[metrics]
port = 0
address = "::1"
)",
                                    (folder / "peers.toml").string());
  std::filesystem::remove(folder / "tandem_config_key");
  CHECK(c.session.seed == 9);
  CHECK(c.session.step_hz(0) == 72.0);
  CHECK(c.session.update_hz == 30.5);
  CHECK(c.session.listen == std::uint16_t{0});
  CHECK(c.session.connect == std::vector<std::string>{"localhost:1", "[::1]:2"});
  CHECK(c.session.key == (folder / "tandem_config_key").string());
  CHECK(c.session.budget == 256.0);
  CHECK(c.session.compact);
  CHECK(c.session.tolerance == 0.002);
  CHECK(c.session.identity == c.session.key);
  REQUIRE(c.session.trusted.size() == 1);
  CHECK(c.session.trusted[0].first == 7);
  CHECK(c.session.trusted[0].second[0] == 1);
  CHECK(c.session.trusted[0].second[31] == 2);
  CHECK(c.fidget);
  CHECK(c.user_seed == 5);
  CHECK(c.log_file == (folder / "peer.log").string());
  CHECK(c.log_level == Level::Warn);
  CHECK_FALSE(c.status_line);
  CHECK(c.metrics_port == std::uint16_t{0});
  CHECK(c.metrics_address == "::1");
}

TEST_CASE("peer config: an identity of its own by default, and an organiser", "[demos]") {
  const std::filesystem::path folder = std::filesystem::temp_directory_path();
  const auto file = [&folder](const char* name, const std::string& text) {
    write_key(folder / name, text);
  };
  file("tandem_config_key", std::string(64, '7'));
  file("tandem_certificate", "0a0b");
  const std::string network = "id = 3\n[network]\nlisten = 0\nkey = \"tandem_config_key\"\n";
  const auto parse = [&](const std::string& text) {
    return parse_config(text, (folder / "third.toml").string());
  };
  CHECK(parse(network).session.identity == (folder / "third.identity").string());
  CHECK_FALSE(parse(network).session.organiser);
  const std::string organiser = "organiser = \"" + std::string(63, '0') + "1\"\n";
  const PeerConfig c =
      parse(network + organiser + "certificate = \"tandem_certificate\"\ngroup = \"group.hex\"\n");
  REQUIRE(c.session.organiser);
  CHECK((*c.session.organiser)[31] == 1);
  CHECK(c.session.certificate == (folder / "tandem_certificate").string());
  CHECK(c.group_file == (folder / "group.hex").string());
  CHECK_THROWS_AS(parse(network + "certificate = \"tandem_certificate\"\n"), ConfigError);
  CHECK_THROWS_AS(parse(network + "organiser = \"01\"\n"), ConfigError);
  CHECK_THROWS_AS(parse(network + organiser + "certificate = \"nowhere\"\n"), ConfigError);
  CHECK_THROWS_AS(parse("id = 3\n[network]\nlisten = 0\ninsecure = true\n" + organiser),
                  ConfigError);
  CHECK_FALSE(parse("id = 3\n[network]\nlisten = 0\ninsecure = true\n").session.identity.size());
  std::filesystem::remove(folder / "tandem_config_key");
  std::filesystem::remove(folder / "tandem_certificate");
}

TEST_CASE("peer config: a refusal names file, line, key, value and rule", "[demos][fault]") {
  CHECK(refusal("").find("peers.toml") == 0);
  CHECK(refusal("[network]\nlisten = 0\ninsecure = true\n").find("peers.toml: id must be given") ==
        0);
  CHECK(refusal("id = 0\n" + kNetwork) ==
        "peers.toml:1: id must be an integer >= 1, unique in the session, is 0");
  CHECK(refusal("id = 1.5\n" + kNetwork).find("peers.toml:1: id must be an integer") == 0);
  CHECK(refusal("id = 1\nstep_hz = nan\n" + kNetwork) ==
        "peers.toml:2: step_hz must be a number from 10 to 1000, is nan");
  CHECK(refusal("id = 1\n" + kNetwork + "kbit_per_s = 5\n") ==
        "peers.toml:5: network.kbit_per_s must be a number from 32 to 1e6 kbit/s, is 5");
  CHECK(refusal("id = 1\n[network]\nlisten = 70000\ninsecure = true\n") ==
        "peers.toml:3: network.listen must be a port from 0 (any) to 65535, is 70000");
  CHECK(refusal("id = 1\n" + kNetwork + "connect = [\"nowhere\"]\n").find("peers.toml:5: ") == 0);
  CHECK(refusal("id = 1\n" + kNetwork + "connect = [\"10.0.0.1:80\"]\n")
            .find("must be addresses of this machine, with insecure = true") != std::string::npos);
  CHECK(refusal("id = 1\n[network]\nlisten = 1\n").find("network.key must be a file") !=
        std::string::npos);
  CHECK(refusal("id = 1\n[network]\nlisten = 1\nkey = \"/nowhere\"\n")
            .find("must be a file that can be read") != std::string::npos);
  CHECK(refusal("id = 1\n[network]\ninsecure = true\n")
            .find("network.listen must be given where connect is not, is nothing") !=
        std::string::npos);
  CHECK(refusal("id = 1\n[network]\ntransport = \"tcp\"\nlisten = 1\n")
            .find("network.key must be a file") != std::string::npos);
  CHECK(refusal("id = 1\n[network]\ntransport = \"tcp\"\nlisten = 1\nclock = \"system\"\n")
            .find("network.clock must be ") != std::string::npos);
  CHECK(refusal("id = 1\n" + kNetwork + "[log]\nlevel = \"loud\"\n").find("log.level must be ") !=
        std::string::npos);
}

TEST_CASE("peer config: a trusted peer is an id and a whole key", "[demos][fault]") {
  const std::string network = "[network]\nlisten = 1\ninsecure = true\n[network.trusted]\n";
  for (const std::string& bad :
       {std::string("2 = \"12\""), std::string("2 = 12"), "0 = \"" + std::string(64, '1') + '"',
        "1 = \"" + std::string(64, '1') + '"', "bob = \"" + std::string(64, '1') + '"'}) {
    CAPTURE(bad);
    CHECK(refusal("id = 1\n" + network + bad + "\n").find("peers.toml:6: network.trusted.") == 0);
  }
}

TEST_CASE("peer config: a misspelt key is refused, not ignored", "[demos][fault]") {
  CHECK(refusal("id = 1\nfidget = true\n" + kNetwork)
            .find("peers.toml:2: unknown key 'fidget'; keys here are id, ") == 0);
  CHECK(refusal("id = 1\n" + kNetwork + "[user]\nfiget = true\n")
            .find("peers.toml:6: unknown key 'user.figet'; did you mean 'user.fidget'?") == 0);
  // The error names the misspelt key, not the missing one.
  CHECK(refusal("id = 1\n[netwrk]\nlisten = 1\n")
            .find("peers.toml:2: unknown key 'netwrk'; did you mean 'network'?") == 0);
  CHECK(refusal("id = 1\n[network]\nlisen = 1\ninsecure = true\n")
            .find("peers.toml:3: unknown key 'network.lisen'; did you mean 'network.listen'?") ==
        0);
  CHECK(refusal("id = 1\nuser = 3\n" + kNetwork).find("user must be a table, is 3") !=
        std::string::npos);
}

TEST_CASE("peer config: invalid TOML is refused with its line", "[demos][fault]") {
  CHECK(refusal("id = 1\nid = = 2\n").find("peers.toml:2: no TOML: ") == 0);
  CHECK_THROWS_AS(read_config("/nowhere/peers.toml"), ConfigError);
}

TEST_CASE("peer config: the page has a port and an address of its own", "[demos][unit]") {
  CHECK_FALSE(parse_config("id = 3\n" + kNetwork, "peers.toml").session.view);
  const PeerConfig c =
      parse_config("id = 3\n" + kNetwork + "[view]\nport = 0\naddress = \"::1\"\n", "peers.toml");
  CHECK(c.session.view == std::uint16_t{0});
  CHECK(c.session.view_address == "::1");
  CHECK_FALSE(refusal("id = 3\n" + kNetwork + "[view]\nport = 65536\n").empty());
}

}  // namespace
}  // namespace tandem::demos::peer_config_test
