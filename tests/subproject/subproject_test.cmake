# As a folder of another project, Sweepstake must not add tests, a launcher, warnings as errors, settings of the whole build, or a
# daemon. Variables: SWEEPSTAKE_SOURCE, WORK (emptied first), GENERATOR, WITH_TELEMETRY (gRPC is installed).
cmake_minimum_required(VERSION 3.25)

file(REMOVE_RECURSE ${WORK})
execute_process(
  COMMAND ${CMAKE_COMMAND} -E env --unset=CMAKE_CXX_COMPILER_LAUNCHER --unset=CMAKE_C_COMPILER_LAUNCHER
    --unset=CMAKE_BUILD_TYPE --unset=CXXFLAGS
    ${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR} -B ${WORK} -G ${GENERATOR} -DSWEEPSTAKE_SOURCE=${SWEEPSTAKE_SOURCE}
    -DCMAKE_EXPORT_COMPILE_COMMANDS=ON
  RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
if(NOT result EQUAL 0)
  message(FATAL_ERROR "${output}")
endif()

file(READ ${WORK}/compile_commands.json commands)
if(NOT commands MATCHES "sweepstake_broad_phase\\.dir")
  message(FATAL_ERROR "The broad phases are not part of the build that added Sweepstake")
endif()
if(WITH_TELEMETRY AND NOT commands MATCHES "sweepstake_telemetry\\.dir")
  message(FATAL_ERROR "The session with a daemon is not part of the build that added Sweepstake")
endif()
foreach(unwanted "-Werror" "ccache" "_test\\.cc" "server/(daemon|rpc|storage|web)")
  if(commands MATCHES "[^\"\n]*${unwanted}[^\"\n]*")
    message(FATAL_ERROR "As a folder of another project, Sweepstake added '${unwanted}': ${CMAKE_MATCH_0}")
  endif()
endforeach()
# The daemon's libraries must not be searched for.
file(STRINGS ${WORK}/CMakeCache.txt asked REGEX "^(SQLite3|CLI11|spdlog|tomlplusplus|Boost|prometheus-cpp|libsystemd)_")
if(asked)
  message(FATAL_ERROR "As a folder of another project, Sweepstake searches for libraries that only the daemon needs: ${asked}")
endif()
file(GLOB_RECURSE test_lists ${WORK}/CTestTestfile.cmake ${WORK}/DartConfiguration.tcl)
if(test_lists)
  message(FATAL_ERROR "Sweepstake added tests to the project that added it: ${test_lists}")
endif()

# The game compiles, and installs only its own files.
execute_process(COMMAND ${CMAKE_COMMAND} --build ${WORK} --target CMakeFiles/game.dir/game.cc.o
  RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
if(NOT result EQUAL 0)
  message(FATAL_ERROR "${output}")
endif()
execute_process(COMMAND ${CMAKE_COMMAND} --install ${WORK} --prefix ${WORK}/installed
  RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
file(GLOB_RECURSE installed ${WORK}/installed/*)
if(NOT result EQUAL 0 OR installed)
  message(FATAL_ERROR "With EXCLUDE_FROM_ALL Sweepstake installs files of its own: ${installed} ${output}")
endif()
