// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <filesystem>
#include <fstream>
#include <string>

#include "tandem/pbd/validate.h"
#include "tandem/scene_files.h"

namespace tandem::scene_files {

/// The bytes of a file, at most kMaxSceneBytes. @throws SceneFileError
inline std::string read_bytes(const std::filesystem::path& path) {
  const auto refuse = [&path](std::string_view rule) {
    throw SceneFileError(pbd::detail::must_be(path.string() + ": file", rule));
  };
  std::error_code error;
  // Excludes devices and pipes, which may never end.
  if (!std::filesystem::is_regular_file(path, error)) refuse("one that is there and can be read");
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error || size > kMaxSceneBytes) {
    refuse("of at most " + std::to_string(kMaxSceneBytes) + " bytes");
  }
  std::ifstream in(path, std::ios::binary);
  std::string text(static_cast<std::size_t>(size), '\0');
  in.read(text.data(), static_cast<std::streamsize>(size));
  if (!in) refuse("one that can be read to its end");
  return text;
}

}  // namespace tandem::scene_files
