#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# Shared libraries: they show what is public, nothing else, and all that tests, demos and benchmarks
# want; the tests of the C interface pass on them, C's structs are laid out as its version has them,
# and types and exceptions go through their walls.
#   tests/package/shared.sh [BUILD]   default build/shared; configured and built where missing
# What is wanted is seen from build/release, which has to be there.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/common.sh" shared shared "$@"

users=$root/build/release
[[ -x $users/bin/pbd_test ]] || fail "preset release has not been built"

cmake --build "$build" --target tandem_c_files tandem_c_session tandem_virtual_network tandem_obj \
  c_test c_session_test c_files_test
ctest --test-dir "$build" -R '^c(_session|_files)?_test$' --no-tests=error --output-on-failure

prefix=$scratch/prefix
for component in runtime dev; do
  cmake --install "$build" --prefix "$prefix" --component "$component" >/dev/null
done
mapfile -t libraries < <(find "$prefix" -name 'libtandem_*.so' | sort)
folder=$(dirname "${libraries[0]}")
[[ ${#libraries[@]} -eq 12 ]] || fail "these are not twelve libraries: ${libraries[*]}"

# By their names: the version, the binary interface's, the linker's.
version=$(sed -n 's/^project(tandem VERSION \([0-9.]*\).*/\1/p' "$root/CMakeLists.txt")
case $version in
  0.*) abi=${version%.*} ;;
  *) abi=${version%%.*} ;;
esac
for library in "${libraries[@]}"; do
  [[ -f $library.$version && ! -L $library.$version ]] || fail "there is no $library.$version"
  soname=$(objdump -p "$library" | sed -n 's/^ *SONAME *//p')
  [[ $soname == "$(basename "$library").$abi" ]] || fail "$library has the soname $soname"
done

python3 "$here/exports.py" "$prefix/include" --users "$users" --list "$here/public_symbols.txt" \
  "${libraries[@]}" || fail "insides are shown, or what is public is not, or is not reviewed"
# The check of the check: it sees what is not ours, what no header has, and what one only mentions.
cat >"$scratch/probe.cpp" <<'END'
namespace tandem::pbd {
struct Probe { void seen(); };
void Probe::seen() {}
struct Solver { struct Impl { void seen(); }; };
void Solver::Impl::seen() {}
}
void seen() {}
END
c++ -shared -fPIC "$scratch/probe.cpp" -o "$scratch/probe.so"
python3 "$here/exports.py" "$prefix/include" "$scratch/probe.so" >"$scratch/log" && fail "blind"
[[ $(grep -c 'seen()' "$scratch/log") -eq 3 ]] || fail_with_log "the check of symbols is broken"
python3 "$here/exports.py" "$prefix/include" --users "$users" "$folder"/libtandem_{pbd,obj}.so \
  >"$scratch/log" && fail "what is wanted of the others is not missed"
grep -q 'objects want .* public symbols, [1-9]' "$scratch/log" ||
  fail_with_log "the check of what is wanted is broken"

python3 "$here/binding.py" "$folder/libtandem_c.so" "$folder/libtandem_c_session.so" || fail "the C interface is of another version"

# An application with hidden symbols, by each compiler there is; without what libraries have inside.
for compiler in c++ clang++; do
  command -v "$compiler" >/dev/null || continue
  for link in '' -Wl,--as-needed; do
    "$compiler" -std=c++20 -O1 -fvisibility=hidden -fvisibility-inlines-hidden $link \
      "$here/shared.cpp" -o "$scratch/shared" -I"$root/tests" \
      $(PKG_CONFIG_PATH=$folder/pkgconfig pkg-config --cflags --libs tandem-net \
        tandem-virtual_network tandem-obj) -Wl,-rpath,"$folder" || fail "$compiler does not build it"
    "$scratch/shared" >"$scratch/log" ||
      fail_with_log "types or exceptions do not get through ($compiler $link)"
  done
done
cat "$scratch/log"

# Users of a shared library do not need its internal dependencies.
for component in c c_session c_files session obj scene scene_files; do
  consumer "$component" "$prefix" fcl ccd tinyobjloader PkgConfig >/dev/null
done
# By pkg-config likewise: of other packages' files there is Eigen's alone.
mkdir "$scratch/pc"
cp "$folder"/pkgconfig/*.pc "$(pkg-config --variable=pcfiledir eigen3)/eigen3.pc" "$scratch/pc"
for component in pbd collision scene scene_files obj consensus virtual_network net session c c_session c_files; do
  PKG_CONFIG_LIBDIR=$scratch/pc pkg-config --cflags --libs "tandem-$component" >"$scratch/log" 2>&1 ||
    fail_with_log "tandem-$component wants more than Eigen"
done
echo "shared: all libraries show what is public"
