"""Stands for the recipe of tinyxml2 on Conan's remote, which tests do not ask: the library of this machine."""

from conan import ConanFile


class TinyXml2(ConanFile):
    name = "tinyxml2"
    version = "9.0.0"
    package_type = "shared-library"

    def package_info(self):
        self.cpp_info.includedirs = self.cpp_info.libdirs = []
        self.cpp_info.system_libs = ["tinyxml2"]
        self.cpp_info.set_property("cmake_file_name", "tinyxml2")
        self.cpp_info.set_property("cmake_target_name", "tinyxml2::tinyxml2")
