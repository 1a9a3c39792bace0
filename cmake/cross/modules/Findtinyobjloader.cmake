# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# The header in double precision, compiled here: Debian has the library for the machine's own processor.
file(CONFIGURE OUTPUT "${PROJECT_BINARY_DIR}/tinyobjloader.cpp" @ONLY CONTENT
  "#define TINYOBJLOADER_IMPLEMENTATION\n#include <tiny_obj_loader.h>\n")
add_library(tandem_cross_tinyobjloader STATIC "${PROJECT_BINARY_DIR}/tinyobjloader.cpp")
target_include_directories(tandem_cross_tinyobjloader SYSTEM PUBLIC
  "$<BUILD_INTERFACE:${TANDEM_SYSROOT}/include>")
target_compile_definitions(tandem_cross_tinyobjloader PUBLIC TINYOBJLOADER_USE_DOUBLE)
target_compile_options(tandem_cross_tinyobjloader PRIVATE -w)
set_target_properties(tandem_cross_tinyobjloader PROPERTIES UNITY_BUILD OFF
  POSITION_INDEPENDENT_CODE ON EXPORT_NAME tinyobjloader OUTPUT_NAME tandem_tinyobjloader)
add_library(tinyobjloader::tinyobjloader_double INTERFACE IMPORTED GLOBAL)
set_target_properties(tinyobjloader::tinyobjloader_double PROPERTIES TANDEM_BUNDLED tandem_cross_tinyobjloader)
target_link_libraries(tinyobjloader::tinyobjloader_double INTERFACE tandem_cross_tinyobjloader)
set(tinyobjloader_FOUND ON)
