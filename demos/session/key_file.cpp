// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "session/key_file.h"

#ifndef _WIN32

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <system_error>
#include <utility>

namespace tandem::demos {

bool for_owner_alone(const std::string& path) {
  using std::filesystem::perms;
  std::error_code error;
  const perms found = std::filesystem::status(path, error).permissions();
  return !error && (found & (perms::group_all | perms::others_all)) == perms::none;
}

void write_for_owner_alone(const std::string& path, std::string_view text) {
  // Created with these rights, never with more.
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (file < 0) throw std::system_error(errno, std::system_category(), path);
  const auto written = ::write(file, text.data(), text.size());
  const int error = errno;
  const bool whole = std::cmp_equal(written, text.size());
  if (::close(file) != 0 || !whole) {
    ::unlink(path.c_str());
    throw std::system_error(whole ? errno : error, std::system_category(), path);
  }
}

}  // namespace tandem::demos

#else

#include <windows.h>
// After windows.h.
#include <aclapi.h>
#include <sddl.h>

#include <array>
#include <memory>
#include <system_error>

namespace tandem::demos {

namespace {

[[noreturn]] void fail(DWORD error, const std::string& what) {
  throw std::system_error(static_cast<int>(error), std::system_category(), what);
}

template <typename T>
using Local = std::unique_ptr<T, decltype([](T* memory) { LocalFree(memory); })>;

/// The user of this process.
class Account {
 public:
  Account() {
    HANDLE token = nullptr;
    DWORD size = 0;
    const bool got = OpenProcessToken(GetCurrentProcess(), TOKEN_QUERY, &token) != 0 &&
                     GetTokenInformation(token, TokenUser, bytes_.data(),
                                         static_cast<DWORD>(bytes_.size()), &size) != 0;
    const DWORD error = GetLastError();
    if (token != nullptr) CloseHandle(token);
    if (!got) fail(error, "the user of this process");
  }
  PSID id() { return reinterpret_cast<TOKEN_USER*>(bytes_.data())->User.Sid; }

 private:
  alignas(TOKEN_USER) std::array<std::byte, sizeof(TOKEN_USER) + SECURITY_MAX_SID_SIZE> bytes_{};
};

/// True for the accounts of `for_owner_alone`.
bool is_owner(PSID who, PSID user) {
  return EqualSid(who, user) != 0 || IsWellKnownSid(who, WinLocalSystemSid) != 0 ||
         IsWellKnownSid(who, WinBuiltinAdministratorsSid) != 0;
}

/// True if an entry admits only them.
bool harmless(void* entry, PSID user) {
  constexpr DWORD kInside = FILE_READ_DATA | FILE_WRITE_DATA | FILE_APPEND_DATA | WRITE_DAC |
                            WRITE_OWNER | GENERIC_READ | GENERIC_WRITE | GENERIC_ALL;
  const auto& head = *static_cast<ACE_HEADER*>(entry);
  if ((head.AceFlags & INHERIT_ONLY_ACE) != 0 || head.AceType == ACCESS_DENIED_ACE_TYPE)
    return true;
  if (head.AceType != ACCESS_ALLOWED_ACE_TYPE) return false;  // let in on conditions
  auto& allowed = *static_cast<ACCESS_ALLOWED_ACE*>(entry);
  return (allowed.Mask & kInside) == 0 || is_owner(&allowed.SidStart, user);
}

}  // namespace

bool for_owner_alone(const std::string& path) {
  PACL list = nullptr;
  PSID owner = nullptr;  // may change the list
  PSECURITY_DESCRIPTOR found = nullptr;
  const DWORD error = GetNamedSecurityInfoA(path.c_str(), SE_FILE_OBJECT,
                                            OWNER_SECURITY_INFORMATION | DACL_SECURITY_INFORMATION,
                                            &owner, nullptr, &list, nullptr, &found);
  const Local<void> held(found);
  if (error != ERROR_SUCCESS || list == nullptr) return false;  // no list: full access for all
  Account user;
  if (owner == nullptr || !is_owner(owner, user.id())) return false;
  for (DWORD i = 0; i < list->AceCount; ++i) {
    void* entry = nullptr;
    if (GetAce(list, i, &entry) == 0 || !harmless(entry, user.id())) return false;
  }
  return true;
}

void write_for_owner_alone(const std::string& path, std::string_view text) {
  Account user;
  char* id = nullptr;
  if (ConvertSidToStringSidA(user.id(), &id) == 0) fail(GetLastError(), path);
  const Local<char> held_id(id);
  // A protected list (P): full access (FA) for this user, the system and its administrators.
  const std::string rights = "D:P(A;;FA;;;" + std::string(id) + ")(A;;FA;;;SY)(A;;FA;;;BA)";
  PSECURITY_DESCRIPTOR made = nullptr;
  if (ConvertStringSecurityDescriptorToSecurityDescriptorA(rights.c_str(), SDDL_REVISION_1, &made,
                                                           nullptr) == 0) {
    fail(GetLastError(), path);
  }
  const Local<void> held(made);
  SECURITY_ATTRIBUTES attributes{sizeof(SECURITY_ATTRIBUTES), made, FALSE};
  const HANDLE file = CreateFileA(path.c_str(), GENERIC_WRITE, 0, &attributes, CREATE_NEW,
                                  FILE_ATTRIBUTE_NORMAL, nullptr);
  if (file == INVALID_HANDLE_VALUE) fail(GetLastError(), path);
  DWORD written = 0;
  const bool whole =
      WriteFile(file, text.data(), static_cast<DWORD>(text.size()), &written, nullptr) != 0 &&
      written == text.size();
  const DWORD error = GetLastError();
  CloseHandle(file);
  if (whole) return;
  DeleteFileA(path.c_str());
  fail(error, path);
}

}  // namespace tandem::demos

#endif
