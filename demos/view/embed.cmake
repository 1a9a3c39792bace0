# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# cmake -DOUTPUT=FILE.cpp "-DFILES=FILE;FILE.." -P embed.cmake
#
# Writes page_assets() of view/assets.h: the files' bytes as string literals, which compilers read
# many times faster than lists of numbers.
set(mime_html "text/html; charset=utf-8")
set(mime_js "text/javascript; charset=utf-8")
set(mime_css "text/css; charset=utf-8")
set(mime_svg "image/svg+xml")

set(literals)
set(table)
set(count 0)
foreach(file IN LISTS FILES)
  get_filename_component(path "${file}" NAME)
  get_filename_component(extension "${file}" LAST_EXT)
  string(SUBSTRING "${extension}" 1 -1 extension)
  if(NOT DEFINED mime_${extension})
    message(FATAL_ERROR "embed: ${file}: no type is known for .${extension}")
  endif()
  if(path STREQUAL "index.html")
    set(path "")
  endif()
  file(READ "${file}" hex HEX)
  string(REGEX REPLACE "(..)" "\\\\x\\1" bytes "${hex}")
  string(APPEND literals "constexpr char kBytes${count}[] =\n    \"${bytes}\";\n")
  string(APPEND table "    {\"${path}\", \"${mime_${extension}}\", {kBytes${count}, sizeof(kBytes${count}) - 1}},\n")
  math(EXPR count "${count} + 1")
endforeach()

file(WRITE "${OUTPUT}.new" "// Made by demos/view/embed.cmake.
#include <array>

#include \"view/assets.h\"

#pragma GCC diagnostic ignored \"-Woverlength-strings\"

namespace tandem::demos::view {

namespace {

${literals}
constexpr std::array<Asset, ${count}> kAssets = {{
${table}}};

}  // namespace

std::span<const Asset> page_assets() { return kAssets; }

}  // namespace tandem::demos::view
")
file(RENAME "${OUTPUT}.new" "${OUTPUT}")
