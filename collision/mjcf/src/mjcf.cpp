// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/mjcf.h"

#include <mujoco/mujoco.h>

#include <cstring>
#include <memory>

#include "mjcf_reader.h"
#include "read_bytes.h"
#include "xml_check.h"

namespace tandem {
namespace {

/// MuJoCo's own answer to an error is to write a file, wait for a key and end the process.
class ErrorsThrow {
 public:
  ErrorsThrow() {
    mju_user_error = [](const char* text) { throw SceneFileError(std::string("MuJoCo: ") + text); };
    mju_user_warning = [](const char*) {};
  }
  ErrorsThrow(const ErrorsThrow&) = delete;
  ErrorsThrow& operator=(const ErrorsThrow&) = delete;
  ~ErrorsThrow() {
    mju_user_error = error_;
    mju_user_warning = warning_;
  }

 private:
  void (*error_)(const char*) = mju_user_error;
  void (*warning_)(const char*) = mju_user_warning;
};

SceneFile build(const std::string& path, const mjVFS* files, const MjcfOptions& options,
                std::string_view name) {
  char error[1000] = "";
  const ErrorsThrow errors_throw;
  const std::unique_ptr<mjModel, void (*)(mjModel*)> model(
      mj_loadXML(path.c_str(), files, error, sizeof error), mj_deleteModel);
  const std::string file(name);
  if (!model) throw SceneFileError(pbd::detail::must_be(file + ": text", "MJCF", error));
  SceneOptions with = options.scene;
  const bool falls = (model->opt.disableflags & mjDSBL_GRAVITY) == 0;
  with.gravity = falls ? mjcf::vec(model->opt.gravity) : Vec3::Zero();
  try {
    SceneFile out{.scene = Scene(with)};
    if (error[0] != '\0') out.warnings.push_back(std::string("MuJoCo: ") + error);
    mjcf::Reader(*model, out, options).run();
    return out;
  } catch (const std::invalid_argument& refused) {
    throw SceneFileError(file + ": " + refused.what());
  }
}

}  // namespace

SceneFile load_mjcf(const std::filesystem::path& path, const MjcfOptions& options) {
  scene_files::check_xml(scene_files::read_bytes(path), path.string());
  return build(path.string(), nullptr, options, path.string());
}

SceneFile parse_mjcf(std::string_view text, const MjcfOptions& options, std::string_view name) {
  scene_files::check_xml(text, name);
  scene_files::refuse_files(text, name);
  if (text.empty()) {
    throw SceneFileError(pbd::detail::must_be(std::string(name) + ": text", "not empty"));
  }
  const auto files = std::make_unique<mjVFS>();  // too large for a stack
  mj_defaultVFS(files.get());
  mj_makeEmptyFileVFS(files.get(), "model.xml", static_cast<int>(text.size()));
  const std::unique_ptr<mjVFS, void (*)(mjVFS*)> closing(files.get(), mj_deleteVFS);
  std::memcpy(files->filedata[0], text.data(), text.size());
  return build("model.xml", files.get(), options, name);
}

}  // namespace tandem
