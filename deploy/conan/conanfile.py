"""Sweepstake for Conan 2, built from the tree that this recipe is part of: conan create deploy/conan"""
import os
import re

from conan import ConanFile
from conan.errors import ConanInvalidConfiguration
from conan.tools.build import check_min_cppstd, stdcpp_library
from conan.tools.cmake import CMake, CMakeDeps, CMakeToolchain, cmake_layout
from conan.tools.files import collect_libs, copy, load, rmdir

# The dependencies of each static library of the package: the same as those of its CMake target.
LIBRARIES = {
    "math": [],
    "text": [],
    "decider": ["math", "text"],
    "embedded_decider": ["adaptive", "decider"],
    "broad_phase": ["math", "text", "highway::highway"],
    "scene": ["math", "text"],
    "adaptive": ["broad_phase", "math", "text"],
    "embedded": ["decider", "embedded_decider", "scene"],
}
TELEMETRY = {
    "proto": ["grpc::grpc", "protobuf::protobuf"],
    "proto_conversion": ["decider", "proto"],
    "tls": ["openssl::openssl", "grpc::grpc"],
    "telemetry": ["embedded", "math", "text", "proto", "proto_conversion", "tls", "abseil::abseil"],
}


class SweepstakeConan(ConanFile):
    name = "sweepstake"
    description = "Interchangeable broad phases of collision detection, and a decider that learns which one suits the running game"
    license = "MIT"
    topics = ("collision-detection", "broad-phase", "physics", "game-development")
    settings = "os", "arch", "compiler", "build_type"
    options = {"telemetry": [True, False], "daemon": [True, False]}
    default_options = {"telemetry": False, "daemon": False}

    def set_version(self):
        project = load(self, os.path.join(self.recipe_folder, "..", "..", "CMakeLists.txt"))
        self.version = re.search(r"project\(sweepstake VERSION ([0-9.]+)", project).group(1)

    def export_sources(self):
        root = os.path.join(self.recipe_folder, "..", "..")
        for pattern in ("CMakeLists.txt", "LICENSE", "engine_client/*", "server/*", "proto/*"):
            copy(self, pattern, src=root, dst=self.export_sources_folder, excludes="*/node_modules/*")

    def config_options(self):
        if self.settings.os != "Linux":
            del self.options.daemon

    def configure(self):
        if self.options.get_safe("daemon"):
            self.options.telemetry.value = True

    def layout(self):
        cmake_layout(self)

    def requirements(self):
        self.requires("highway/1.0.7")
        self.requires("eigen/3.4.0")
        self.requires("nlohmann_json/3.11.3")
        self.requires("protozero/1.7.1")
        if self.options.telemetry:
            self.requires("grpc/1.54.3")
            self.requires("protobuf/3.21.12")
            self.requires("abseil/[>=20220623.0]")
            self.requires("openssl/[>=3 <4]")
        if self.options.get_safe("daemon"):
            self.requires("boost/[>=1.81 <2]")
            self.requires("cli11/[>=2.3 <3]")
            self.requires("libcurl/[>=7.85 <9]")
            self.requires("zlib/[>=1.2.11 <2]")
            self.requires("libpq/[>=15 <18]")
            self.requires("libsystemd/[>=252]")
            self.requires("prometheus-cpp/[>=1.0 <2]")
            self.requires("spdlog/[>=1.10 <2]")
            self.requires("sqlite3/[>=3.40 <4]")
            self.requires("tomlplusplus/[>=3.3 <4]")

    def build_requirements(self):
        self.tool_requires("cmake/[>=3.25]")
        if self.options.telemetry:
            self.tool_requires("grpc/<host_version>")
            self.tool_requires("protobuf/<host_version>")

    def validate(self):
        check_min_cppstd(self, 20)
        if self.settings.arch not in ("x86_64", "armv8"):
            raise ConanInvalidConfiguration("Sweepstake is for 64-bit processors: x86_64 or armv8")

    def generate(self):
        toolchain = CMakeToolchain(self)
        toolchain.cache_variables["BUILD_TESTING"] = False
        toolchain.cache_variables["SWEEPSTAKE_WITH_DAEMON"] = bool(self.options.get_safe("daemon"))
        toolchain.cache_variables["CMAKE_DISABLE_FIND_PACKAGE_gRPC"] = not self.options.telemetry
        toolchain.cache_variables["PROTOZERO_INCLUDE_DIR"] = self.dependencies["protozero"].cpp_info.includedirs[0]
        toolchain.generate()
        dependencies = CMakeDeps(self)
        dependencies.set_property("highway", "cmake_file_name", "hwy")
        dependencies.set_property("highway", "cmake_target_name", "hwy::hwy")
        dependencies.generate()

    def build(self):
        cmake = CMake(self)
        cmake.configure()
        cmake.build()

    def package(self):
        copy(self, "LICENSE", src=self.source_folder, dst=os.path.join(self.package_folder, "licenses"))
        CMake(self).install()
        # Conan generates its own files from package_info.
        rmdir(self, os.path.join(self.package_folder, "lib", "cmake"))
        rmdir(self, os.path.join(self.package_folder, "lib", "pkgconfig"))

    def package_info(self):
        self.cpp_info.components["c"].libs = ["sweepstake"]
        # The archive exists only if Highway is static.
        if "sweepstake_static" in collect_libs(self):
            archive = self.cpp_info.components["c_static"]
            archive.libs = ["sweepstake_static"]
            archive.defines = ["SWP_STATIC"]
            if self.settings.os == "Linux":
                archive.system_libs = ["m", "pthread"]
            # A C compiler may link the archive.
            if runtime := stdcpp_library(self):
                archive.system_libs.append(runtime)
        # It exists only with gRPC, and not on Windows.
        if "sweepstake_grpc" in collect_libs(self):
            connection = self.cpp_info.components["c_grpc"]
            connection.libs = ["sweepstake_grpc"]
            connection.requires = ["c", "grpc::grpc", "openssl::openssl"]
        libraries = dict(LIBRARIES)
        if self.options.telemetry:
            libraries.update(TELEMETRY)
        for name, requires in libraries.items():
            component = self.cpp_info.components[name]
            component.libs = ["sweepstake_" + name]
            component.requires = requires
            if self.settings.os == "Linux":
                component.system_libs = ["m", "pthread"]
        # Dependencies without a library of their own: their code is compiled into our libraries.
        self.cpp_info.components["built_with"].requires = [
            "eigen::eigen", "nlohmann_json::nlohmann_json", "protozero::protozero"]
        if self.options.get_safe("daemon"):
            self.cpp_info.components["programs"].requires = [
                "boost::headers", "cli11::cli11", "libcurl::libcurl", "libpq::pq", "libsystemd::libsystemd", "prometheus-cpp::prometheus-cpp", "spdlog::spdlog",
                "sqlite3::sqlite3", "tomlplusplus::tomlplusplus", "zlib::zlib"]
