# Builds a page and turns it into a source file. If that fails, the source file contains the reason instead of the page, and
# the build of the programs continues.
#
#   cmake -D PAGE=report|dashboard -D STEM=name -D SOURCE=folder -D BUILD=folder -D NODE=program -D NPM=program -D PROTOC=program
#         -P build_page.cmake
#
# SOURCE is the folder of the page's package. Writes BUILD/STEM.cc from SOURCE/STEM.cc.in. Also writes BUILD/PAGE.stamp, except
# after a failure that may not happen again, such as a missing network; without the stamp the next build tries again.

cmake_path(RELATIVE_PATH SOURCE BASE_DIRECTORY ${CMAKE_CURRENT_LIST_DIR}/../.. OUTPUT_VARIABLE folder)
set(modules ${SOURCE}/node_modules)
set(output ${BUILD}/${PAGE})
set(CONTENT)
set(PROBLEM)
set(is_final TRUE)
set(without "this program was built without the page")
if(PAGE STREQUAL dashboard)
  set(without "this program was built without the dashboard")
endif()

# npm writes this file last, so it is missing after an interrupted installation.
set(installed ${modules}/.package-lock.json)

# Installs the packages unless node_modules is newer than the lock file.
function(install_modules)
  if(EXISTS ${installed} AND ${installed} IS_NEWER_THAN ${SOURCE}/package-lock.json)
    return()
  endif()
  execute_process(
    COMMAND ${NPM} ci --ignore-scripts --no-audit --no-fund --prefer-offline --loglevel=error --fetch-retries=0 --fetch-timeout=20000
    WORKING_DIRECTORY ${SOURCE} OUTPUT_QUIET)
endfunction()

# Runs a Node script in SOURCE, unless an earlier step failed.
macro(run_node what)
  if(NOT PROBLEM)
    execute_process(COMMAND ${NODE} ${ARGN} WORKING_DIRECTORY ${SOURCE} RESULT_VARIABLE result)
    if(NOT result EQUAL 0)
      set(is_final FALSE)
      set(PROBLEM "${without}, because `${what}` failed in ${folder}: run it there, fix the error that it prints, and build again")
    endif()
  endif()
endmacro()

file(LOCK ${SOURCE} DIRECTORY RESULT_VARIABLE ignored)  # several build trees share node_modules and src/gen
if(NOT NODE OR NOT NPM)
  set(PROBLEM "${without}, because Node.js 18 or newer with npm is missing: install both (Debian: apt-get install nodejs npm) and build again")
else()
  install_modules()
  if(NOT EXISTS ${installed})
    set(is_final FALSE)
    set(PROBLEM "${without}, because `npm ci` failed in ${folder}: run it there with access to a package registry, and build again")
  endif()
  if(PAGE STREQUAL dashboard)
    run_node("npm run proto" proto.mjs ${PROTOC})
  endif()
  run_node("npm run build" ${modules}/vite/bin/vite.js build --outDir ${output} --emptyOutDir --logLevel warn)
  if(PAGE STREQUAL dashboard)
    run_node("node embed.mjs" embed.mjs ${output} ${BUILD}/${STEM}.inc)
    set(output ${BUILD}/${STEM}.inc)
  else()
    set(output ${output}/report.html)
  endif()
  if(NOT PROBLEM)
    file(READ ${output} CONTENT)
  endif()
endif()

if(PROBLEM)
  message("Left out: ${PROBLEM}")
endif()
configure_file(${SOURCE}/${STEM}.cc.in ${BUILD}/${STEM}.cc @ONLY)
if(is_final)
  file(TOUCH ${BUILD}/${PAGE}.stamp)
endif()
