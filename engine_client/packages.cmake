# The packages that the libraries for games are compiled with. Only Highway is linked too, since the others have only headers. For each
# package, CMake uses in this order: the target of a project that contains this tree, the folder FETCHCONTENT_SOURCE_DIR_NAME, the installed
# package, and the version below, which it downloads. The Conan recipe requires the same versions.
include(FetchContent)

# sweepstake_fetch(NAME hwy TARGET hwy::hwy APT libhwy-dev URL ... SHA256 ... [INCLUDE /folder] [SOURCES files...])
# makes TARGET from the source of a package if no such target exists and none is installed. INCLUDE is the folder of the headers within the
# source. APT is Debian's name of the package, for the error without a network. A downloaded file with another hash is never kept.
function(sweepstake_fetch)
  cmake_parse_arguments(ARG "" "NAME;TARGET;INCLUDE;APT;URL;SHA256" "SOURCES" ${ARGN})
  string(TOLOWER ${ARG_NAME} name)
  string(TOUPPER ${ARG_NAME} upper)
  if(NOT TARGET ${ARG_TARGET} AND NOT FETCHCONTENT_SOURCE_DIR_${upper})
    find_package(${ARG_NAME} QUIET CONFIG)
  endif()
  if(TARGET ${ARG_TARGET})
    return()
  endif()

  set(archive ${PROJECT_BINARY_DIR}/downloads/${name}.tar)  # FetchContent detects the compression, but needs an extension
  set(hash "")
  if(EXISTS ${archive})
    file(SHA256 ${archive} hash)
  endif()
  if(NOT hash STREQUAL ARG_SHA256 AND NOT FETCHCONTENT_SOURCE_DIR_${upper})
    set(error "FETCHCONTENT_FULLY_DISCONNECTED is on")
    if(NOT FETCHCONTENT_FULLY_DISCONNECTED)
      message(STATUS "${ARG_NAME} is not installed: downloading ${ARG_URL}")
      file(DOWNLOAD ${ARG_URL} ${archive} STATUS status INACTIVITY_TIMEOUT 30)
      list(POP_FRONT status code error)
      if(code EQUAL 0)
        file(SHA256 ${archive} hash)
        set(error "the SHA-256 of ${ARG_URL} is ${hash} instead of ${ARG_SHA256}")
      endif()
    endif()
    if(NOT hash STREQUAL ARG_SHA256)
      file(REMOVE ${archive})
      message(FATAL_ERROR "${ARG_NAME} is neither installed nor could it be downloaded (${error}). Install it (Debian and Ubuntu: "
        "${ARG_APT}), or set FETCHCONTENT_SOURCE_DIR_${upper} to the folder of its source.")
    endif()
  endif()

  # The package's own CMakeLists.txt is not used, because it adds tests and installation rules.
  FetchContent_Declare(${ARG_NAME} URL ${archive} URL_HASH SHA256=${ARG_SHA256} SOURCE_SUBDIR without_cmake)
  FetchContent_MakeAvailable(${ARG_NAME})
  if(ARG_SOURCES)
    list(TRANSFORM ARG_SOURCES PREPEND ${${name}_SOURCE_DIR}/)
    add_library(sweepstake_${name} STATIC ${ARG_SOURCES})
    add_library(${ARG_TARGET} ALIAS sweepstake_${name})
    set_target_properties(sweepstake_${name} PROPERTIES EXPORT_NAME ${name} UNITY_BUILD OFF)
    target_include_directories(sweepstake_${name} SYSTEM PUBLIC $<BUILD_INTERFACE:${${name}_SOURCE_DIR}${ARG_INCLUDE}>)
    install(TARGETS sweepstake_${name} EXPORT sweepstake ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
  else()
    add_library(${ARG_TARGET} INTERFACE IMPORTED)
    target_include_directories(${ARG_TARGET} INTERFACE ${${name}_SOURCE_DIR}${ARG_INCLUDE})
  endif()
endfunction()

if(TARGET hwy AND NOT TARGET hwy::hwy)  # compiled by the project that contains this tree
  add_library(hwy::hwy ALIAS hwy)
endif()
sweepstake_fetch(NAME hwy TARGET hwy::hwy APT libhwy-dev SOURCES hwy/per_target.cc hwy/targets.cc
  URL https://github.com/google/highway/archive/refs/tags/1.0.7.tar.gz
  SHA256 5434488108186c170a5e2fca5e3c9b6ef59a1caa4d520b008a9b8be6b8abe6c5)
# The Highway that libraries link. Our own is exported with them. Any other is exported by its name: install(EXPORT) would refuse the
# target of a project that does not install it, but it does not look into a generator expression.
set(SWEEPSTAKE_HIGHWAY $<1:hwy::hwy>)
if(TARGET sweepstake_hwy)
  set(SWEEPSTAKE_HIGHWAY sweepstake_hwy)
  target_compile_definitions(sweepstake_hwy PUBLIC HWY_STATIC_DEFINE)
endif()
sweepstake_fetch(NAME Eigen3 TARGET Eigen3::Eigen APT libeigen3-dev
  URL https://gitlab.com/libeigen/eigen/-/archive/3.4.0/eigen-3.4.0.tar.bz2
  SHA256 b4c198460eba6f28d34894e3a5710998818515104d6e74e5cc331ce31e46e626)
sweepstake_fetch(NAME nlohmann_json TARGET nlohmann_json::nlohmann_json INCLUDE /include APT nlohmann-json3-dev
  URL https://github.com/nlohmann/json/releases/download/v3.11.3/json.tar.xz
  SHA256 d6c65aca6b1ed68e7a182f4757257b107ae403032760ed6ef121c9d55e81757d)
# The package of Debian has no CMake config.
find_path(PROTOZERO_INCLUDE_DIR protozero/pbf_message.hpp)
if(PROTOZERO_INCLUDE_DIR AND NOT FETCHCONTENT_SOURCE_DIR_PROTOZERO AND NOT TARGET protozero::protozero)
  add_library(protozero::protozero INTERFACE IMPORTED)
  target_include_directories(protozero::protozero INTERFACE ${PROTOZERO_INCLUDE_DIR})
endif()
sweepstake_fetch(NAME protozero TARGET protozero::protozero INCLUDE /include APT libprotozero-dev
  URL https://github.com/mapbox/protozero/archive/refs/tags/v1.7.1.tar.gz
  SHA256 27e0017d5b3ba06d646a3ec6391d5ccc8500db821be480aefd2e4ddc3de5ff99)
