# The C ABI for engines that cannot load a shared library of the system: an archive (consoles, iOS),
# and a plug-in (Unity) that depends only on libc, libm and libpthread. Both contain Highway. So
# Highway must be a static library.
get_target_property(highway_type hwy::hwy TYPE)
if(highway_type STREQUAL "STATIC_LIBRARY")
  set(highway $<TARGET_FILE:hwy::hwy>)
else()
  find_library(SWEEPSTAKE_STATIC_HIGHWAY NAMES libhwy.a HINTS ${PROJECT_SOURCE_DIR}/build/highway
    DOC "Static Highway; deploy/static_highway.sh makes one")
  set(highway ${SWEEPSTAKE_STATIC_HIGHWAY})
endif()
if(NOT highway)
  message(STATUS "Left out: the C ABI as an archive and as a plug-in. Missing: a static Highway (deploy/static_highway.sh)")
  return()
endif()

# sweepstake_c_parts(RESULT targets...): sets RESULT to all static libraries of this project that
# the targets depend on, each once.
function(sweepstake_c_parts result)
  set(open ${ARGN})
  set(found)
  while(open)
    list(POP_FRONT open name)
    if(NOT TARGET ${name})
      continue()
    endif()
    get_target_property(original ${name} ALIASED_TARGET)
    if(original)
      set(name ${original})
    endif()
    get_target_property(type ${name} TYPE)
    get_target_property(imported ${name} IMPORTED)
    if(type STREQUAL "STATIC_LIBRARY" AND NOT imported AND NOT name IN_LIST found)
      list(APPEND found ${name})
      get_target_property(libraries ${name} LINK_LIBRARIES)
      list(APPEND open ${libraries})
    endif()
  endwhile()
  set(${result} ${found} PARENT_SCOPE)
endfunction()

# Compiled without export attributes. With them, a game's own shared library that links the archive
# would export swp_* too.
sweepstake_c_objects(sweepstake_c_static_objects SWP_STATIC)
set(objects $<TARGET_OBJECTS:sweepstake_c_static_objects>)
sweepstake_c_parts(all_parts ${parts})
list(REMOVE_ITEM all_parts sweepstake_hwy)  # it is ${highway}; any other Highway is linked by a generator expression, which is not followed
list(TRANSFORM all_parts REPLACE "(.+)" "$<TARGET_FILE:\\1>" OUTPUT_VARIABLE archives)

set(linker_help)
if(UNIX AND NOT APPLE AND CMAKE_OBJCOPY)
  execute_process(COMMAND ${CMAKE_LINKER} --help OUTPUT_VARIABLE linker_help ERROR_QUIET)
endif()
if(linker_help MATCHES "force-group-allocation")
  set(merged ${CMAKE_CURRENT_BINARY_DIR}/sweepstake_c_merged.o)
  add_custom_command(OUTPUT ${merged}
    COMMAND ${CMAKE_COMMAND} -DLINKER=${CMAKE_LINKER} -DOBJCOPY=${CMAKE_OBJCOPY} -DNM=${CMAKE_NM} "-DOBJECTS=${objects}"
      "-DARCHIVES=${archives};${highway}" -DOUT=${merged} -P ${CMAKE_CURRENT_LIST_DIR}/merge_objects.cmake
    DEPENDS ${objects} ${archives} ${highway} ${CMAKE_CURRENT_LIST_DIR}/merge_objects.cmake
    COMMENT "Merging the parts of the C ABI, of which only swp_* stays global" VERBATIM)
  set_source_files_properties(${merged} PROPERTIES EXTERNAL_OBJECT ON GENERATED ON)
  add_custom_target(sweepstake_c_merged DEPENDS ${merged})
  add_library(sweepstake_c_static STATIC ${merged})
  add_dependencies(sweepstake_c_static sweepstake_c_merged)
else()
  message(STATUS "The archive of the C ABI also exports C++ symbols (sweepstake::, hwy::, std::), because GNU ld and objcopy, which would hide them, are missing")
  list(TRANSFORM all_parts REPLACE "(.+)" "$<TARGET_OBJECTS:\\1>" OUTPUT_VARIABLE part_objects)
  add_library(sweepstake_c_static STATIC ${objects} ${part_objects})
  if(MSVC)
    set_target_properties(sweepstake_c_static PROPERTIES STATIC_LIBRARY_OPTIONS ${highway})
  else()
    add_custom_command(TARGET sweepstake_c_static POST_BUILD
      COMMAND ${CMAKE_COMMAND} -DAR=${CMAKE_AR} -DARCHIVE=$<TARGET_FILE:sweepstake_c_static> -DADDED=${highway}
        -DWORK=${CMAKE_CURRENT_BINARY_DIR}/highway -P ${CMAKE_CURRENT_LIST_DIR}/add_archive.cmake VERBATIM)
  endif()
endif()

# Lists the libraries that a C++ compiler links implicitly, because a C compiler may link the
# archive.
set(runtime ${CMAKE_CXX_IMPLICIT_LINK_LIBRARIES})
list(REMOVE_ITEM runtime ${CMAKE_C_IMPLICIT_LINK_LIBRARIES})
list(REMOVE_DUPLICATES runtime)
add_library(sweepstake::c_static ALIAS sweepstake_c_static)
set_target_properties(sweepstake_c_static PROPERTIES
  OUTPUT_NAME sweepstake_static EXPORT_NAME c_static LINKER_LANGUAGE C)
target_compile_definitions(sweepstake_c_static INTERFACE SWP_STATIC)
target_include_directories(sweepstake_c_static INTERFACE
  $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/engine_client/include> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
target_link_libraries(sweepstake_c_static INTERFACE ${runtime} Threads::Threads)
install(TARGETS sweepstake_c_static EXPORT sweepstake_c ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
list(TRANSFORM runtime PREPEND "-l" OUTPUT_VARIABLE runtime_flags)
list(JOIN runtime_flags " " runtime_flags)
sweepstake_c_pkg_config(sweepstake-static "an archive" " -DSWP_STATIC" "-lsweepstake_static ${runtime_flags} ${CMAKE_THREAD_LIBS_INIT}")

# The plug-in for systems with glibc. On other systems the shared library is used as the plug-in,
# provided that the tool chain links its runtime statically.
string(TOLOWER "${CMAKE_SYSTEM_NAME}-${CMAKE_SYSTEM_PROCESSOR}" platform)
string(REPLACE "amd64" "x86_64" platform "${platform}")
include(CheckSymbolExists)
check_symbol_exists(__GLIBC__ features.h SWEEPSTAKE_HAS_GLIBC)
if(SWEEPSTAKE_HAS_GLIBC AND platform MATCHES "^linux-(x86_64|aarch64)$")
  add_library(sweepstake_plugin SHARED flavours/older_glibc.c $<TARGET_OBJECTS:sweepstake_c_objects>)
  set_target_properties(sweepstake_plugin PROPERTIES
    OUTPUT_NAME sweepstake LINKER_LANGUAGE CXX LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/plugin
    BUILD_WITH_INSTALL_RPATH ON LINK_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/exports.map)
  list(JOIN archives "," plugin_parts)  # as files, since the targets would bring a Highway that is shared
  target_link_libraries(sweepstake_plugin PRIVATE
    $<BUILD_INTERFACE:sweepstake_flags> $<LINK_GROUP:RESCAN,${plugin_parts},${highway}>)
  add_dependencies(sweepstake_plugin ${all_parts})
  # Before version 2.34, glibc had its thread functions in libpthread, so the plug-in must load that
  # library.
  target_link_options(sweepstake_plugin PRIVATE
    -static-libstdc++ -static-libgcc LINKER:--gc-sections LINKER:--exclude-libs,ALL LINKER:--no-undefined LINKER:-z,noexecstack
    LINKER:-z,relro LINKER:--version-script=${CMAKE_CURRENT_SOURCE_DIR}/exports.map
    LINKER:--push-state,--no-as-needed,-l:libpthread.so.0,--pop-state)
  set(plugin sweepstake_plugin)
else()
  add_custom_target(sweepstake_plugin DEPENDS sweepstake_c)
  set(plugin sweepstake_c)
endif()
# The layout of a Unity package. Unity does not import folders whose names end with ~.
install(TARGETS ${plugin} COMPONENT plugin EXCLUDE_FROM_ALL
  LIBRARY DESTINATION Runtime/Plugins/${platform} RUNTIME DESTINATION Runtime/Plugins/${platform}
  ARCHIVE DESTINATION Native~/${platform})
# The .meta files tell Unity the platform of the library. Unity has no names for other platforms
# than those with such files.
set(metas ${PROJECT_SOURCE_DIR}/unity_client/tools/plugin_metas/Runtime)
if(EXISTS ${metas}/Plugins/${platform}.meta)
  install(FILES ${metas}/Plugins.meta DESTINATION Runtime COMPONENT plugin EXCLUDE_FROM_ALL)
  install(FILES ${metas}/Plugins/${platform}.meta DESTINATION Runtime/Plugins COMPONENT plugin EXCLUDE_FROM_ALL)
  install(DIRECTORY ${metas}/Plugins/${platform} DESTINATION Runtime/Plugins COMPONENT plugin EXCLUDE_FROM_ALL)
endif()
install(DIRECTORY ${PROJECT_SOURCE_DIR}/engine_client/include/sweepstake DESTINATION Native~/include
  COMPONENT plugin EXCLUDE_FROM_ALL FILES_MATCHING PATTERN "c_*.h" PATTERN "c_daemon.h" EXCLUDE)
