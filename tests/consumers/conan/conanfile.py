"""Builds and runs tests/consumers against the package that `conan create` made."""

from conan import ConanFile
from conan.tools.build import can_run
from conan.tools.cmake import CMake, CMakeToolchain, cmake_layout


class Consumer(ConanFile):
    settings = "os", "arch", "compiler", "build_type"
    generators = "CMakeDeps"

    def requirements(self):
        self.requires(self.tested_reference_str)

    def layout(self):
        cmake_layout(self)

    def generate(self):
        toolchain = CMakeToolchain(self)
        version = self.dependencies["stillreach"].ref.version
        toolchain.cache_variables["VERSION"] = f"{version.major}.{version.minor}"
        toolchain.cache_variables["DISPATCHED"] = f"{self.recipe_folder}/../dispatched.cpp"
        toolchain.cache_variables["STILLREACH_INSTRUCTION_SETS"] = "baseline"
        toolchain.cache_variables["KERNEL_OPTIONS"] = "-O0"
        if self.dependencies["stillreach"].options.urdf:
            toolchain.cache_variables["URDF"] = self.conf.get("user.stillreach:urdf")
        toolchain.generate()

    def build(self):
        cmake = CMake(self)
        cmake.configure(build_script_folder="..")
        cmake.build()

    def test(self):
        if can_run(self):
            self.run(f"{self.build_folder}/dispatched", env="conanrun")
            if self.dependencies["stillreach"].options.urdf:
                self.run(f"{self.build_folder}/urdf", env="conanrun")
