"""Conan package of the C++ core: headers, CMake files and the sources of stillreach::dispatch."""

import re

from conan import ConanFile
from conan.tools.cmake import CMake, cmake_layout
from conan.tools.files import copy, load


class Stillreach(ConanFile):
    """Nothing is compiled before a consumer links stillreach::dispatch: one package for all settings."""

    name = "stillreach"
    description = "Keeps a redundant robot arm on its task after joints fail"
    license = "Apache-2.0"
    package_type = "header-library"
    settings = "os", "arch", "compiler", "build_type"
    options = {"urdf": [True, False]}  # noqa: RUF012 - Conan's way
    default_options = {"urdf": False}  # noqa: RUF012
    generators = "CMakeToolchain"
    exports = "pyproject.toml"
    exports_sources = "CMakeLists.txt", "pyproject.toml", "LICENSE", "include/*", "dispatch/*", "cmake/*"
    no_copy_source = True

    def set_version(self):
        """Reads the version where it is written."""
        self.version = re.search(r'^version = "([^"]+)"', load(self, f"{self.recipe_folder}/pyproject.toml"), re.M)[1]

    def requirements(self):
        """Only stillreach::urdf needs a library."""
        if self.options.urdf:
            self.requires("tinyxml2/[>=9]", transitive_headers=True, transitive_libs=True)

    def layout(self):
        """CMake's usual folders."""
        cmake_layout(self)

    def package_id(self):
        """The same package for all settings and options."""
        self.info.clear()

    def package(self):
        """What `cmake --install` installs, and the licence."""
        cmake = CMake(self)
        cmake.configure()
        cmake.install()
        copy(self, "LICENSE", self.source_folder, f"{self.package_folder}/licenses")

    def package_info(self):
        """Consumers find the package by its own stillreach-config.cmake."""
        self.cpp_info.bindirs = self.cpp_info.libdirs = []
        self.cpp_info.builddirs = ["share/cmake/stillreach"]
        self.cpp_info.set_property("cmake_find_mode", "none")
