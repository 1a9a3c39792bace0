# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""A recipe for Conan 2, of the sources that it lies in. Never run by Conan itself."""
import os
import re

from conan import ConanFile
from conan.tools.build import check_min_cppstd
from conan.tools.cmake import CMake, CMakeDeps, CMakeToolchain, cmake_layout
from conan.tools.files import copy, load


class TandemConan(ConanFile):
    name = "tandem"
    license = "MIT"
    description = "XPBD rigid bodies with consensus built into the solver"
    package_type = "library"
    settings = "os", "compiler", "build_type", "arch"
    options = {"shared": [True, False], "fPIC": [True, False]}
    default_options = {"shared": False, "fPIC": True, "tinyobjloader/*:double": True}
    implements = ["auto_shared_fpic"]

    @property
    def _root(self):
        return os.path.join(self.recipe_folder, "..", "..", "..")

    def set_version(self):
        text = load(self, os.path.join(self._root, "CMakeLists.txt"))
        self.version = re.search(r"project\(tandem VERSION ([0-9.]+)", text).group(1)

    def export_sources(self):
        folders = ["bindings/c", "cmake", "collision", "consensus", "net", "pbd"]
        for pattern in ["CMakeLists.txt", "LICENSE", "docs/scene.schema.json",
                        "docs/Doxyfile.in"] + [f"{folder}/*" for folder in folders]:
            copy(self, pattern, self._root, self.export_sources_folder)

    def layout(self):
        cmake_layout(self)

    def requirements(self):
        self.requires("eigen/3.4.0", transitive_headers=True)
        self.requires("fcl/0.7.0")
        self.requires("libccd/2.1")
        self.requires("xsimd/8.1.0")
        self.requires("asio/1.28.1")
        self.requires("libsodium/1.0.20")
        self.requires("tinyobjloader/1.0.6")
        self.requires("nlohmann_json/3.11.3")

    def validate(self):
        check_min_cppstd(self, 20)

    def generate(self):
        toolchain = CMakeToolchain(self)
        for part in ("TESTS", "DEMOS", "BENCHMARKS"):
            toolchain.cache_variables[f"TANDEM_BUILD_{part}"] = False
        toolchain.generate()
        deps = CMakeDeps(self)
        # By the names that Tandem looks for.
        for package, file, target in (
            ("fcl", "fcl", "fcl"),
            ("libccd", "ccd", "ccd"),
            ("xsimd", "xsimd", "xsimd"),
            ("tinyobjloader", "tinyobjloader", "tinyobjloader::tinyobjloader_double"),
        ):
            deps.set_property(package, "cmake_file_name", file)
            deps.set_property(package, "cmake_target_name", target)
        deps.generate()

    def build(self):
        cmake = CMake(self)
        cmake.configure()
        cmake.build()

    def package(self):
        CMake(self).install()

    def package_info(self):
        # Tandem's own files, with its components.
        self.cpp_info.set_property("cmake_find_mode", "none")
        self.cpp_info.builddirs = [os.path.join("lib", "cmake", "tandem")]
