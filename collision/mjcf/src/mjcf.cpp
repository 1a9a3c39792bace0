// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/mjcf.h"

#include <mujoco/mujoco.h>

#include <cstring>
#include <memory>

#include "mjcf_reader.h"
#include "read_bytes.h"
#include "schema_trim.h"
#include "xml_check.h"

namespace tandem {
namespace {

/// By default MuJoCo's error handler writes a file, waits for a key and ends the process.
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

/// Texts in memory, for MuJoCo.
class Files {
 public:
  explicit Files(const std::vector<mjcf::Document>& documents) {
    mj_defaultVFS(files_.get());
    for (const mjcf::Document& document : documents) {
      if (!document.changed) continue;
      const std::string& text = document.text;
      mj_makeEmptyFileVFS(files_.get(), document.file.c_str(), static_cast<int>(text.size()));
      const int at = mj_findFileVFS(files_.get(), document.file.c_str());
      if (at >= 0) std::memcpy(files_->filedata[at], text.data(), text.size());
    }
  }
  Files(const Files&) = delete;
  Files& operator=(const Files&) = delete;
  ~Files() { mj_deleteVFS(files_.get()); }
  const mjVFS* get() const { return files_->nfile > 0 ? files_.get() : nullptr; }

 private:
  std::unique_ptr<mjVFS> files_ = std::make_unique<mjVFS>();  // too large for the stack
};

using ModelPointer = std::unique_ptr<mjModel, void (*)(mjModel*)>;

/// Compiles repeatedly; each pass removes an element that the schema does not know.
ModelPointer compile(const std::string& path, std::vector<mjcf::Document>& documents, bool strict,
                     std::string_view name, std::vector<std::string>& warnings) {
  constexpr int kReadings = 64;
  bool autolimits = false;
  for (int i = 0;; ++i) {
    char error[1000] = "";
    const Files files(documents);
    ModelPointer model(mj_loadXML(path.c_str(), files.get(), error, sizeof error), mj_deleteModel);
    if (model) {
      if (error[0] != '\0') warnings.push_back(std::string("MuJoCo: ") + error);
      return model;
    }
    if (!strict && !autolimits && std::string_view(error).find("autolimits") != std::string::npos &&
        mjcf::set_autolimits(documents[0])) {
      autolimits = true;
      warnings.push_back("compiler: autolimits is on, as in later versions of MuJoCo");
      continue;
    }
    const auto unknown = mjcf::schema_violation(error);
    const std::size_t count =
        !strict && unknown && i < kReadings ? mjcf::blank_out(*unknown, documents) : 0;
    if (count == 0) {
      throw SceneFileError(pbd::detail::must_be(std::string(name) + ": text", "MJCF", error));
    }
    warnings.push_back("<" + unknown->element + ">: " + unknown->title() +
                       " is not accepted by MuJoCo " + mj_versionString() + ", and left out (" +
                       std::to_string(count) + " times)");
  }
}

SceneFile build(const std::string& path, std::vector<mjcf::Document> documents,
                const MjcfOptions& options, std::string_view name) {
  const ErrorsThrow errors_throw;
  std::vector<std::string> warnings;
  const ModelPointer model = compile(path, documents, options.strict, name, warnings);
  SceneOptions with = options.scene;
  const bool falls = (model->opt.disableflags & mjDSBL_GRAVITY) == 0;
  with.gravity = falls ? mjcf::vec(model->opt.gravity) : Vec3::Zero();
  try {
    SceneFile out{.scene = Scene(with)};
    out.warnings = std::move(warnings);
    mjcf::Reader(*model, out, options).run();
    return out;
  } catch (const std::invalid_argument& refused) {
    throw SceneFileError(std::string(name) + ": " + refused.what());
  }
}

}  // namespace

SceneFile load_mjcf(const std::filesystem::path& path, const MjcfOptions& options) {
  std::vector<mjcf::Document> documents{
      {.file = path.filename().string(), .text = scene_files::read_bytes(path)}};
  scene_files::check_xml(documents[0].text, path.string());
  if (!options.strict) mjcf::append_includes(path.parent_path(), documents);
  return build(path.string(), std::move(documents), options, path.string());
}

SceneFile parse_mjcf(std::string_view text, const MjcfOptions& options, std::string_view name) {
  scene_files::check_xml(text, name);
  scene_files::refuse_files(text, name);
  if (text.empty()) {
    throw SceneFileError(pbd::detail::must_be(std::string(name) + ": text", "not empty"));
  }
  return build("model.xml", {{.file = "model.xml", .text = std::string(text), .changed = true}},
               options, name);
}

}  // namespace tandem
