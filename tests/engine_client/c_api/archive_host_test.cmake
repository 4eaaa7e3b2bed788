# cmake -DREADELF=… -DLIBRARY=… -P archive_host_test.cmake: fails if a shared library that links the archive exports a function of
# the C ABI, which would then replace that of another plug-in in the same process.
cmake_minimum_required(VERSION 3.25)

execute_process(COMMAND ${READELF} --wide --dyn-syms ${LIBRARY} OUTPUT_VARIABLE symbols COMMAND_ERROR_IS_FATAL ANY)
if(NOT symbols MATCHES " main\n")
  message(FATAL_ERROR "${LIBRARY} does not show its own function, or is read wrongly: ${symbols}")
endif()
string(REGEX MATCHALL " swp_[a-z_]+" shown "${symbols}")
if(shown)
  message(FATAL_ERROR "linked into another library, the archive shows:${shown}")
endif()
