// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "server/page_files.h"

#include <array>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace tandem::room {

namespace {

constexpr std::array<std::pair<std::string_view, std::string_view>, 6> kTypes = {{
    {".html", "text/html; charset=utf-8"},
    {".js", "text/javascript; charset=utf-8"},
    {".css", "text/css; charset=utf-8"},
    {".svg", "image/svg+xml"},
    {".json", "application/json"},
    {".wasm", "application/wasm"},
}};

}  // namespace

PageFiles::PageFiles(const std::string& folder) {
  std::error_code none;
  for (const auto& entry : std::filesystem::directory_iterator(folder, none)) {
    if (entry.path().extension() != ".gz") continue;
    std::ifstream file(entry.path(), std::ios::binary);
    add(entry.path().stem().string(), std::string(std::istreambuf_iterator<char>(file), {}));
  }
  if (find("") == nullptr) {
    throw std::runtime_error("there is no page in '" + folder +
                             "'; target tandem_room_page of preset web makes it (docs/room.md)");
  }
}

PageFiles::PageFiles(const std::map<std::string, std::string>& files) {
  for (const auto& [name, bytes] : files) add(name, bytes);
}

void PageFiles::add(std::string name, std::string bytes) {
  for (const auto& [ending, mime] : kTypes) {
    if (name.size() <= ending.size() || !std::string_view(name).ends_with(ending)) continue;
    if (name == "index.html") name.clear();
    files_[std::move(name)] = {mime, std::move(bytes)};
    return;
  }
}

const PageFile* PageFiles::find(std::string_view name) const {
  const auto found = files_.find(name);
  return found == files_.end() ? nullptr : &found->second;
}

}  // namespace tandem::room
