# Installs the build into an empty prefix, then configures, builds and runs a project that sees only that prefix.
cmake_minimum_required(VERSION 3.25)

function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT result EQUAL 0)
    string(JOIN " " command ${ARGN})
    message(FATAL_ERROR "${command}\n${output}")
  endif()
endfunction()

function(expect_installed)
  foreach(pattern IN LISTS ARGN)
    file(GLOB_RECURSE found ${WORK}/prefix/${pattern})
    if(NOT found)
      message(FATAL_ERROR "not installed: ${pattern}")
    endif()
  endforeach()
endfunction()

file(REMOVE_RECURSE ${WORK})
run(${CMAKE_COMMAND} --install ${SWEEPSTAKE_BUILD} --prefix ${WORK}/prefix)
expect_installed(include/sweepstake/c_api.h include/sweepstake/broad_phase.h
  share/sweepstake/proto/sweepstake/v1/telemetry.proto sweepstakeConfig.cmake)
file(GLOB_RECURSE private_protocol ${WORK}/prefix/*costs.proto)
if(private_protocol)
  message(FATAL_ERROR "the command line's own protocol is installed: ${private_protocol}")
endif()
if(WITH_PROGRAMS)
  run(${WORK}/prefix/bin/sweepstake --version)
  run(${WORK}/prefix/bin/sweepstaked --help)
endif()

run(${CMAKE_COMMAND} -S ${CONSUMER_SOURCE} -B ${WORK}/build -G ${GENERATOR} -DCMAKE_PREFIX_PATH=${WORK}/prefix
  -DCMAKE_C_FLAGS=${C_FLAGS} -DCMAKE_CXX_FLAGS=${CXX_FLAGS} -DWITH_TELEMETRY=${WITH_TELEMETRY})
run(${CMAKE_COMMAND} --build ${WORK}/build)
run(${WORK}/build/cxx_consumer)
run(${WORK}/build/proxies_consumer)
run(${WORK}/build/c_consumer)
if(WITH_TELEMETRY)
  run(${WORK}/build/session_consumer)
endif()

run(${CMAKE_COMMAND} -S ${CONSUMER_SOURCE} -B ${WORK}/build_c -G ${GENERATOR} -DCMAKE_PREFIX_PATH=${WORK}/prefix
  -DCMAKE_C_FLAGS=${C_FLAGS} -DCMAKE_CXX_FLAGS=${CXX_FLAGS} -DONLY_C=ON -DCMAKE_DISABLE_FIND_PACKAGE_hwy=ON)
run(${CMAKE_COMMAND} --build ${WORK}/build_c)
run(${WORK}/build_c/c_consumer)
