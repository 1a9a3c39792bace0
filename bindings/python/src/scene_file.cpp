// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Scenes from files and as text, and their names.
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <cctype>
#include <exception>
#include <set>
#include <utility>

#include "bind.h"
#include "body.h"
#include "joint.h"
#include "keywords.h"
#include "robot_file.h"
#include "scene_options.h"

namespace tandem::python {
namespace {

enum class SceneFormat { Json, Gltf };

/// @throws std::invalid_argument if it was given although the file's format has no such option
void require_format(bool fits, const py::kwargs& given, const char* name, const char* format,
                    const std::filesystem::path& path) {
  if (!fits && given.contains(name)) {
    pbd::detail::refuse(name, std::string("left out unless the file is ") + format, path.string());
  }
}

CorePtr load(const std::filesystem::path& path, const py::kwargs& given) {
  std::string ending = path.extension().string();
  std::ranges::transform(ending, ending.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  const bool urdf = ending == ".urdf", mjcf = ending == ".xml" || ending == ".mjcf";
  py::kwargs rest(py::dict(given.attr("copy")()));
  RobotOptions robot;
  take(rest, "packages", robot.packages);
  take(rest, "fixed_base", robot.fixed_base);
  take(rest, "keyframe", robot.keyframe);
  require_format(urdf, rest, "packages", "URDF", path);
  require_format(urdf, rest, "fixed_base", "URDF", path);
  require_format(mjcf, rest, "keyframe", "MJCF", path);
  for (const char* name : {"packages", "fixed_base", "keyframe"})
    rest.attr("pop")(name, py::none());
  robot.scene = options_of(rest, "load");
  if (mjcf) return std::make_shared<Core>(load_mjcf_file(path, robot));
  const py::gil_scoped_release released;
  return std::make_shared<Core>(urdf ? load_urdf_file(path, std::move(robot))
                                     : load_scene(path, robot.scene));
}

CorePtr parse(const std::string& text, const py::kwargs& given) {
  py::kwargs rest(py::dict(given.attr("copy")()));
  auto format = SceneFormat::Json;
  take_word(rest, "format", {"json", "gltf"}, format);
  std::filesystem::path folder;
  take(rest, "folder", folder);
  for (const char* name : {"format", "folder"}) rest.attr("pop")(name, py::none());
  const SceneOptions options = options_of(rest, "parse");
  const py::gil_scoped_release released;
  return std::make_shared<Core>(format == SceneFormat::Gltf ? parse_gltf(text, folder, options)
                                                            : parse_scene(text, options));
}

Body find(Core& core, const std::string& name) {
  // "" would find the first body without a name.
  const BodyId id = name.empty() ? BodyId{} : core.file().find(name);
  if (!core.scene().world().contains(id)) {
    pbd::detail::refuse("Scene.find: name", "that of a body of the file that is still there",
                        "'" + name + "'");
  }
  return {core.shared_from_this(), id};
}

Joint find_joint(Core& core, const std::string& name) {
  const pbd::JointId id = name.empty() ? pbd::JointId{} : core.file().find_joint(name);
  if (!core.scene().joints().contains(id)) {
    pbd::detail::refuse("Scene.find_joint: name", "that of a joint of the file that is still there",
                        "'" + name + "'");
  }
  return {core.shared_from_this(), id};
}

/// In the file's order, each once; of existing objects.
template <class List, class Contains>
std::vector<std::string> names_in(const List& list, Contains&& contains) {
  std::vector<std::string> result;
  std::set<std::string> seen;
  for (const auto& one : list) {
    if (one.name.empty() || !seen.insert(one.name).second || !contains(one)) continue;
    result.push_back(one.name);
  }
  return result;
}

std::vector<std::string> names(Core& core) {
  const SceneFile& file = core.file();
  return names_in(file.bodies, [&](const SceneFile::Body& one) {
    return core.scene().world().contains(one.body);
  });
}

std::vector<std::string> joint_names(Core& core) {
  const SceneFile& file = core.file();
  return names_in(file.joints, [&](const SceneFile::Joint& one) {
    return core.scene().joints().contains(one.joint);
  });
}

Body add_text(Core& core, const std::string& text) {
  Access scene(core);
  core.require_room_for(1);
  SceneFile::Body added = tandem::add_body(*scene, text);
  const BodyId id = added.body;
  core.file().bodies.push_back(std::move(added));
  return {core.shared_from_this(), id};
}

std::string write(Core& core) {
  const Access scene(core);
  return write_scene(core.file());
}

/// Messages cite the file, which may not be UTF-8.
void translate(std::exception_ptr thrown) {
  try {
    std::rethrow_exception(std::move(thrown));
  } catch (const SceneFileError& error) {
    const std::string_view text = error.what();
    const auto size = static_cast<py::ssize_t>(text.size());
    const auto message = py::reinterpret_steal<py::object>(
        PyUnicode_DecodeUTF8(text.data(), size, "backslashreplace"));
    PyErr_SetObject(PyExc_ValueError, message.ptr());
  }
}

}  // namespace

void bind_files(SceneClass& scene) {
  py::register_local_exception_translator(&translate);
  scene.def_static("load", &load, py::arg("path"),
                   R"(A scene from a file, without the GIL unless it is MJCF.

Tandem's own format (docs/scene_files.md); glTF where it ends in .gltf or .glb, and, if the build has the
readers, URDF (.urdf) and MJCF (.xml, .mjcf). Keywords as of Scene(); gravity is the file's where that says
one. Of URDF also packages (folders by name, for meshes; "" is that of relative names, by default the file's
own folder) and fixed_base; of MJCF keyframe. What is wrong with it is a ValueError that names file, place in
it, rule and value; strangers' files may be read. Bodies keep their names: see find() and names.)");
  scene.def_static("parse", &parse, py::arg("text"),
                   R"(A scene from a text (str or bytes), as load() has it.

Keywords, beside those of Scene(): format ('json', 'gltf'), folder (of glTF, where its buffers may be files).

>>> import tandem
>>> scene = tandem.Scene.parse('''{"gravity": [0, 0, -10], "bodies": [
...   {"name": "ground", "type": "static", "shape": {"type": "halfSpace"}},
...   {"name": "cup", "shape": {"type": "sphere", "radius": 0.1}, "position": [0, 0, 0.5]}]}''')
>>> report = scene.step(1 / 60, steps=60)
>>> scene.names, round(float(scene.find("cup").position[2]), 3)
(['ground', 'cup'], 0.1)
>>> tandem.Scene.parse('{"bodies": [{"shape": {"type": "sphere", "radius": -1}}]}')
Traceback (most recent call last):
  ...
ValueError: scene: /bodies/0/shape: Sphere.radius must be > 0 and at most 1e6 m, is -1
)");
  scene.def("find", &find, py::arg("name"), "The first body of that name in the scene's file.");
  scene.def("find_joint", &find_joint, py::arg("name"), "The first joint of that name there.");
  scene.def_property_readonly("names", &names,
                              "of bodies of the scene's file that are still there, in its order");
  scene.def_property_readonly("joint_names", &joint_names, "of joints, likewise");
  scene.def_property_readonly(
      "warnings", [](Core& core) { return core.file().warnings; },
      "parts of the scene's file that the scene lacks, with their places");
  scene.def("add_text", &add_text, py::arg("text"),
            R"(Add a body as the format has it in "bodies"; find() knows its name.

>>> import tandem
>>> scene = tandem.Scene()
>>> ball = scene.add_text('{"name": "ball", "shape": {"type": "sphere", "radius": 0.5}, "mass": 2}')
>>> scene.find("ball") == ball, ball.mass
(True, 2.0)
)");
  scene.def("write", &write,
            R"(The scene as text of Tandem's format, with the names that it has.

What is made of it moves by the same bits as a scene that was made so; not in it are options and what the
solver carries from step to step. Rows other than joints, as ropes and cloth have them, are a ValueError.)");
}

}  // namespace tandem::python
