# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# The programs and tools, for packages: `cmake --install BUILD --component demos`. Not with the libraries. The
# demos' names are those of everyday things, so they lie in a folder of their own, and tandem-demo
# runs them.
if(NOT TARGET cubes)
  return()
endif()

function(_install_programs destination)
  set(programs)
  foreach(program IN LISTS ARGN)
    if(TARGET ${program})
      list(APPEND programs ${program})
      if(BUILD_SHARED_LIBS)
        file(RELATIVE_PATH libraries "/${destination}" "/${CMAKE_INSTALL_LIBDIR}")
        set_target_properties(${program} PROPERTIES INSTALL_RPATH "$ORIGIN/${libraries}")
      endif()
    endif()
  endforeach()
  install(TARGETS ${programs} RUNTIME DESTINATION "${destination}" COMPONENT demos EXCLUDE_FROM_ALL)
endfunction()

# What of other projects is in the programs.
install(FILES "${CMAKE_CURRENT_LIST_DIR}/NOTICES.txt"
        DESTINATION "${CMAKE_INSTALL_DATAROOTDIR}/doc/tandem-demos"
        COMPONENT demos EXCLUDE_FROM_ALL)

set(folder "${CMAKE_INSTALL_LIBEXECDIR}/tandem/demos")
_install_programs("${folder}" cliff cubes piano pile plaza room tennis)
_install_programs("${CMAKE_INSTALL_BINDIR}" tandem-peer tandem-key tandem-replay)
file(RELATIVE_PATH up "/${CMAKE_INSTALL_BINDIR}" "/${folder}")
configure_file("${CMAKE_CURRENT_LIST_DIR}/tandem-demo.in" "${CMAKE_CURRENT_BINARY_DIR}/tandem-demo"
               @ONLY)
install(PROGRAMS "${CMAKE_CURRENT_BINARY_DIR}/tandem-demo" DESTINATION "${CMAKE_INSTALL_BINDIR}"
        COMPONENT demos EXCLUDE_FROM_ALL)
