// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "description.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace tandem::ice {

namespace {

constexpr std::string_view kFirst = "tandem-ice 1";
constexpr std::string_view kUfrag = "ufrag ";
constexpr std::string_view kPassword = "pwd ";
constexpr std::string_view kCandidate = "candidate:";
constexpr std::size_t kMaxText = 16 * 1024;  // bytes
constexpr std::size_t kMaxLine = 400;        // bytes
constexpr std::size_t kMaxCandidates = 64;

[[noreturn]] void refuse(const std::string& what) {
  throw std::invalid_argument("ICE description: " + what);
}

/// ice-char of RFC 8839.
bool is_ice_text(std::string_view text, std::size_t least) {
  return text.size() >= least && text.size() <= 256 && std::ranges::all_of(text, [](char c) {
           return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                  c == '+' || c == '/';
         });
}

}  // namespace

std::string encode(const Description& description) {
  std::string out = std::string(kFirst) + '\n' + std::string(kUfrag) + description.ufrag + '\n' +
                    std::string(kPassword) + description.password + '\n';
  for (const std::string& candidate : description.candidates) out += candidate + '\n';
  return out;
}

Description parse_description(std::string_view text) {
  if (text.size() > kMaxText) refuse("must have at most 16 KiB");
  Description out;
  bool first = true;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    if (line.empty()) continue;
    if (line.size() > kMaxLine) refuse("lines must have at most 400 bytes");
    if (!std::ranges::all_of(line, [](char c) { return c >= ' ' && c <= '~'; })) {
      refuse("must be printable ASCII");
    }
    if (std::exchange(first, false)) {
      if (line != kFirst) refuse("must begin with the line \"" + std::string(kFirst) + '"');
    } else if (line.starts_with(kUfrag)) {
      out.ufrag = line.substr(kUfrag.size());
    } else if (line.starts_with(kPassword)) {
      out.password = line.substr(kPassword.size());
    } else if (line.starts_with(kCandidate)) {
      if (out.candidates.size() == kMaxCandidates) refuse("must have at most 64 candidates");
      out.candidates.emplace_back(line);
    } else {
      refuse("lines must begin with ufrag, pwd or candidate:");
    }
  }
  if (!is_ice_text(out.ufrag, 4)) refuse("ufrag must have 4 to 256 letters, digits, + or /");
  if (!is_ice_text(out.password, 22)) refuse("pwd must have 22 to 256 letters, digits, + or /");
  if (out.candidates.empty()) refuse("must have a candidate");
  return out;
}

}  // namespace tandem::ice
