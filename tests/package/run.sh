#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# Installs a build into a temporary prefix, builds and runs a consumer of each component against
# it, and looks into the results: who does without a module carries nothing of its dependencies.
#   tests/package/run.sh [BUILD]     default build/release; configured and built where missing
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/common.sh" package release "$@"

cmake --build "$build"
prefix=$scratch/prefix
cmake --install "$build" --prefix "$prefix" >/dev/null
[[ -n $(find "$prefix" -path "*/doc/tandem/LICENSE") ]] || fail "the license is not installed"
# The programs too.
"$prefix/bin/tandem-key" >/dev/null || fail "tandem-key is not installed"
"$prefix/bin/tandem-demo" cubes --seconds 1 --print nothing || fail "a demo is not installed"

# Names that a dependency leaves in an executable, defined or wanted.
fcl='(^|[^A-Za-z_])(fcl::|octomap::|ccd[A-Z]|_ccd)'
asio='(^|[^A-Za-z_])asio::'
json='(^|[^A-Za-z_])nlohmann::'
obj='(^|[^A-Za-z_])tinyobj::|NEEDED libtinyobj'

joints='(^|[^A-Za-z_])tandem::Scene::joints'
whole='(^|[^A-Za-z_])tandem::(Scene|Session)::'
parts='(^|[^A-Za-z_])tandem::(Car|Character|Cloth|Ragdoll|Rope|pbd::ClothBlock)::'

# symbols COMPONENT: everything its executable defines or wants, and the libraries it loads.
symbols() {
  nm -C "$scratch/$1/consumer"
  nm -C -D "$scratch/$1/consumer"
  objdump -p "$scratch/$1/consumer" | sed -n 's/^ *NEEDED */NEEDED /p'
}

without() {
  local component=$1 what=$2 pattern=$3 found
  found=$(symbols "$component" | grep -E "$pattern" | head -5) || true
  [[ -z $found ]] || fail "the consumer of $component contains $what:"$'\n'"$found"
}

with() {
  local component=$1 what=$2 pattern=$3
  # Not grep -q: it would leave before nm has written all.
  [[ $(symbols "$component" | grep -cE "$pattern") -gt 0 ]] ||
    fail "no $what in the consumer of $component: the check for its absence sees nothing"
}

consumer pbd "$prefix" fcl ccd octomap tinyobjloader Asio
without pbd FCL "$fcl|NEEDED lib(fcl|ccd|octo)"
without pbd Asio "$asio"

consumer consensus "$prefix" fcl ccd octomap tinyobjloader Asio
without consensus FCL "$fcl|NEEDED lib(fcl|ccd|octo)"
without consensus Asio "$asio"

consumer virtual_network "$prefix" fcl ccd octomap tinyobjloader Asio
without virtual_network Asio "$asio"

consumer collision "$prefix" tinyobjloader Asio
without collision Asio "$asio"
without collision tinyobjloader "$obj"
without collision Scene "$whole"
with collision FCL "$fcl"
with collision FCL "NEEDED libfcl"

begin
consumer scene "$prefix" tinyobjloader Asio
took find_package
without scene Asio "$asio"
without scene tinyobjloader "$obj"
with scene FCL "$fcl"
with scene Scene "$whole"
without scene joints "$joints"

consumer scene_files "$prefix" tinyobjloader nlohmann_json Asio
without scene_files Asio "$asio"
without scene_files tinyobjloader "$obj"
with scene_files nlohmann_json "$json"
without scene nlohmann_json "$json"

consumer obj "$prefix" Asio
without obj Asio "$asio"
with obj tinyobjloader "$obj"

consumer net "$prefix" fcl ccd octomap tinyobjloader Asio
without net FCL "$fcl|NEEDED lib(fcl|ccd|octo)"
without net Session "$whole"
with net Asio "$asio"

consumer session "$prefix" fcl ccd octomap tinyobjloader Asio
without session FCL "$fcl|NEEDED lib(fcl|ccd|octo)"
with session Asio "$asio"
with session Session "$whole"

consumer c "$prefix" tinyobjloader nlohmann_json Asio
without c Asio "$asio"
without c nlohmann_json "$json"
without c parts "$parts"
without c Session "(^|[^A-Za-z_])tandem::Session::"

consumer c_session "$prefix" tinyobjloader nlohmann_json Asio
with c_session Asio "$asio"
without c_session nlohmann_json "$json"
without c_session parts "$parts"

consumer c_files "$prefix" tinyobjloader nlohmann_json Asio
with c_files nlohmann_json "$json"
without c_files Asio "$asio"

# Warnings that users may enable find nothing in headers, nor in the README's way to fill a struct.
warnings=(-Wall -Wextra -Wpedantic -Wmissing-field-initializers -Werror)
/usr/bin/python3 "$here/designated.py" g++ clang++

# The same without CMake, and from a tree that was moved.
mv "$prefix" "$scratch/moved"
for component in pbd collision scene scene_files obj consensus virtual_network net session c c_session c_files; do
  source=$here/$component.cpp
  language=(c++ -std=c++20 "${warnings[@]}")
  if [[ $component == c || $component == c_* ]]; then
    source=$here/$component.c
    language=(cc -std=c11)
  fi
  begin
  flags=$(PKG_CONFIG_PATH=$(echo "$scratch"/moved/lib*/pkgconfig) \
    pkg-config --cflags --libs "tandem-$component") || fail "pkg-config has no tandem-$component"
  # The flags are words.
  # shellcheck disable=SC2086
  "${language[@]}" "$source" -o "$scratch/plain" $flags -lm ||
    fail "$component does not build by pkg-config"
  "$scratch/plain" >/dev/null || fail "the consumer of $component by pkg-config fails"
  [[ $component != scene ]] || took pkg-config
done
# The first program of the README, as it stands there.
awk '/^```cpp$/ {inside = 1; next} /^```$/ && inside {exit} inside' "$root/README.md" \
  >"$scratch/readme.cpp"
flags=$(PKG_CONFIG_PATH=$(echo "$scratch"/moved/lib*/pkgconfig) pkg-config --cflags --libs tandem-scene)
# shellcheck disable=SC2086
c++ -std=c++20 "${warnings[@]}" "$scratch/readme.cpp" -o "$scratch/readme" $flags ||
  fail "the program of the README does not build"
[[ $("$scratch/readme") == "the cube lies at 0.050 m" ]] || fail "the program of the README fails"
mv "$scratch/moved" "$prefix"

# As sources in somebody else's project: the falling cube, and of Tandem what it links. In the build folder,
# and below one name, as ccache knows files by their paths there.
subproject() {
  local way=$1 folder=$build/package/$1 extra
  rm -rf "$folder"
  begin
  cmake -S "$here/subproject" -B "$folder" -G Ninja -DWAY="$way" -DTANDEM_SOURCES="$root" \
    -DPROGRAM="$here/scene.cpp" -DCMAKE_UNITY_BUILD=ON -DCMAKE_UNITY_BUILD_BATCH_SIZE=0 \
    -DCMAKE_EXPORT_COMPILE_COMMANDS=ON "${@:2}" >"$scratch/log" 2>&1 ||
    fail_with_log "a project with Tandem by $way cannot be configured"
  cmake --build "$folder" >"$scratch/log" 2>&1 || fail_with_log "a project with Tandem by $way does not build"
  "$folder/cube" || fail "the program with Tandem by $way fails"
  took "$way"
  extra=$(find "$folder" -name '*.a' ! -name 'libtandem_pbd.a' ! -name 'libtandem_collision.a' \
    ! -name 'libtandem_scene.a')
  [[ -z $extra ]] || fail "by $way more is built than what is linked:"$'\n'"$extra"
  # Its own flags, and of Tandem's where headers are and the standard.
  python3 - "$folder/compile_commands.json" <<'FLAGS' || fail "flags of Tandem reach a project with it by $way"
import json, sys
program, = (entry for entry in json.load(open(sys.argv[1])) if "/cube.dir/" in entry["file"])
flags = program["command"].split(" -o ")[0].split()[1:]
theirs = {"-Wall", "-Wextra", "-Wpedantic", "-Wmissing-field-initializers", "-Werror"}
leaked = [flag for flag in flags if flag.startswith("-") and not flag.startswith("-I") and flag not in theirs
          and flag not in ("-isystem", "-std=gnu++20")]
sys.exit(f"flags: {leaked}" if leaked or not theirs <= set(flags) else 0)
FLAGS
  ! ctest --test-dir "$folder" -N 2>/dev/null | grep "Test *#" || fail "by $way the tests above are there"
  # They may install theirs.
  cmake --install "$folder" --prefix "$scratch/$way" >"$scratch/log" 2>&1 ||
    fail_with_log "a project with Tandem by $way cannot be installed"
  [[ $(find "$scratch/$way" -type f) == "$scratch/$way/bin/cube" ]] || fail "by $way Tandem is installed as well"
}
subproject add_subdirectory
subproject FetchContent -DCMAKE_DISABLE_FIND_PACKAGE_tinyobjloader=ON \
  -DCMAKE_DISABLE_FIND_PACKAGE_nlohmann_json=ON -DCMAKE_DISABLE_FIND_PACKAGE_Asio=ON

# The ladder of examples, and the tutorial as it stands: each says what it claims, and ends with 0
# where that holds.
cmake -S "$root/demos/examples" -B "$scratch/examples" -DCMAKE_PREFIX_PATH="$prefix" \
  -DCMAKE_CXX_FLAGS="${warnings[*]}" \
  >"$scratch/log" 2>&1 && cmake --build "$scratch/examples" >>"$scratch/log" 2>&1 ||
  fail_with_log "the examples do not build"
ctest --test-dir "$scratch/examples" --no-tests=error --output-on-failure ||
  fail "an example does not hold"
long=$(wc -l "$root"/demos/examples/*.cpp | awk '$2 != "total" && $1 >= 100')
[[ -z $long ]] || fail "an example is longer than a hundred lines: $long"
python3 "$here/tutorial.py" "$root/docs/tutorial.md" "$prefix"

# Asking for what is not there says so, and does not speak of somebody else's package.
rm "$prefix"/lib*/cmake/tandem/tandem-collision-targets*.cmake
if cmake -S "$here" -B "$scratch/absent" -DCOMPONENT=collision -DCMAKE_PREFIX_PATH="$prefix" \
  -DCMAKE_DISABLE_FIND_PACKAGE_fcl=ON >"$scratch/log" 2>&1; then
  fail "a missing component was found"
fi
grep -q "Tandem was built without collision" "$scratch/log" ||
  fail_with_log "a missing component is not named"

# Writable data: whatever lies in .data, .bss or their thread-local kin under a name. Relocated
# constants (.data.rel.ro: tables of virtual functions) and the reference to the exception
# personality are not.
writable() {
  objdump -t -C "$1" | awk '
    match($0, /[ \t]\.(data|bss|tdata|tbss)[^ \t]*[ \t]/) || /\*COM\*/ {
      section = substr($0, RSTART + 1, RLENGTH - 2)
      if (section ~ /^\.data\.rel\.ro/ || section ~ /DW\.ref\./) next
      if (substr($0, 18, 7) ~ /d/) next  # the name of the section itself
      print
    }'
}
# The check of the check: it sees a global, a static and a thread-local, and no constant.
printf '%s\n' 'int seen_a; static int seen_b = 1; thread_local int seen_c;' \
  'int* use() { ++seen_b; return &seen_b; }' 'extern const int unseen; const int unseen = 3;' \
  'struct B { virtual ~B(); virtual void f(); }; B::~B() {} void B::f() {}' >"$scratch/probe.cpp"
c++ -fPIC -c "$scratch/probe.cpp" -o "$scratch/probe.o"
[[ $(writable "$scratch/probe.o" | grep -c 'seen_[abc]$') -eq 3 &&
  $(writable "$scratch/probe.o" | wc -l) -eq 3 ]] || {
  writable "$scratch/probe.o" >&2
  fail "the check for writable data is broken"
}
for library in "$prefix"/lib*/libtandem_*; do
  [[ -L $library ]] && continue
  # libstdc++'s table of threads that wait for an atomic; std::atomic::wait brings it.
  waiters='std::__detail::__waiter_pool_base::'
  ignored=$waiters
  case $library in
    # FCL's and Asio's headers bring the start-up object of the standard streams.
    *_collision.*) ignored=" std::__ioinit\$|$waiters" ;;
    # Asio keeps its own: service ids, thread-local call stacks, error categories.
    *_net.*) ignored=" std::__ioinit\$|[[:space:]](guard variable for )?asio::|$waiters" ;;
  esac
  found=$(writable "$library" | grep -vE "$ignored") || true
  [[ -z $found ]] || fail "$(basename "$library") has writable globals:"$'\n'"$found"
done

echo "package: all components stand alone"
