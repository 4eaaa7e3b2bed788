# The C ABI's connection to a daemon (c_daemon.h), a shared library beside that of the C ABI. It contains the C++ session with a daemon and
# uses gRPC of the system. On Windows it is left out, because it would have to import and export functions of one macro.
if(NOT SWEEPSTAKE_WITH_GRPC OR WIN32)
  return()
endif()
add_library(sweepstake_c_grpc SHARED boundary.cc grpc/daemon.cc sized_struct.cc)
add_library(sweepstake::c_grpc ALIAS sweepstake_c_grpc)
set_target_properties(sweepstake_c_grpc PROPERTIES
  OUTPUT_NAME sweepstake_grpc EXPORT_NAME c_grpc VERSION ${PROJECT_VERSION} SOVERSION 3 INSTALL_RPATH "$ORIGIN")
target_include_directories(sweepstake_c_grpc PRIVATE ${PROJECT_SOURCE_DIR})
target_link_libraries(sweepstake_c_grpc PUBLIC sweepstake_c PRIVATE
  $<BUILD_INTERFACE:sweepstake::telemetry> $<BUILD_INTERFACE:sweepstake::proto> $<BUILD_INTERFACE:sweepstake_flags>)
if(NOT APPLE)
  target_link_options(sweepstake_c_grpc PRIVATE
    LINKER:--version-script=${CMAKE_CURRENT_SOURCE_DIR}/exports.map LINKER:--no-undefined LINKER:--as-needed LINKER:--gc-sections)
  set_target_properties(sweepstake_c_grpc PROPERTIES LINK_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/exports.map)
endif()
install(TARGETS sweepstake_c_grpc EXPORT sweepstake_c_grpc LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(EXPORT sweepstake_c_grpc NAMESPACE sweepstake:: FILE sweepstakeCGrpcTargets.cmake
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/sweepstake)
sweepstake_c_pkg_config(sweepstake-grpc "with the connection to a daemon" "" "-lsweepstake_grpc -lsweepstake")
