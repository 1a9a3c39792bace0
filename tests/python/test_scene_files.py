# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
import json
import os
import subprocess

import pytest
import tandem

DOOR = {
    "gravity": [0, 0, -5],
    "bodies": [
        {"name": "ground", "type": "static", "shape": {"type": "halfSpace"}},
        {"name": "door", "shape": {"type": "box", "halfExtents": [0.4, 0.02, 1]}, "mass": 20, "position": [0.4, 0, 2]},
        {"name": "cup", "shape": {"type": "cylinder", "radius": 0.05, "halfHeight": 0.1}, "position": [0.5, 1, 0.4]},
        {"shape": {"type": "sphere", "radius": 0.1}, "position": [0.5, 1.01, 0.8]},
    ],
    "joints": [
        {"name": "hinge", "type": "hinge", "b": "door", "at": {"position": [0, 0, 2], "axis": [0, 0, 1]}}
    ],
}
BALL_IN_GLTF = {
    "asset": {"version": "2.0"},
    "extensionsUsed": ["KHR_implicit_shapes", "KHR_physics_rigid_bodies"],
    "extensions": {"KHR_implicit_shapes": {"shapes": [{"type": "sphere", "sphere": {"radius": 0.5}}]}},
    "scene": 0,
    "scenes": [{"nodes": [0]}],
    "nodes": [
        {
            "name": "ball",
            "translation": [1, 2, 3],
            "extensions": {
                "KHR_physics_rigid_bodies": {
                    "motion": {"mass": 7},
                    "collider": {"geometry": {"shape": 0}},
                }
            },
        }
    ],
}


@pytest.fixture
def door(tmp_path):
    path = tmp_path / "door.json"
    path.write_text(json.dumps(DOOR))
    return path


def test_a_file_has_the_names_and_the_bits_of_cpp(door):
    program = [os.environ["TANDEM_REFERENCE"], "file", str(door), "80"]
    said = subprocess.run(program, capture_output=True, check=True, text=True).stdout.split("\n")
    for path in (door, str(door)):
        scene = tandem.Scene.load(path, substeps=3)
        scene.step(1 / 60, 80)
        assert scene.hash() == int(said[0])
        assert scene.names == [name for name in said[1:] if name] == ["ground", "door", "cup"]


def test_bodies_and_joints_are_found_by_name(door):
    scene = tandem.Scene.load(door)
    assert scene.gravity == pytest.approx((0, 0, -5)) and scene.warnings == []
    assert scene.find("door").mass == 20 and scene.find("ground").type == "static"
    assert scene.find("cup") == scene.bodies[2]
    assert scene.joint_names == ["hinge"]
    scene.find_joint("hinge").set_motor(speed=1.0)
    scene.step(1 / 60, 30)
    assert scene.find_joint("hinge").angle == pytest.approx(0.5, abs=0.02)
    scene.remove(scene.find("door"))  # its joint goes with it
    assert scene.names == ["ground", "cup"] and scene.joint_names == []
    for find, name in ((scene.find, "door"), (scene.find, ""), (scene.find, "d"), (scene.find_joint, "hinge")):
        with pytest.raises(ValueError, match=f"name must be .*'{name}'"):
            find(name)


def test_what_is_written_is_read_again_by_the_same_bits(door, tmp_path):
    scene = tandem.Scene.load(door)
    text = scene.write()
    again = tandem.Scene.parse(text.encode())
    assert again.names == scene.names and again.joint_names == scene.joint_names
    for one in (scene, again):
        one.step(1 / 60, 100)
    assert again.hash() == scene.hash()


def test_gltf_is_turned_so_that_z_is_up(tmp_path):
    text = json.dumps(BALL_IN_GLTF)
    path = tmp_path / "ball.gltf"
    path.write_text(text)
    for scene in (tandem.Scene.load(path), tandem.Scene.parse(text, format="gltf", folder=tmp_path)):
        assert scene.names == ["ball"]
        assert scene.find("ball").position == pytest.approx((1, -3, 2)) and scene.find("ball").mass == 7


def test_a_body_from_text_has_its_name():
    scene = tandem.Scene()
    assert scene.names == [] and scene.warnings == []
    cup = scene.add_text('{"name": "cup", "shape": {"type": "sphere", "radius": 0.1}, "mass": 3}')
    assert scene.find("cup") == cup and cup.mass == 3 and scene.names == ["cup"]
    assert tandem.Scene.parse(scene.write()).find("cup").mass == 3
    state = scene.state
    with pytest.raises(BufferError):
        scene.add_text('{"shape": {"type": "sphere", "radius": 0.1}}')
    assert len(state) == len(scene.bodies) == 1


def test_ropes_are_not_written():
    scene = tandem.Scene()
    tandem.Rope(scene)
    with pytest.raises(ValueError, match="cloth"):
        scene.write()


@pytest.mark.parametrize(
    "action, words",
    [
        (lambda f: tandem.Scene.load(f / "none.json"), ["none.json"]),
        (lambda f: tandem.Scene.parse("{"), ["scene"]),
        (lambda f: tandem.Scene.parse('{"bodies": [{"mass": -1}]}'), ["/bodies/0"]),
        (lambda f: tandem.Scene.parse("{}", format="xml"), ["format", "'json', 'gltf'", "'xml'"]),
        (lambda f: tandem.Scene.parse("{}", substeps=0), ["substeps", "0"]),
        (lambda f: tandem.Scene.parse("[" * 100), ["scene"]),
        (lambda f: tandem.Scene.parse(b"\xff\xfe"), ["scene"]),
        (lambda f: tandem.Scene().add_text('{"shape": {"type": "blob"}}'), ["blob"]),
    ],
)
def test_errors_name_file_place_and_rule(action, words, tmp_path):
    with pytest.raises(ValueError) as error:
        action(tmp_path)
    for word in words:
        assert word in str(error.value)


def test_what_is_no_keyword_is_a_type_error():
    with pytest.raises(TypeError, match=r"parse\(\).*'subteps'"):
        tandem.Scene.parse("{}", subteps=3)
    with pytest.raises(TypeError, match=r"load\(\).*'folder'"):
        tandem.Scene.load("x", folder="y")
