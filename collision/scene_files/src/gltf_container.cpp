// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "gltf_container.h"

#include <cstdint>
#include <string>

#include "tandem/pbd/validate.h"
#include "tandem/scene_files.h"

namespace tandem::scene_files {
namespace {

constexpr std::string_view kMagic = "glTF";
constexpr std::size_t kHeader = 12;      // bytes: magic, version, length of all
constexpr std::size_t kChunkHeader = 8;  // length, type
constexpr std::uint32_t kJson = 0x4E4F534A;
constexpr std::uint32_t kBinary = 0x004E4942;

/// Little endian. @pre  there are four bytes
std::uint32_t number_at(std::string_view bytes, std::size_t at) {
  std::uint32_t out = 0;
  for (std::size_t i = 4; i-- > 0;) out = out << 8 | static_cast<std::uint8_t>(bytes[at + i]);
  return out;
}

}  // namespace

GltfContainer GltfContainer::of(std::string_view bytes, std::string_view file) {
  if (bytes.substr(0, kMagic.size()) != kMagic) return {.document = bytes, .binary = {}};
  const auto refuse = [&](const char* what, std::string_view rule, std::uint32_t value) {
    throw SceneFileError(
        pbd::detail::must_be(std::string(file) + ": " + what, rule, std::to_string(value)));
  };
  const auto size = static_cast<std::uint32_t>(bytes.size());
  if (bytes.size() > kMaxSceneBytes) {
    refuse("size", "at most " + std::to_string(kMaxSceneBytes) + " bytes", size);
  }
  if (bytes.size() < kHeader) refuse("container", "of 12 bytes or more", size);
  const std::uint32_t version = number_at(bytes, 4);
  if (version != 2) refuse("container's version", "2", version);
  const std::uint32_t length = number_at(bytes, 8);
  if (length != bytes.size()) refuse("container's length", "that of the file", length);
  GltfContainer out;
  for (std::size_t at = kHeader; at < bytes.size();) {
    const std::size_t left = bytes.size() - at;
    if (left < kChunkHeader)
      refuse("chunk", "of 8 bytes or more", static_cast<std::uint32_t>(left));
    const std::uint32_t count = number_at(bytes, at);
    const std::uint32_t type = number_at(bytes, at + 4);
    if (count > left - kChunkHeader || count % 4 != 0) {
      refuse("chunk's length", "a multiple of 4, and within the file", count);
    }
    const std::string_view chunk = bytes.substr(at + kChunkHeader, count);
    if (at == kHeader) {
      if (type != kJson) refuse("first chunk's type", "JSON", type);
      out.document = chunk;
    } else if (type == kBinary && out.binary.empty()) {
      out.binary = chunk;
    }  // unknown chunks must be skipped
    at += kChunkHeader + count;
  }
  return out;
}

}  // namespace tandem::scene_files
