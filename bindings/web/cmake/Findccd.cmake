# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# libccd from TANDEM_WEB_SOURCES (bindings/web/fetch-sources.sh), in double precision as Debian has it.
set(_ccd "${TANDEM_WEB_SOURCES}/libccd/src")
if(NOT EXISTS "${_ccd}/ccd.c")
  message(FATAL_ERROR "there are no sources in ${TANDEM_WEB_SOURCES}: bindings/web/fetch-sources.sh brings them")
endif()
file(MAKE_DIRECTORY "${PROJECT_BINARY_DIR}/include/ccd")
file(CONFIGURE OUTPUT "${PROJECT_BINARY_DIR}/include/ccd/config.h" CONTENT "#define CCD_DOUBLE\n")
add_library(tandem_web_ccd STATIC
  "${_ccd}/ccd.c" "${_ccd}/mpr.c" "${_ccd}/polytope.c" "${_ccd}/support.c" "${_ccd}/vec3.c")
target_include_directories(tandem_web_ccd SYSTEM PUBLIC "$<BUILD_INTERFACE:${PROJECT_BINARY_DIR}/include;${_ccd}>")
target_compile_options(tandem_web_ccd PRIVATE -ffp-contract=off -w)
set_target_properties(tandem_web_ccd PROPERTIES EXPORT_NAME ccd OUTPUT_NAME tandem_ccd)
if(NOT EMSCRIPTEN)  # it may end up in a shared library
  set_target_properties(tandem_web_ccd PROPERTIES POSITION_INDEPENDENT_CODE ON)
endif()
add_library(ccd INTERFACE IMPORTED GLOBAL)
set_target_properties(ccd PROPERTIES TANDEM_BUNDLED tandem_web_ccd)
target_link_libraries(ccd INTERFACE tandem_web_ccd)
set(ccd_FOUND ON)
