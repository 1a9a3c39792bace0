// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <map>
#include <string>
#include <string_view>

namespace tandem::room {

struct PageFile {
  std::string_view mime;
  std::string bytes;  ///< compressed by gzip
};

/// The page's files by name, "" for index.html, read at construction: no request reaches the disk.
class PageFiles {
 public:
  /// Each NAME.gz of a folder. @throws std::runtime_error if there is no index.html.gz
  explicit PageFiles(const std::string& folder);
  /// For tests. @pre types are known
  explicit PageFiles(const std::map<std::string, std::string>& files);

  const PageFile* find(std::string_view name) const;

 private:
  void add(std::string name, std::string bytes);

  std::map<std::string, PageFile, std::less<>> files_;
};

}  // namespace tandem::room
