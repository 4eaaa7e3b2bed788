#!/usr/bin/env python3
"""Tests the vcpkg port and the Conan recipe without a network, vcpkg or Conan. They must list the same dependencies as CMake, and
the port's script and every method of the recipe must run with stubs of the functions that they call.

    packages_test.py SOURCE BUILD
"""
import json
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

import conan_stub

SOURCE, BUILD = (pathlib.Path(folder).resolve() for folder in sys.argv[1:3])
CMAKE = (SOURCE / "CMakeLists.txt").read_text()
FETCHED = (SOURCE / "engine_client/packages.cmake").read_text()
VERSION = re.search(r"project\(sweepstake VERSION ([0-9.]+)", CMAKE).group(1)
PORT = SOURCE / "deploy/vcpkg/ports/sweepstake"

# The packages that CMake searches: the name in vcpkg, the name in Conan Center, and the feature that needs it.
PACKAGES = {
    "hwy": (["highway"], "highway", None),
    "Eigen3": (["eigen3"], "eigen", None),
    "nlohmann_json": (["nlohmann-json"], "nlohmann_json", None),
    "protozero": (["protozero"], "protozero", None),
    "gRPC": (["grpc"], "grpc", "telemetry"),
    "Protobuf": (["protobuf"], "protobuf", "telemetry"),
    "OpenSSL": (["openssl"], "openssl", "telemetry"),
    "absl": (["abseil"], "abseil", "telemetry"),
    "SQLite3": (["sqlite3"], "sqlite3", "daemon"),
    "CLI11": (["cli11"], "cli11", "daemon"),
    "spdlog": (["spdlog"], "spdlog", "daemon"),
    "tomlplusplus": (["tomlplusplus"], "tomlplusplus", "daemon"),
    "Boost": (["boost-asio", "boost-beast"], "boost", "daemon"),
    "ZLIB": (["zlib"], "zlib", "daemon"),
    "CURL": (["curl"], "libcurl", "daemon"),
    "prometheus-cpp": (["prometheus-cpp"], "prometheus-cpp", "daemon"),
    "libsystemd": (["libsystemd"], "libsystemd", "daemon"),
    "libpq": (["libpq"], "libpq", "daemon"),
}
PART_OF_THE_SYSTEM = {"Threads", "PkgConfig"}


def asked_for():
    found = set(re.findall(r"find_package\(([\w-]+)", CMAKE)) | set(re.findall(r"pkg_check_modules\(([\w-]+)", CMAKE))
    found |= set(re.findall(r"^sweepstake_fetch\(NAME (\w+)", FETCHED, re.M))
    return found - PART_OF_THE_SYSTEM


def cmake_options():
    lists = "".join(file.read_text() for file in [SOURCE / "CMakeLists.txt", *SOURCE.glob("engine_client/**/CMakeLists.txt")])
    return set(re.findall(r"option\((\w+)", lists))


def names(dependencies):
    plain = [entry if isinstance(entry, str) else entry["name"] for entry in dependencies
             if isinstance(entry, str) or not entry.get("host")]
    return set(plain) - {"sweepstake"}


class CMakeTest(unittest.TestCase):
    def test_every_package_that_cmake_searches_is_in_the_list(self):
        self.assertEqual(asked_for(), set(PACKAGES))


class VcpkgManifestTest(unittest.TestCase):
    def setUp(self):
        self.manifest = json.loads((PORT / "vcpkg.json").read_text())

    def test_it_names_this_project(self):
        self.assertEqual(self.manifest["name"], PORT.name)
        self.assertEqual(self.manifest["version"], VERSION)
        self.assertEqual(self.manifest["license"], (SOURCE / "LICENSE").read_text().split()[0])

    def test_it_has_only_valid_fields(self):
        fields = {"name", "version", "description", "license", "supports", "dependencies", "features"}
        self.assertEqual(set(self.manifest), fields)
        for feature in self.manifest["features"].values():
            self.assertEqual(set(feature) - {"supports"}, {"description", "dependencies"})
        every = [self.manifest, *self.manifest["features"].values()]
        for entry in (entry for part in every for entry in part["dependencies"]):
            fields = {"name"} if isinstance(entry, str) else set(entry)
            self.assertLessEqual({"name"}, fields)
            self.assertLessEqual(fields, {"name", "host", "features", "default-features"})
            name = entry if isinstance(entry, str) else entry["name"]
            self.assertRegex(name, r"^[a-z0-9]+(-[a-z0-9]+)*$")

    def test_each_feature_depends_on_the_packages_that_cmake_searches(self):
        for feature in (None, "telemetry", "daemon"):
            part = self.manifest["features"][feature] if feature else self.manifest
            needed = {name for ports, _, needs in PACKAGES.values() if needs == feature for name in ports}
            self.assertEqual(names(part["dependencies"]), needed, feature)

    def test_the_lists_are_sorted_as_vcpkg_formats_them(self):
        for part in (self.manifest, *self.manifest["features"].values()):
            listed = [entry if isinstance(entry, str) else entry["name"] for entry in part["dependencies"]]
            self.assertEqual(listed, sorted(listed))
        self.assertEqual(list(self.manifest["features"]), sorted(self.manifest["features"]))


class PortfileTest(unittest.TestCase):
    def run_port(self, features):
        """Runs the script; returns its calls as lists, and the files of the package."""
        with tempfile.TemporaryDirectory() as folder:
            command = ["cmake", f"-DPORTFILE={PORT / 'portfile.cmake'}", f"-DFOLDER={folder}", f"-DFEATURES={';'.join(features)}",
                       "-P", SOURCE / "tests/deploy/vcpkg_stub.cmake"]
            done = subprocess.run(command, capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, done.stderr)
            files = {str(file.relative_to(folder)) for file in pathlib.Path(folder).rglob("*") if file.is_file()}
            calls = [line.split(";") for line in (pathlib.Path(folder) / "calls.txt").read_text().splitlines()]
            return {call[0]: call[1:] for call in calls}, files

    def test_it_builds_this_tree(self):
        calls, _ = self.run_port([])
        configured = calls["vcpkg_cmake_configure"]
        self.assertEqual(configured[configured.index("SOURCE_PATH") + 1], str(SOURCE))
        self.assertEqual(calls["vcpkg_install_copyright"], ["FILE_LIST", str(SOURCE / "LICENSE")])

    def test_it_sets_only_options_that_cmake_has(self):
        calls, _ = self.run_port(["telemetry"])
        known = cmake_options() | {"CMAKE_DISABLE_FIND_PACKAGE_gRPC"}
        set_here = {entry[2:].partition("=")[0] for entry in calls["vcpkg_cmake_configure"] if entry.startswith("-D")}
        self.assertLessEqual({"BUILD_TESTING", "SWEEPSTAKE_WITH_DAEMON"}, set_here)
        self.assertLessEqual(set_here, known)

    def test_features_set_the_options_of_cmake(self):
        plain = self.run_port([])[0]
        whole = self.run_port(["telemetry", "daemon"])[0]
        for setting, value in (("SWEEPSTAKE_WITH_DAEMON", "OFF"), ("CMAKE_DISABLE_FIND_PACKAGE_gRPC", "ON")):
            other = "ON" if value == "OFF" else "OFF"
            self.assertIn(f"-D{setting}={value}", plain["vcpkg_cmake_configure"])
            self.assertIn(f"-D{setting}={other}", whole["vcpkg_cmake_configure"])
        self.assertNotIn("vcpkg_copy_tools", plain)
        self.assertEqual(whole["vcpkg_copy_tools"], ["TOOL_NAMES", "sweepstake", "sweepstaked", "AUTO_CLEAN"])

    def test_it_installs_the_usage_text_and_moves_the_cmake_config(self):
        calls, files = self.run_port([])
        self.assertIn("package/share/sweepstake/usage", files)
        self.assertFalse([file for file in files if "debug/include" in file])
        self.assertEqual(calls["vcpkg_cmake_config_fixup"], ["CONFIG_PATH", "lib/cmake/sweepstake"])
        self.assertIn("set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/sweepstake)", CMAKE)


def exported_targets(file_name):
    """Returns the static libraries in an exported file of targets: name, and the libraries of this project that each one needs."""
    found = {}
    for file in [*BUILD.glob(f"CMakeFiles/Export/*/{file_name}"), *BUILD.glob(f"engine_client/*/CMakeFiles/Export/*/{file_name}")]:
        text = file.read_text()
        for name, properties in re.findall(r"add_library\(sweepstake::(\w+) STATIC IMPORTED\)\n(.*?)\n\)", text, re.S):
            found[name] = set(re.findall(r"sweepstake::(\w+)", properties)) - {name}
    return found


class ConanTest(unittest.TestCase):
    maxDiff = None

    def made(self, **choices):
        return conan_stub.load(SOURCE / "deploy/conan/conanfile.py", **choices)

    def test_it_names_this_project(self):
        recipe = self.made()
        self.assertEqual((recipe.name, recipe.version, recipe.license), ("sweepstake", VERSION, "MIT"))

    def test_each_option_requires_the_packages_that_cmake_searches(self):
        for options, features in (({}, {None}), ({"telemetry": True}, {None, "telemetry"}),
                                  ({"daemon": True}, {None, "telemetry", "daemon"})):
            required = {reference.partition("/")[0] for reference in self.made(**options).required}
            self.assertEqual(required, {name for _, name, feature in PACKAGES.values() if feature in features}, options)

    def test_cmake_downloads_the_versions_that_the_recipe_requires(self):
        downloaded = {(PACKAGES[name][1], version) for name, version in
                      re.findall(r"^sweepstake_fetch\(NAME (\w+) .*\n +URL \D+([\d.]*\d)", FETCHED, re.M)}
        self.assertEqual({f"{name}/{version}" for name, version in downloaded}, set(self.made().required))

    def test_every_requirement_is_used_by_a_component(self):
        for options in ({}, {"telemetry": True}, {"daemon": True}):
            recipe = self.made(**options)
            used = {entry.partition("::")[0] for part in recipe.cpp_info.components.values() for entry in part.requires if "::" in entry}
            self.assertEqual(used, {reference.partition("/")[0] for reference in recipe.required}, options)

    def test_components_are_the_exported_targets(self):
        recipe = self.made(telemetry=True)
        exported = {**exported_targets("sweepstakeTargets.cmake"), **exported_targets("sweepstakeTelemetryTargets.cmake")}
        self.assertIn("adaptive", exported)
        components = {name: set(part.requires) for name, part in recipe.cpp_info.components.items() if name not in ("c", "built_with")}
        if "telemetry" not in exported:  # built without gRPC
            components = {name: needs for name, needs in components.items() if name not in ("telemetry", "proto", "tls")}
        self.assertEqual({name: {need for need in needs if "::" not in need} for name, needs in components.items()}, exported)

    def test_the_archive_of_the_c_abi_is_a_component_if_it_is_installed(self):
        flavours = (SOURCE / "engine_client/c_api/flavours/flavours.cmake").read_text()
        installed, component = re.search(r"OUTPUT_NAME (\w+) EXPORT_NAME (c_\w+)", flavours).groups()
        definition = re.search(r"target_compile_definitions\(sweepstake_c_static INTERFACE (\w+)\)", flavours).group(1)
        self.assertNotIn(component, self.made(installed=["sweepstake"]).cpp_info.components)
        for system, libraries in (("Linux", ["m", "pthread", "stdc++"]), ("Windows", [])):
            archive = self.made(installed=["sweepstake", installed], os=system).cpp_info.components[component]
            self.assertEqual((archive.libs, archive.defines, archive.requires), ([installed], [definition], []))
            self.assertEqual(archive.system_libs, libraries)

    def test_the_connection_of_the_c_abi_is_a_component_if_it_is_installed(self):
        cmake = (SOURCE / "engine_client/c_api/grpc/grpc.cmake").read_text()
        installed, component = re.search(r"OUTPUT_NAME (\w+) EXPORT_NAME (c_\w+)", cmake).groups()
        self.assertNotIn(component, self.made(telemetry=True).cpp_info.components)
        connection = self.made(telemetry=True, installed=["sweepstake", installed]).cpp_info.components[component]
        self.assertEqual((connection.libs, connection.requires), ([installed], ["c", "grpc::grpc", "openssl::openssl"]))

    def test_it_sets_only_options_that_cmake_has(self):
        known = cmake_options() | {"CMAKE_DISABLE_FIND_PACKAGE_gRPC", "PROTOZERO_INCLUDE_DIR"}
        self.assertLessEqual(set(self.made().cache_variables), known)

    def test_options_set_the_options_of_cmake(self):
        for options, daemon, without_grpc in (({}, False, True), ({"telemetry": True}, False, False), ({"daemon": True}, True, False)):
            variables = self.made(**options).cache_variables
            self.assertIs(variables["SWEEPSTAKE_WITH_DAEMON"], daemon)
            self.assertIs(variables["CMAKE_DISABLE_FIND_PACKAGE_gRPC"], without_grpc)

    def test_its_exported_files_exist(self):
        recipe = self.made()
        self.assertLessEqual({"CMakeLists.txt", "engine_client/*", "server/*"}, set(recipe.exported))
        for pattern in recipe.exported:
            self.assertTrue(list(SOURCE.glob(pattern)), pattern)

    def test_it_is_for_64_bit_processors_and_has_no_daemon_on_windows(self):
        with self.assertRaises(conan_stub.ConanInvalidConfiguration):
            self.made(arch="x86")
        self.assertNotIn("daemon", vars(self.made(os="Windows").options))

    def test_the_recipe_of_its_test_runs(self):
        recipe = conan_stub.load(SOURCE / "deploy/conan/test_package/conanfile.py")
        built = (SOURCE / "deploy/conan/test_package/CMakeLists.txt").read_text()
        self.assertEqual(recipe.ran, re.findall(r"add_executable\((\w+)", built))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
