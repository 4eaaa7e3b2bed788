# Builds the page and turns it into a source file. Where that is not possible the source holds an
# empty page and the reason, and the programs are built all the same.
#
#   cmake -D SOURCE=folder -D BUILD=folder -D NODE=program -D NPM=program -P build_page.cmake
#
# Writes BUILD/report_page.cc, and BUILD/report_page.stamp unless another build may fare better.

file(LOCK ${SOURCE} DIRECTORY) # several build trees share node_modules
set(modules ${SOURCE}/node_modules)
set(PAGE)
set(PROBLEM)
set(is_final TRUE)

# node_modules stays as it is while the lock file is the one that it was installed from.
function(install_modules)
  file(SHA256 ${SOURCE}/package-lock.json wanted)
  set(found ${wanted})
  if(EXISTS ${modules}/.sweepstake-lock)
    file(READ ${modules}/.sweepstake-lock found)
  endif()
  if(EXISTS ${modules}/vite/bin/vite.js AND found STREQUAL wanted)
    return()
  endif()
  execute_process(
    COMMAND ${NPM} ci --ignore-scripts --no-audit --no-fund --prefer-offline --loglevel=error --fetch-retries=0 --fetch-timeout=20000
    WORKING_DIRECTORY ${SOURCE} RESULT_VARIABLE result OUTPUT_QUIET)
  if(result EQUAL 0)
    file(WRITE ${modules}/.sweepstake-lock ${wanted})
  endif()
endfunction()

if(NOT NODE OR NOT NPM)
  set(PROBLEM "this program was built without the page, for want of Node.js 18 or newer with npm: install them (Debian: apt-get install nodejs npm) and build again")
else()
  install_modules()
  if(NOT EXISTS ${modules}/vite/bin/vite.js)
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
