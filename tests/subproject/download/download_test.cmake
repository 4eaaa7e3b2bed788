# Included by subproject_test.cmake: the download of a package, from an archive on this machine. A wrong file is downloaded again, and is
# never kept.
set(sample ${WORK}/sample-1.0)
file(WRITE ${sample}/include/sample.h "int Sample(void);\n")
file(WRITE ${sample}/sample.c "#include <sample.h>\nint Sample(void) { return 0; }\n")
run(${CMAKE_COMMAND} -E chdir ${WORK} ${CMAKE_COMMAND} -E tar czf sample.tar.gz sample-1.0)
file(SHA256 ${WORK}/sample.tar.gz hash)
set(download ${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR} -B ${WORK}/download -G ${GENERATOR} -DSWEEPSTAKE_SOURCE=${SWEEPSTAKE_SOURCE}
  -DSAMPLE_SHA256=${hash})
set(archive ${WORK}/download/downloads/sample.tar)

# expect_no_sample(REASON options...): the configuration fails with the error that says what to install, and keeps no file.
function(expect_no_sample reason)
  execute_process(COMMAND ${download} ${ARGN} RESULT_VARIABLE result OUTPUT_QUIET ERROR_VARIABLE output)
  string(REGEX REPLACE "[ \n]+" " " output "${output}")
  if(result EQUAL 0 OR NOT output MATCHES "Sample is neither installed nor.*${reason}.*libsample-dev.*FETCHCONTENT_SOURCE_DIR_SAMPLE")
    message(FATAL_ERROR "Without the package Sample the error does not say what to install: ${output}")
  endif()
  if(EXISTS ${archive})
    message(FATAL_ERROR "A wrong file was kept: ${archive}")
  endif()
endfunction()

file(WRITE ${WORK}/page.html "<html>Log in first</html>")
expect_no_sample("page.html is [0-9a-f]+ instead of ${hash}" -DSAMPLE_URL=file://${WORK}/page.html)
expect_no_sample("Couldn.t read" -DSAMPLE_URL=file://${WORK}/absent.tar.gz)
file(WRITE ${archive} "the begin of an arch")
expect_no_sample("FETCHCONTENT_FULLY_DISCONNECTED is on" -DFETCHCONTENT_FULLY_DISCONNECTED=ON)

file(WRITE ${archive} "the begin of an arch")
run(${download} -DFETCHCONTENT_FULLY_DISCONNECTED=OFF -DSAMPLE_URL=file://${WORK}/sample.tar.gz)
run(${CMAKE_COMMAND} --build ${WORK}/download)
run(${WORK}/download/program)
file(REMOVE ${WORK}/sample.tar.gz)
run(${download})  # with the downloaded file
