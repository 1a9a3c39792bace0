// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "session/session_key.h"

#ifdef _WIN32
#include <windows.h>
// After it.
#include <aclapi.h>
#endif

#include <array>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>

#include "session/key_file.h"
#include "support/catch.h"

namespace tandem::demos::session_key_test {
namespace {

namespace fs = std::filesystem;

/// No two are equal.
Key another_key() {
  static std::uint8_t count = 0;
  Key key{};
  key.front() = ++count;
  return key;
}

/// The rule that a file with this text breaks; empty where it holds a key.
std::string refusal(const std::string& text, fs::perms access = fs::perms(0600)) {
  const std::string path =
      (std::filesystem::temp_directory_path() / "tandem_session_key_test").string();
  fs::remove(path);
  write_for_owner_alone(path, text);
  fs::permissions(path, access);
  std::string result;
  try {
    read_session_key(path);
  } catch (const std::invalid_argument& error) {
    result = error.what();
  }
  std::filesystem::remove(path);
  return result;
}

TEST_CASE("session key: 64 hex digits of either case, with white space", "[demos][unit]") {
  std::string digits;
  for (int i = 0; i < 32; ++i) digits += i % 2 == 0 ? "0a " : "F1\n";
  const std::string path =
      (std::filesystem::temp_directory_path() / "tandem_session_key_good").string();
  fs::remove(path);
  write_for_owner_alone(path, digits);
  const auto key = read_session_key(path);
  std::filesystem::remove(path);
  CHECK(key[0] == 0x0a);
  CHECK(key[31] == 0xf1);
}

TEST_CASE("session key: anything else is refused with the rule", "[demos][fault]") {
  CHECK(refusal(std::string(64, '7')).empty());
  for (const std::string& bad :
       {std::string(), std::string(63, '7'), std::string(65, '7'), std::string(63, '7') + "g",
        "0x" + std::string(62, '7'), std::string(62, '7') + "-1", std::string(64, '0')}) {
    CAPTURE(bad);
    CHECK(refusal(bad) == "a file with 64 hex digits, not all 0, see tandem-key");
  }
  CHECK_THROWS_AS(read_session_key("/nowhere/at/all"), std::invalid_argument);
}

#ifdef _WIN32
/// Lets everybody do this with a file, besides whom it lets in.
void let_in(const std::string& path, DWORD access) {
  PACL old = nullptr;
  PACL list = nullptr;
  PSECURITY_DESCRIPTOR held = nullptr;
  REQUIRE(GetNamedSecurityInfoA(path.c_str(), SE_FILE_OBJECT, DACL_SECURITY_INFORMATION, nullptr,
                                nullptr, &old, nullptr, &held) == ERROR_SUCCESS);
  std::array<BYTE, SECURITY_MAX_SID_SIZE> everybody{};
  auto size = static_cast<DWORD>(everybody.size());
  REQUIRE(CreateWellKnownSid(WinWorldSid, nullptr, everybody.data(), &size) != 0);
  EXPLICIT_ACCESSA entry{access, GRANT_ACCESS, NO_INHERITANCE, {}};
  BuildTrusteeWithSidA(&entry.Trustee, everybody.data());
  REQUIRE(SetEntriesInAclA(1, &entry, old, &list) == ERROR_SUCCESS);
  std::string name = path;
  REQUIRE(SetNamedSecurityInfoA(name.data(), SE_FILE_OBJECT, DACL_SECURITY_INFORMATION, nullptr,
                                nullptr, list, nullptr) == ERROR_SUCCESS);
  LocalFree(list);
  LocalFree(held);
}

TEST_CASE("session key: a file that others can read or write is refused", "[demos][fault]") {
  const std::string path = (fs::temp_directory_path() / "tandem_key_access").string();
  for (const DWORD access : {FILE_GENERIC_READ, FILE_GENERIC_WRITE, FILE_ALL_ACCESS}) {
    CAPTURE(access);
    fs::remove(path);
    write_for_owner_alone(path, std::string(64, '7'));
    CHECK_NOTHROW(read_session_key(path));
    let_in(path, access);
    CHECK_THROWS_WITH(read_session_key(path), std::string(kForOwnerAlone));
  }
  fs::remove(path);
}
#else
TEST_CASE("session key: a file that others can read or write is refused", "[demos][fault]") {
  const std::string key(64, '7');
  CHECK(refusal(key, fs::perms(0600)).empty());
  CHECK(refusal(key, fs::perms(0400)).empty());
  for (const unsigned mode : {0604U, 0640U, 0660U, 0602U, 0644U, 0666U}) {
    CAPTURE(mode);
    CHECK(refusal(key, fs::perms(mode)) == "a file that nobody else can read or write (chmod 600)");
  }
}
#endif

TEST_CASE("session key: an identity is made at the first start and kept for its owner alone",
          "[demos]") {
  const fs::path path = fs::temp_directory_path() / "tandem_kept_identity";
  fs::remove(path);
  const auto first = keep_identity(path.string(), another_key);
  CHECK(for_owner_alone(path.string()));
#ifndef _WIN32
  CHECK((fs::status(path).permissions() & fs::perms(0777)) == fs::perms(0600));
#endif
  CHECK(keep_identity(path.string(), another_key) == first);
  CHECK(read_session_key(path.string()) == first);
#ifndef _WIN32
  fs::permissions(path, fs::perms(0644));
  CHECK_THROWS_AS(keep_identity(path.string(), another_key), std::invalid_argument);
#endif
  fs::remove(path);
  CHECK(keep_identity(path.string(), another_key) != first);
  fs::remove(path);
  CHECK_THROWS_AS(keep_identity("/nowhere/at/all", another_key), std::system_error);
}

TEST_CASE("session key: hex digits of any length are bytes", "[demos][unit]") {
  const std::string path = (fs::temp_directory_path() / "tandem_hex").string();
  const auto read = [&path](const std::string& text) {
    std::ofstream(path) << text;
    return read_hex_file(path);
  };
  CHECK(read("0a fF\n10") ==
        std::vector<std::byte>{std::byte{0x0a}, std::byte{0xff}, std::byte{0x10}});
  for (const char* bad : {"", "0", "0x", "012", "0g"}) {
    CAPTURE(bad);
    CHECK_THROWS_AS(read(bad), std::invalid_argument);
  }
  fs::remove(path);
  CHECK_THROWS_AS(read_hex_file(path), std::invalid_argument);
}

#ifndef _WIN32
TEST_CASE("session key: secret hex digits are read if nobody else can read or write them",
          "[demos]") {
  const fs::path path = fs::temp_directory_path() / "tandem_secret_hex";
  std::ofstream(path) << "0aff";
  fs::permissions(path, fs::perms(0600));
  CHECK(read_secret_hex_file(path.string()).size() == 2);
  for (const fs::perms others : {fs::perms(0640), fs::perms(0604), fs::perms(0602)}) {
    fs::permissions(path, others);
    CHECK_THROWS_WITH(read_secret_hex_file(path.string()), std::string(kForOwnerAlone));
  }
  fs::remove(path);
  CHECK_THROWS_WITH(read_secret_hex_file(path.string()), "a file that can be read");
}
#endif

TEST_CASE("session key: a name that begins like a loopback address is none", "[demos][unit]") {
  for (const char* host : {"localhost", "::1", "127.0.0.1", "127.1.2.3"}) CHECK(is_loopback(host));
  for (const char* host : {"127.evil.org", "10.0.0.1", "localhost.org", "0.0.0.0", ""}) {
    CHECK_FALSE(is_loopback(host));
  }
}

}  // namespace
}  // namespace tandem::demos::session_key_test
