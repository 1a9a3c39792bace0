// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cctype>
#include <string>
#include <string_view>

#include "tandem/pbd/validate.h"
#include "tandem/scene_files.h"

namespace tandem::scene_files {

/// An XML tag, as read by parsers that are more lenient than the standard.
struct XmlTag {
  std::string_view text;  ///< without the brackets
  bool opens = false;     ///< opens an element, which may be closed at once
  bool closes = false;
};

/// Visits the tags of a text in order. Comments and CDATA are no tags; what begins with ? or ! ends
/// at the next bracket, and a quote only begins after an equals sign: so no parser sees more tags
/// than this does.
/// @return false if a tag has no end, or a value contains a bracket, which is no XML
bool for_tags(std::string_view text, auto&& visit) {
  constexpr std::string_view kSpaces = " \t\r\n";
  for (std::size_t i = text.find('<'); i != text.npos; i = text.find('<', i)) {
    const std::string_view rest = text.substr(i);
    const std::string_view end = rest.starts_with("<!--")        ? "-->"
                                 : rest.starts_with("<![CDATA[") ? "]]>"
                                                                 : "";
    if (!end.empty()) {
      const std::size_t at = rest.find(end);
      if (at == rest.npos) return false;
      i += at + end.size();
      continue;
    }
    char quote = 0;
    char before = 0;  // the last non-space
    std::size_t k = 1;
    for (; k < rest.size() && (quote != 0 || rest[k] != '>'); ++k) {
      const char c = rest[k];
      if (c == '<') return false;
      if (quote != 0) {
        if (c == quote) quote = 0;
      } else if ((c == '"' || c == '\'') && before == '=') {
        quote = c;
      }
      if (kSpaces.find(c) == kSpaces.npos) before = c;
    }
    if (k == rest.size()) return false;
    const char first = rest[1];
    const bool element = first != '/' && first != '!' && first != '?';
    visit(XmlTag{rest.substr(1, k - 1), element, first == '/' || (element && rest[k - 1] == '/')});
    i += k + 1;
  }
  return true;
}

/// Whether the tag has an attribute whose name begins with `name`.
inline bool has_attribute(const XmlTag& tag, std::string_view name) {
  char quote = 0;
  char before = 0;  // the last non-space
  bool spaced = false;
  std::string word;
  for (const char c : tag.text) {
    const bool space = std::isspace(static_cast<unsigned char>(c)) != 0;
    if (quote != 0) {
      if (c == quote) quote = 0;
    } else if ((c == '"' || c == '\'') && before == '=') {
      quote = c;
      word.clear();
    } else if (c == '=') {
      if (word.starts_with(name)) return true;
    } else if (!space) {
      if (spaced) word.clear();
      word += c;
    }
    spaced = space;
    if (!space) before = c;
  }
  return false;
}

/// Bounds for recursive parsers that store all elements.
inline void check_xml(std::string_view text, std::string_view name) {
  constexpr std::size_t kMaxElements = 200'000;
  std::size_t open = 0;
  std::size_t elements = 0;
  const auto check = [name](const char* what, std::size_t value, std::size_t most) {
    if (value <= most) return;
    throw SceneFileError(pbd::detail::must_be(
        std::string(name) + ": " + what, "at most " + std::to_string(most), std::to_string(value)));
  };
  check("size", text.size(), kMaxSceneBytes);
  const bool sound = for_tags(text, [&](const XmlTag& tag) {
    if (tag.opens) check("number of elements", ++elements, kMaxElements);
    if (tag.opens) check("depth", ++open, 200);
    if (tag.closes && open > 0) --open;
  });
  if (!sound) {
    throw SceneFileError(pbd::detail::must_be(std::string(name) + ": text",
                                              "XML, with an end to each tag, quote and comment"));
  }
}

/// Refuses a text that names files: a text has no files beside it, and the parser would look for
/// them on the disk.
inline void refuse_files(std::string_view text, std::string_view name) {
  (void)for_tags(text, [&](const XmlTag& tag) {
    if (!tag.opens) return;
    if (tag.text.starts_with("include") || tag.text.starts_with("plugin") ||
        has_attribute(tag, "file")) {
      throw SceneFileError(pbd::detail::must_be(
          std::string(name) + ": <" + std::string(tag.text.substr(0, 40)) + ">",
          "without a file: a text has none beside it"));
    }
  });
}

}  // namespace tandem::scene_files
