# Builds the page and turns it into a source file. Where that is not possible the source holds an
# empty page and the reason, and the programs are built all the same.
#
#   cmake -D SOURCE=folder -D BUILD=folder -D NODE=program -D NPM=program -P build_page.cmake
#
# Writes BUILD/report_page.cc, and BUILD/report_page.stamp unless another build may fare better.

set(modules ${SOURCE}/node_modules)
set(PAGE)
set(PROBLEM)
set(is_final TRUE)

# npm writes its own record into node_modules last, so that an installation which was interrupted has none.
set(installed ${modules}/.package-lock.json)

# node_modules stays as it is while it is newer than the lock file.
function(install_modules)
  file(LOCK ${SOURCE} DIRECTORY RESULT_VARIABLE ignored)  # several build trees share node_modules
  if(EXISTS ${installed} AND ${installed} IS_NEWER_THAN ${SOURCE}/package-lock.json)
    return()
  endif()
  execute_process(
    COMMAND ${NPM} ci --ignore-scripts --no-audit --no-fund --prefer-offline --loglevel=error --fetch-retries=0 --fetch-timeout=20000
    WORKING_DIRECTORY ${SOURCE} OUTPUT_QUIET)
endfunction()

if(NOT NODE OR NOT NPM)
  set(PROBLEM "this program was built without the page, for want of Node.js 18 or newer with npm: install them (Debian: apt-get install nodejs npm) and build again")
else()
  install_modules()
  if(NOT EXISTS ${installed})
    set(is_final FALSE)
    set(PROBLEM "this program was built without the page, because `npm ci` failed in server/dashboard: run it there with access to a package registry, and build again")
  else()
    execute_process(
      COMMAND ${NODE} ${modules}/vite/bin/vite.js build --outDir ${BUILD}/page --emptyOutDir --logLevel warn
      WORKING_DIRECTORY ${SOURCE} RESULT_VARIABLE result)
    if(result EQUAL 0)
      file(READ ${BUILD}/page/report.html PAGE)
    else()
      set(is_final FALSE)
      set(PROBLEM "this program was built without the page, because `npm run build` failed in server/dashboard: see what it says there, and build again")
    endif()
  endif()
endif()

if(PROBLEM)
  message("Report page left out: ${PROBLEM}")
endif()
configure_file(${SOURCE}/report_page.cc.in ${BUILD}/report_page.cc @ONLY)
if(is_final)
  file(TOUCH ${BUILD}/report_page.stamp)
endif()
