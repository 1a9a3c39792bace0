// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "gltf_buffers.h"

#include <algorithm>
#include <charconv>
#include <cstring>

#include "read_bytes.h"

namespace tandem::scene_files {
namespace {

std::string decode_base64(std::string_view text, const Place& at) {
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  while (!text.empty() && text.back() == '=') text.remove_suffix(1);
  std::string out;
  out.reserve(text.size() / 4 * 3 + 2);
  std::uint32_t held = 0;
  int bits = 0;
  for (const char c : text) {
    const std::size_t digit = kDigits.find(c);
    if (digit == std::string_view::npos) at.refuse("base64 behind \"base64,\"");
    held = (held << 6 | static_cast<std::uint32_t>(digit)) & 0xffffu;
    bits += 6;
    if (bits < 8) continue;
    bits -= 8;
    out += static_cast<char>(held >> bits & 0xffu);
  }
  return out;
}

/// Decodes a URI: %20 is a space.
std::string decode_percent(const Place& uri) {
  std::string text = uri.text();
  std::size_t size = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    char c = text[i];
    if (c == '%') {
      const char* const digits = text.data() + i + 1;
      const char* const end = digits + std::min<std::size_t>(2, text.size() - i - 1);
      unsigned char byte = 0;
      const std::from_chars_result read = std::from_chars(digits, end, byte, 16);
      if (read.ec != std::errc() || read.ptr != digits + 2 || byte == 0) {
        uri.refuse("of two hexadecimal digits behind each %, and without %00");
      }
      c = static_cast<char>(byte);
      i += 2;
    }
    text[size++] = c;
  }
  text.resize(size);
  return text;
}

template <class Number>
double load(const char* from) {
  Number value;
  std::memcpy(&value, from, sizeof value);
  return static_cast<double>(value);
}

/// Bytes of a component, or 0 for an unknown type.
std::size_t component_size(std::int64_t type) {
  if (type == 5120 || type == 5121) return 1;
  if (type == 5122 || type == 5123) return 2;
  return type == 5125 || type == 5126 ? 4 : 0;
}

std::size_t whole(const Place& at, const char* key) {
  if (!at.has(key)) return 0;
  return static_cast<std::size_t>(at.at(key).integer(0, static_cast<std::int64_t>(kMaxSceneBytes)));
}

}  // namespace

double GltfAccessor::at(std::size_t element, std::size_t component) const {
  const char* from = data + element * stride + component * component_size(type);
  switch (type) {
    case 5120:
      return load<std::int8_t>(from);
    case 5121:
      return load<std::uint8_t>(from);
    case 5122:
      return load<std::int16_t>(from);
    case 5123:
      return load<std::uint16_t>(from);
    case 5125:
      return load<std::uint32_t>(from);
    default:
      return load<float>(from);
  }
}

GltfBuffers::Bytes GltfBuffers::file(const Place& uri, const std::string& name) {
  const std::filesystem::path path(name);
  bool inside = path.is_relative() && name.find(':') == std::string::npos;
  for (const auto& part : path) inside = inside && part != "..";
  if (!inside) uri.refuse("the name of a file in the document's folder or below");
  Bytes& known = files_[path.lexically_normal()];
  if (known == nullptr)
    known = std::make_shared<const std::string>(read_bytes(sources_.folder / path));
  return known;
}

const std::string& GltfBuffers::bytes(const Place& index) {
  const Place list = document_.at("buffers");
  const Place buffer = list.pick(index);
  Bytes& known = buffers_[index.value().get<std::int64_t>()];
  if (known != nullptr) return *known;
  const bool first = index.value().get<std::int64_t>() == 0;
  if (first && !sources_.binary.empty() && !buffer.has("uri")) {
    known = std::make_shared<const std::string>(sources_.binary);
    return *known;
  }
  const Place uri = buffer.at("uri");
  const std::string text = decode_percent(uri);
  if (text.rfind("data:", 0) == 0) {
    const std::size_t start = text.find(";base64,");
    if (start == std::string::npos) uri.refuse("a file's name, or data in base64");
    known = std::make_shared<const std::string>(
        decode_base64(std::string_view(text).substr(start + 8), uri));
  } else {
    known = file(uri, text);
  }
  return *known;
}

GltfAccessor GltfBuffers::accessor(const Place& index, const char* type, std::size_t width) {
  const Place accessors = document_.at("accessors");
  const Place accessor = accessors.pick(index);
  if (accessor.at("type").text() != type) accessor.at("type").refuse('"' + std::string(type) + '"');
  if (accessor.has("sparse")) accessor.at("sparse").refuse("absent: sparse accessors are not read");
  const std::int64_t kind = accessor.at("componentType").integer(5120, 5126);
  const std::size_t size = component_size(kind);
  if (size == 0) accessor.at("componentType").refuse("one of glTF's");
  const Place views = document_.at("bufferViews");
  const Place view_index = accessor.at("bufferView");
  const Place view = views.pick(view_index);
  const std::string& data = bytes(view.at("buffer"));
  const std::size_t start = whole(view, "byteOffset");
  const std::size_t length = whole(view, "byteLength");
  const std::size_t offset = whole(accessor, "byteOffset");
  const std::size_t count = whole(accessor, "count");
  const std::size_t packed = size * width;
  const std::size_t stride = view.has("byteStride") ? whole(view, "byteStride") : packed;
  if (start + length > data.size()) view.refuse("within its buffer");
  if (count == 0 || stride < packed || offset + (count - 1) * stride + packed > length) {
    accessor.refuse("of at least one element, and within its view");
  }
  return {data.data() + start + offset, count, stride, kind};
}

}  // namespace tandem::scene_files
