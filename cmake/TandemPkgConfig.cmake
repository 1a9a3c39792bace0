# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors

# tandem_pkg_config(<name> DESCRIPTION <text> [REQUIRES <package>...] [PRIVATE <package>...]
#                   [LIBS <flag>...] [CFLAGS <flag>...])
#
# tandem-<name>.pc beside the library. PRIVATE packages and LIBS are those of the library's insides:
# of shared ones there is no word, as pkg-config would want to have private packages too. Paths are relative to the file, so that the tree may be
# moved.
function(tandem_pkg_config name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "DESCRIPTION" "REQUIRES;PRIVATE;LIBS;CFLAGS")
  set(libs "-L\${libdir}" -ltandem_${name})
  list(PREPEND arg_CFLAGS "-I\${includedir}")
  if(NOT BUILD_SHARED_LIBS)
    list(APPEND arg_REQUIRES ${arg_PRIVATE})
    list(APPEND libs ${arg_LIBS} -lstdc++ -lm)
  endif()
  list(JOIN arg_REQUIRES ", " requires)
  list(JOIN libs " " libs)
  list(JOIN arg_CFLAGS " " cflags)
  set(folder "${CMAKE_INSTALL_LIBDIR}/pkgconfig")
  # Back from the folder of the file, whatever the depth of the library's.
  file(RELATIVE_PATH up "/${folder}" "/")
  file(CONFIGURE OUTPUT "${CMAKE_CURRENT_BINARY_DIR}/tandem-${name}.pc" @ONLY CONTENT
"prefix=\${pcfiledir}/${up}
libdir=\${prefix}/${CMAKE_INSTALL_LIBDIR}
includedir=\${prefix}/${CMAKE_INSTALL_INCLUDEDIR}

Name: tandem-${name}
Description: ${arg_DESCRIPTION}
Version: ${PROJECT_VERSION}
Requires: ${requires}
Libs: ${libs}
Cflags: ${cflags}
")
  install(FILES "${CMAKE_CURRENT_BINARY_DIR}/tandem-${name}.pc" DESTINATION "${folder}" COMPONENT dev)
endfunction()
