# An overlay port, which builds the tree that contains it.
get_filename_component(SOURCE_PATH "${CMAKE_CURRENT_LIST_DIR}/../../../.." ABSOLUTE)

# The C ABI is always built as a shared library, and also as an archive if Highway is static.
set(VCPKG_POLICY_DLLS_IN_STATIC_LIBRARY enabled)

vcpkg_check_features(OUT_FEATURE_OPTIONS feature_options
  FEATURES
    daemon SWEEPSTAKE_WITH_DAEMON
  INVERTED_FEATURES
    telemetry CMAKE_DISABLE_FIND_PACKAGE_gRPC)

vcpkg_cmake_configure(
  SOURCE_PATH "${SOURCE_PATH}"
  OPTIONS
    ${feature_options}
    -DBUILD_TESTING=OFF
  MAYBE_UNUSED_VARIABLES
    CMAKE_DISABLE_FIND_PACKAGE_gRPC)
vcpkg_cmake_install()

vcpkg_cmake_config_fixup(CONFIG_PATH lib/cmake/sweepstake)
vcpkg_fixup_pkgconfig()
if("daemon" IN_LIST FEATURES)
  vcpkg_copy_tools(TOOL_NAMES sweepstake sweepstaked AUTO_CLEAN)
endif()
file(REMOVE_RECURSE "${CURRENT_PACKAGES_DIR}/debug/include" "${CURRENT_PACKAGES_DIR}/debug/share")

file(INSTALL "${CMAKE_CURRENT_LIST_DIR}/usage" DESTINATION "${CURRENT_PACKAGES_DIR}/share/${PORT}")
vcpkg_install_copyright(FILE_LIST "${SOURCE_PATH}/LICENSE")
