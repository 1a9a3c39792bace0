// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>

#include "gltf_container.h"
#include "place.h"

namespace tandem::scene_files {

/// The numbers of a glTF accessor, in place in their buffer.
struct GltfAccessor {
  const char* data = nullptr;  ///< first element; valid as long as the GltfBuffers
  std::size_t count = 0;       ///< elements
  std::size_t stride = 0;      ///< bytes between elements
  std::int64_t type = 0;       ///< glTF's number of the component type

  double at(std::size_t element, std::size_t component) const;
};

/// Buffers of a glTF document, read on demand, each file once.
class GltfBuffers {
 public:
  /// @param sources  must outlive this
  GltfBuffers(const Place& document, const GltfSources& sources)
      : document_(document), sources_(sources) {}

  /// @param type  required type of elements      @param width  components of each
  GltfAccessor accessor(const Place& index, const char* type, std::size_t width);

 private:
  using Bytes = std::shared_ptr<const std::string>;

  const std::string& bytes(const Place& index);
  Bytes file(const Place& uri, const std::string& name);

  const Place& document_;
  const GltfSources& sources_;
  std::map<std::int64_t, Bytes> buffers_;
  std::map<std::filesystem::path, Bytes> files_;  ///< by path in the folder
};

}  // namespace tandem::scene_files
