# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# Target docs_site: the public headers as pages, <build>/docs/html. A warning fails it.
find_program(TANDEM_DOXYGEN doxygen)
mark_as_advanced(TANDEM_DOXYGEN)
if(NOT TANDEM_DOXYGEN)
  message(STATUS "tandem: no site of the headers (Debian: doxygen)")
  return()
endif()

# All modules, whether this build has them or not.
set(docs_include)
foreach(module IN ITEMS pbd collision collision/scene collision/obj consensus net/virtual_network net
                        net/session bindings/c)
  string(APPEND docs_include " \"${PROJECT_SOURCE_DIR}/${module}/include\"")
endforeach()
configure_file("${PROJECT_SOURCE_DIR}/docs/Doxyfile.in" "${PROJECT_BINARY_DIR}/docs/Doxyfile" @ONLY)
add_custom_target(docs_site
  COMMAND "${TANDEM_DOXYGEN}" "${PROJECT_BINARY_DIR}/docs/Doxyfile"
  COMMENT "The public headers as pages, in docs/html"
  VERBATIM)
