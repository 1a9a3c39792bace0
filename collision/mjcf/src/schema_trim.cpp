// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "schema_trim.h"

#include <algorithm>
#include <charconv>

#include "read_bytes.h"
#include "xml_check.h"

namespace tandem::mjcf {
namespace {

constexpr std::string_view kBlanks = " \t\r\n";

/// The quoted text after `before`.
std::string quoted(std::string_view message, std::string_view before) {
  const std::size_t at = message.find(before);
  if (at == message.npos) return {};
  const std::string_view rest = message.substr(at + before.size());
  return std::string(rest.substr(0, rest.find('\'')));
}

std::string_view element_of(std::string_view tag) {
  return tag.substr(0, tag.find_first_of(" \t\r\n/"));
}

struct Range {
  std::size_t begin, end;
};

/// Position of the attribute in a tag, with its value; empty if it has none.
Range attribute_range(std::string_view tag, std::string_view name) {
  std::size_t i = element_of(tag).size();
  while (i < tag.size()) {
    const std::size_t begin = tag.find_first_not_of(kBlanks, i);
    if (begin == tag.npos) break;
    const std::size_t equals = tag.find('=', begin);
    if (equals == tag.npos) break;
    const std::string_view key = tag.substr(begin, equals - begin);
    const std::size_t open = tag.find_first_not_of(kBlanks, equals + 1);
    if (open == tag.npos || (tag[open] != '"' && tag[open] != '\'')) break;
    const std::size_t close = tag.find(tag[open], open + 1);
    if (close == tag.npos) break;
    if (key.substr(0, key.find_last_not_of(kBlanks) + 1) == name) return {begin, close + 1};
    i = close + 1;
  }
  return {0, 0};
}

void blank(std::string& text, const Range& range) {
  for (std::size_t i = range.begin; i < range.end; ++i) {
    if (text[i] != '\n') text[i] = ' ';
  }
}

std::vector<Range> find(const SchemaViolation& what, std::string_view text) {
  std::vector<Range> out;
  std::size_t depth = 0;  // within the removed element, counting itself
  std::size_t begin = 0;
  (void)scene_files::for_tags(text, [&](const scene_files::XmlTag& tag) {
    const auto at = static_cast<std::size_t>(tag.text.data() - text.data());
    if (depth > 0) {
      depth += tag.opens ? 1 : 0;
      depth -= tag.closes ? 1 : 0;
    } else if (tag.opens && element_of(tag.text) == what.element) {
      if (!what.value.empty()) {
        for (const char* name : {"integrator", "cone", "jacobian", "solver"}) {
          const Range range = attribute_range(tag.text, name);
          const bool found =
              tag.text.substr(range.begin, range.end - range.begin).find(what.value) !=
              std::string_view::npos;
          if (found) out.push_back({at + range.begin, at + range.end});
        }
        return;
      }
      if (!what.attribute.empty()) {
        const Range range = attribute_range(tag.text, what.attribute);
        if (range.end > range.begin) out.push_back({at + range.begin, at + range.end});
        return;
      }
      const auto line =
          1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n');
      if (static_cast<std::size_t>(line) != what.line) return;
      begin = at - 1;
      depth = tag.closes ? 0 : 1;
      if (tag.closes) out.push_back({begin, at + tag.text.size() + 1});
      return;
    } else {
      return;
    }
    if (depth == 0) out.push_back({begin, at + tag.text.size() + 1});
  });
  return out;
}

std::size_t number_after(std::string_view message, std::string_view before) {
  std::size_t out = 0;
  const std::size_t at = message.find(before);
  if (at == message.npos) return out;
  const std::string_view number = message.substr(at + before.size());
  std::from_chars(number.data(), number.data() + number.size(), out);
  return out;
}

}  // namespace

std::optional<SchemaViolation> schema_violation(std::string_view message) {
  // How later versions integrate, solve and light is of no concern here.
  if (message.find(" in light '") != message.npos) {
    return SchemaViolation{.element = "light", .line = number_after(message, ", line = ")};
  }
  if (message.find("invalid keyword: '") != message.npos &&
      quoted(message, "Element '") == "option") {
    return SchemaViolation{.element = "option", .value = quoted(message, "invalid keyword: '")};
  }
  SchemaViolation out{.element = quoted(message, "Element '"),
                      .attribute = quoted(message, "unrecognized attribute: '")};
  const bool known = !out.attribute.empty() || message.find("unrecognized element") != message.npos;
  if (!known || out.element.empty()) return {};
  out.line = number_after(message, ", line ");
  return out;
}

std::size_t blank_out(const SchemaViolation& what, std::vector<Document>& documents) {
  std::size_t count = 0;
  for (Document& document : documents) {
    const std::vector<Range> ranges = find(what, document.text);
    for (const Range& range : ranges) blank(document.text, range);
    document.changed = document.changed || !ranges.empty();
    count += ranges.size();
    // Line numbers are the model's.
    if (what.attribute.empty() && what.value.empty()) break;
  }
  return count;
}

bool set_autolimits(Document& model) {
  std::size_t end = 0;  // of the root's tag
  (void)scene_files::for_tags(model.text, [&](const scene_files::XmlTag& tag) {
    if (end != 0 || !tag.opens || tag.closes || element_of(tag.text) != "mujoco") return;
    end = static_cast<std::size_t>(tag.text.data() - model.text.data()) + tag.text.size() + 1;
  });
  if (end == 0) return false;
  // On the same line, so that line numbers in messages stay.
  model.text.insert(end, "<compiler autolimits=\"true\"/>");
  model.changed = true;
  return true;
}

void append_includes(const std::filesystem::path& folder, std::vector<Document>& documents) {
  constexpr std::size_t kMaxDocuments = 256;
  for (std::size_t i = 0; i < documents.size() && documents.size() < kMaxDocuments; ++i) {
    std::vector<std::string> files;
    const std::string_view text = documents[i].text;
    (void)scene_files::for_tags(text, [&](const scene_files::XmlTag& tag) {
      if (!tag.opens || element_of(tag.text) != "include") return;
      const Range at = attribute_range(tag.text, "file");
      if (at.end == at.begin) return;
      const std::string_view value = tag.text.substr(at.begin, at.end - 1 - at.begin);
      files.emplace_back(value.substr(value.find_first_of("\"'") + 1));
    });
    for (const std::string& file : files) {
      const std::string base = std::filesystem::path(file).filename().string();
      // MuJoCo knows texts in memory by these names only.
      const bool known =
          std::any_of(documents.begin(), documents.end(),
                      [&](const Document& document) { return document.file == base; });
      if (known) continue;
      try {
        std::string read = scene_files::read_bytes(folder / file);
        scene_files::check_xml(read, file);
        documents.push_back({base, std::move(read)});
      } catch (const SceneFileError&) {
        continue;
      }
    }
  }
}

}  // namespace tandem::mjcf
