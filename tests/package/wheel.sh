#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# The Python package as a wheel with all that it needs inside: made, taken by pip, used.
#   tests/package/wheel.sh
# Exits with 77 where the sources of FCL and libccd cannot be fetched or there is no pip, and says so.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
scratch=$(mktemp -d)
source "$root/tests/package/timing.sh"
trap 'rm -rf "$scratch"' EXIT

fail() {
  echo "wheel: $*" >&2
  exit 1
}
skip() {
  echo "SKIPPED: $*"
  exit 77
}
/usr/bin/python3 -m pip --version >/dev/null 2>&1 || skip "there is no pip"
bash "$root/bindings/web/fetch-sources.sh" "$root/build/web_sources" >/dev/null 2>&1 ||
  skip "the sources of FCL and libccd cannot be fetched here"

bash "$root/bindings/python/build_wheel.sh" "$scratch" >"$scratch/path" 2>"$scratch/log" ||
  { cat "$scratch/log" >&2; fail "the wheel is not made"; }
wheel=$(<"$scratch/path")
site=$scratch/site
begin
/usr/bin/python3 -m pip install --quiet --root-user-action=ignore --no-index --no-deps --no-cache-dir --target "$site" \
  "$wheel" ||
  fail "pip does not take $wheel"
(cd "$scratch" && PYTHONPATH=$site /usr/bin/python3 "$root/tests/package/fall.py") || fail "the cube does not fall"
took wheel
module=$(echo "$site"/tandem/_tandem.*.so)
needs=$(ldd "$module" | awk '{print $1}')
echo "wheel: $(basename "$wheel"), $(stat -c %s "$wheel") bytes, wants ${needs//$'\n'/ }"
others=$(grep -vE '^(linux-vdso\.so|libc\.so|libm\.so|/lib64/ld-linux)' <<<"$needs") || true
[[ -z $others ]] || fail "it wants libraries that not every system has: $others"
! grep -rlF "$root" "$site" || fail "the files above know where they were built"
for name in LICENSE fcl ccd sodium nlohmann_json; do
  [[ -s $(echo "$site"/tandem-*.dist-info/licenses/$name) ]] || fail "the license of $name is not in it"
done

program='
import importlib.metadata, secrets, tandem
assert tandem.__version__ == importlib.metadata.version("tandem"), tandem.__version__
scene = tandem.Scene()
scene.add(tandem.HalfSpace(), type="static")
ball = scene.add(tandem.Sphere(0.1), position=(0, 0, 1))
hull = scene.add(tandem.Hull([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]), position=(3, 0, 2))
scene.step(1 / 60, steps=240)
assert abs(scene.state[ball.index, 2] - 0.1) < 1e-3, scene.state
assert abs(scene.state[hull.index, 2] - 0.5) < 1e-3, scene.state
file = tandem.Scene.parse(scene.write())  # nlohmann_json
hero = tandem.Character(file, position=(0, 5, 1))
hero.walk((1, 0, 0), 1 / 60)
file.step(1 / 60)
assert len(file.bodies) == 4, file.bodies
try:
    scene.step(-1.0)
    raise SystemExit("a step of -1 s is taken")
except ValueError as error:
    assert "-1" in str(error), error
session = tandem.Session(scene, tandem.Udp(0, key=secrets.token_bytes(32)), peer=1)  # libsodium
assert session.port > 0
session.close()
with tandem.view(scene, open_browser=False) as page:
    page.show()
print("wheel:", tandem.__file__)'
(cd "$scratch" && PYTHONPATH=$site /usr/bin/python3 -c "$program") || fail "the package does not run"
echo "wheel: the package can be used"
