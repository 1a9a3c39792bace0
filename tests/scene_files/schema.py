#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""docs/scene.schema.json holds for what write_scene() writes and for the files of rooms, and not for what is wrong.

schema.py SOURCE scene_files_test
"""
import copy
import json
import os
import pathlib
import subprocess
import sys
import tempfile

try:
    import jsonschema
except ImportError:
    print("SKIPPED: there is no python3-jsonschema")
    sys.exit(77)

source = pathlib.Path(sys.argv[1])
schema = json.loads((source / "docs/scene.schema.json").read_text())
jsonschema.Draft202012Validator.check_schema(schema)
validator = jsonschema.Draft202012Validator(schema)

with tempfile.TemporaryDirectory() as folder:
    written = os.path.join(folder, "scene.json")
    subprocess.run([sys.argv[2], "[determinism]"], check=True, stdout=subprocess.DEVNULL,
                   env={**os.environ, "TANDEM_WRITE_SCENE": written})
    scenes = [json.loads(pathlib.Path(written).read_text())]
scenes += [json.loads(path.read_text()) for path in sorted((source / "tools/room/page").glob("room-*.json"))]
assert len(scenes) == 4 and all(len(scene["bodies"]) > 5 for scene in scenes)
for scene in scenes:
    validator.validate(scene)
    wrong = copy.deepcopy(scene)
    wrong["bodies"][3]["frction"] = 1
    assert not validator.is_valid(wrong)
    wrong = copy.deepcopy(scene)
    wrong["bodies"][3]["position"] = [0, 0]
    assert not validator.is_valid(wrong)
print(f"{len(scenes)} scenes are valid")
