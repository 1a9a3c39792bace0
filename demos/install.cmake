# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# The programs and tools, which are installed with the libraries. The demos' names are those of everyday things, so they
# lie in a folder of their own, and tandem-demo runs them.
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
  # The demos that have been built.
  install(TARGETS ${programs} RUNTIME DESTINATION "${destination}" COMPONENT demos OPTIONAL)
endfunction()

# Parts of other projects in the programs.
install(FILES "${CMAKE_CURRENT_LIST_DIR}/NOTICES.txt"
        DESTINATION "${CMAKE_INSTALL_DATAROOTDIR}/doc/tandem-demos" COMPONENT demos)

set(folder "${CMAKE_INSTALL_LIBEXECDIR}/tandem/demos")
if(WIN32 AND BUILD_SHARED_LIBS)
  # Where Windows finds the DLLs.
  set(folder "${CMAKE_INSTALL_BINDIR}")
elseif(WIN32)
  set(folder demos)
endif()
_install_programs("${folder}" cliff cubes piano pile plaza room tennis)
_install_programs("${CMAKE_INSTALL_BINDIR}" tandem-peer tandem-key tandem-replay tandem-room tandem-room-peer)
if(NOT WIN32)
  file(RELATIVE_PATH up "/${CMAKE_INSTALL_BINDIR}" "/${folder}")
  configure_file("${CMAKE_CURRENT_LIST_DIR}/tandem-demo.in" "${CMAKE_CURRENT_BINARY_DIR}/tandem-demo"
                 @ONLY)
  install(PROGRAMS "${CMAKE_CURRENT_BINARY_DIR}/tandem-demo" DESTINATION "${CMAKE_INSTALL_BINDIR}"
          COMPONENT demos)
endif()

# The page that tandem-room serves, where it has been built or unpacked.
if(TARGET tandem-room)
  set(TANDEM_ROOM_PAGE "${PROJECT_SOURCE_DIR}/build/web/room" CACHE PATH
      "Folder of the rooms' page, installed where it is there when installing")
  install(DIRECTORY "${TANDEM_ROOM_PAGE}/" DESTINATION "${CMAKE_INSTALL_DATADIR}/tandem/room"
          COMPONENT demos OPTIONAL FILES_MATCHING PATTERN "*.gz")
endif()
