# Builds a page with Vite and embeds it in a library. Without Node or a package registry, the library is built without the page
# and contains the reason.
find_program(SWEEPSTAKE_NODE NAMES node nodejs)
find_program(SWEEPSTAKE_NPM NAMES npm)

# sweepstake_page(report report_page FILES...): builds the page `report` of the package in the current folder from its `FILES`.
# Writes the page into report_page.cc, and compiles that into the library sweepstake_report_page.
function(sweepstake_page page stem)
  set(node_program ${SWEEPSTAKE_NODE})
  if(SWEEPSTAKE_NODE)
    execute_process(COMMAND ${SWEEPSTAKE_NODE} --version OUTPUT_VARIABLE node_version ERROR_QUIET OUTPUT_STRIP_TRAILING_WHITESPACE)
    string(REGEX REPLACE "^v" "" node_version "${node_version}")
    if(node_version VERSION_LESS 18)
      set(node_program)
    endif()
  endif()
  if(NOT node_program OR NOT SWEEPSTAKE_NPM)
    message(STATUS "Left out: the page of the ${page}. Missing: Node.js 18 or newer, with npm")
  endif()

  set(script ${CMAKE_CURRENT_FUNCTION_LIST_DIR}/build_page.cmake)
  add_custom_command(
    OUTPUT ${CMAKE_CURRENT_BINARY_DIR}/${page}.stamp
    BYPRODUCTS ${CMAKE_CURRENT_BINARY_DIR}/${stem}.cc
    COMMAND ${CMAKE_COMMAND} -D PAGE=${page} -D STEM=${stem} -D SOURCE=${CMAKE_CURRENT_SOURCE_DIR} -D BUILD=${CMAKE_CURRENT_BINARY_DIR}
      -D NODE=${node_program} -D NPM=${SWEEPSTAKE_NPM} -D PROTOC=${PROTOC} -P ${script}
    DEPENDS ${ARGN} vite.config.js package.json package-lock.json ${script} ${stem}.cc.in
    COMMENT "Building the page: ${page}"
    VERBATIM)
  add_custom_target(sweepstake_${stem}_build DEPENDS ${CMAKE_CURRENT_BINARY_DIR}/${page}.stamp)
  add_library(sweepstake_${stem} STATIC ${CMAKE_CURRENT_BINARY_DIR}/${stem}.cc)
  add_dependencies(sweepstake_${stem} sweepstake_${stem}_build)
  target_include_directories(sweepstake_${stem} PUBLIC ${PROJECT_SOURCE_DIR})
  target_link_libraries(sweepstake_${stem} PRIVATE sweepstake_flags)
endfunction()
