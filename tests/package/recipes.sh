#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# The recipes for vcpkg and Conan, without either: they can be read, name the sources' version and options that there are,
# and call what the managers have.
#   tests/package/recipes.sh
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

fail() {
  echo "recipes: $*" >&2
  exit 1
}
version=$(sed -n 's/^project(tandem VERSION \([0-9.]*\).*/\1/p' "$root/CMakeLists.txt")
port=$root/cmake/packaging/vcpkg/tandem

PYTHONDONTWRITEBYTECODE=1 python3 - "$root" "$version" <<'PYTHON' || fail "a recipe cannot be read"
import json, re, sys, types, unittest.mock as mock

root, version = sys.argv[1:]
port = json.load(open(f"{root}/cmake/packaging/vcpkg/tandem/vcpkg.json"))
name = re.compile(r"[a-z0-9]+(-[a-z0-9]+)*")
assert set(port) <= {"$schema", "name", "version", "description", "license", "supports", "dependencies"}, port
assert name.fullmatch(port["name"]) and port["version"] == version and port["license"] == "MIT", port
for dependency in port["dependencies"]:
    entry = {"name": dependency} if isinstance(dependency, str) else dependency
    assert set(entry) <= {"name", "host", "features"} and name.fullmatch(entry["name"]), entry

class ConanFile:
    cpp_info = mock.Mock()

modules = {"conan": types.SimpleNamespace(ConanFile=ConanFile)}
for module in ("tools", "tools.build", "tools.cmake", "tools.files"):
    modules[f"conan.{module}"] = mock.MagicMock()
modules["conan.tools.files"].load = lambda _, path: open(path).read()
copied = []
modules["conan.tools.files"].copy = lambda _, pattern, *folders: copied.append(pattern)
with mock.patch.dict(sys.modules, modules):
    for folder, steps in (("conan", "set_version export_sources layout requirements validate generate build package package_info"),
                          ("conan/test_package", "requirements layout build test")):
        space = {}
        path = f"{root}/cmake/packaging/{folder}/conanfile.py"
        exec(compile(open(path).read(), path, "exec"), space)
        recipe, = (c for c in space.values() if isinstance(c, type) and issubclass(c, ConanFile) and c is not ConanFile)
        one = recipe()
        one.recipe_folder = path.rsplit("/", 1)[0]
        one.export_sources_folder = "sources"
        one.requires = mock.Mock()
        one.run = mock.Mock()
        one.tested_reference_str = "tandem"
        one.cpp = types.SimpleNamespace(build=types.SimpleNamespace(bindir="bin"))
        for step in steps.split():
            getattr(one, step)()
        if folder == "conan":
            assert one.version == version, one.version
import glob
for pattern in copied:
    assert glob.glob(f"{root}/{pattern}"), f"there is no {pattern}"
PYTHON

# The functions that vcpkg's ports call, which say what they were given.
cat >"$scratch/run.cmake" <<'CMAKE'
foreach(name IN ITEMS vcpkg_cmake_configure vcpkg_cmake_install vcpkg_cmake_config_fixup vcpkg_fixup_pkgconfig
        vcpkg_install_copyright)
  cmake_language(EVAL CODE "function(${name})\nmessage(STATUS \"${name} \${ARGN}\")\nendfunction()")
endforeach()
function(vcpkg_find_acquire_program name)
  set(${name} pkgconf PARENT_SCOPE)
endfunction()
set(PORT tandem)
include("${CURRENT_PORT_DIR}/portfile.cmake")
CMAKE
cmake "-DCURRENT_PORT_DIR=$port" "-DCURRENT_PACKAGES_DIR=$scratch/packages" -P "$scratch/run.cmake" >"$scratch/log" 2>&1 ||
  { cat "$scratch/log" >&2; fail "the port does not run"; }
grep -qF "SOURCE_PATH;$root" "$scratch/log" || { cat "$scratch/log" >&2; fail "the port takes other sources"; }
[[ -s $scratch/packages/share/tandem/usage ]] || fail "the port does not say how it is used"
for option in $(grep -ohE 'TANDEM_[A-Z_]+' "$port/portfile.cmake") TANDEM_BUILD_{TESTS,DEMOS,BENCHMARKS}; do
  grep -qE "option\\($option " "$root/CMakeLists.txt" || fail "there is no option $option"
done
echo "recipes: vcpkg's and Conan's can be read, and were not run by them"
