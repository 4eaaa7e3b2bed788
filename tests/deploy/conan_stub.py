"""Stubs of the part of Conan 2 that the recipes use: they record the requests of a recipe. `load` runs every method of a recipe
in the same order as Conan."""
import collections
import importlib.util
import pathlib
import sys
import types


class ConanInvalidConfiguration(Exception):
    pass


class Component:
    def __init__(self):
        self.libs, self.defines, self.requires, self.system_libs = [], [], [], []


class CppInfo:
    def __init__(self):
        self.components = collections.defaultdict(Component)
        self.includedirs, self.bindir = ["/dependency/include"], "bin"


class Option:
    def __init__(self, owner, name):
        self.__dict__.update(owner=owner, name=name)

    def __setattr__(self, _, value):
        setattr(self.owner, self.name, value)


class Options:
    """Reading an option gives its value; `.NAME.value = x` sets it, as in Conan."""

    def __init__(self, values):
        self.__dict__.update(values)

    def get_safe(self, name):
        return vars(self).get(name)


class ConfigurableOptions(Options):
    """In configure() an option is an object with a value."""

    def __getattribute__(self, name):
        values = object.__getattribute__(self, "__dict__")
        return Option(self, name) if name in values else object.__getattribute__(self, name)


class ConanFile:
    default_options = {}

    def requires(self, reference, **_):
        self.required.append(reference)

    def tool_requires(self, reference):
        self.tools.append(reference)

    def run(self, command, **_):
        self.ran.append(pathlib.Path(command).name)


class Toolchain:
    def __init__(self, recipe):
        self.cache_variables = recipe.cache_variables

    def generate(self):
        pass


class Dependencies:
    def __init__(self, recipe):
        self.recipe = recipe

    def set_property(self, name, *_):
        assert any(reference.startswith(name + "/") for reference in self.recipe.required), name

    def generate(self):
        pass


class CMake:
    def __init__(self, recipe):
        self.recipe = recipe

    def configure(self):
        self.recipe.built.append("configure")

    def build(self):
        self.recipe.built.append("build")

    def install(self):
        assert self.recipe.built == ["configure", "build"]


def copy(recipe, pattern, src, dst, excludes=None):
    del excludes
    assert dst
    if dst == recipe.export_sources_folder:
        recipe.exported.append(pattern)
    else:
        assert (pathlib.Path(src) / pattern).exists(), pattern


def check_min_cppstd(recipe, standard):
    assert standard == 20 and recipe.settings.arch


def pretend_conan():
    modules = {
        "conan": {"ConanFile": ConanFile},
        "conan.errors": {"ConanInvalidConfiguration": ConanInvalidConfiguration},
        "conan.tools": {},
        "conan.tools.build": {"check_min_cppstd": check_min_cppstd, "can_run": lambda recipe: True,
                              "stdcpp_library": lambda recipe: {"Linux": "stdc++"}.get(recipe.settings.os)},
        "conan.tools.cmake": {"CMake": CMake, "CMakeDeps": Dependencies, "CMakeToolchain": Toolchain, "cmake_layout": lambda recipe: None},
        "conan.tools.files": {"collect_libs": lambda recipe: recipe.installed, "copy": copy, "load": lambda recipe, path: pathlib.Path(path).read_text(), "rmdir": lambda recipe, path: None},
    }
    for name, members in modules.items():
        sys.modules[name] = types.ModuleType(name)
        vars(sys.modules[name]).update(members)


def recipe_class(path):
    pretend_conan()
    spec = importlib.util.spec_from_file_location("recipe", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return next(value for value in vars(module).values()
                if isinstance(value, type) and issubclass(value, ConanFile) and value is not ConanFile)


def load(path, os="Linux", arch="x86_64", installed=(), **chosen):
    made = recipe_class(path)
    recipe = made()
    recipe.recipe_folder = str(pathlib.Path(path).parent)
    recipe.source_folder = str(pathlib.Path(path).resolve().parents[2])
    recipe.package_folder, recipe.export_sources_folder = "/package", "/export"
    recipe.settings = types.SimpleNamespace(os=os, arch=arch)
    recipe.required, recipe.tools, recipe.exported, recipe.built, recipe.ran, recipe.cache_variables = [], [], [], [], [], {}
    recipe.cpp_info, recipe.installed = CppInfo(), installed
    recipe.cpp = types.SimpleNamespace(build=CppInfo())
    recipe.dependencies = collections.defaultdict(lambda: types.SimpleNamespace(cpp_info=CppInfo()))
    recipe.tested_reference_str = "sweepstake/0"
    choices = {**made.default_options, **chosen}
    recipe.options = Options(choices)

    run(recipe, "set_version", "export_sources", "config_options")
    recipe.options = ConfigurableOptions(vars(recipe.options))
    run(recipe, "configure")
    recipe.options = Options(object.__getattribute__(recipe.options, "__dict__"))
    run(recipe, "layout", "requirements", "build_requirements", "validate", "generate", "build", "package", "package_info", "test")
    return recipe


def run(recipe, *methods):
    for name in methods:
        if hasattr(recipe, name):
            getattr(recipe, name)()
