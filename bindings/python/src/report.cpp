// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "report.h"

#include <cmath>
#include <string>

#include "tandem/pbd/validate.h"

namespace tandem::python {
namespace {

const char* status_name(const Report& r) {
  constexpr const char* kNames[] = {"ok", "non-finite", "invalid-step"};
  return kNames[static_cast<int>(r.report.status)];
}

py::dict blocks(const Report& r) {
  py::dict result;
  for (const pbd::BlockReport& block : r.report.blocks) {
    result[py::str(std::string(block.name))] = py::make_tuple(block.rows, block.residual);
  }
  return result;
}

py::dict stages(const Report& r) {
  py::dict result;
  for (std::size_t i = 0; i < r.report.stage_s.size(); ++i) {
    result[py::str(std::string(pbd::kStageNames[i]))] = r.report.stage_s[i];
  }
  return result;
}

}  // namespace

void require_steps(double dt, int steps) {
  if (!(std::isfinite(dt) && dt > 0.0)) pbd::detail::refuse("dt", "finite and > 0", dt);
  if (steps < 1) pbd::detail::refuse("steps", "at least 1", static_cast<double>(steps));
}

void bind_report(py::module_& m) {
  py::class_<Report>(m, "StepReport", R"(What a step did.

>>> import tandem
>>> scene = tandem.Scene()
>>> ball = scene.add(tandem.Sphere(0.1))
>>> report = scene.step(1 / 60)
>>> report.status, report.bodies, report.awake
('ok', 1, 1)
)")
      .def_property_readonly("status", &status_name,
                             "'ok', 'non-finite' (a body was put back, at rest) or 'invalid-step'")
      .def_property_readonly(
          "substeps", [](const Report& r) { return r.report.substeps; },
          "of the group that had most")
      .def_property_readonly("bodies", [](const Report& r) { return r.report.bodies; })
      .def_property_readonly(
          "awake", [](const Report& r) { return r.report.awake; }, "bodies that were solved")
      .def_property_readonly(
          "stopped", [](const Report& r) { return r.report.stopped; },
          "bodies that would have got through something")
      .def_property_readonly("blocks", &blocks,
                             "name: (rows, largest violation of a rigid row in m)")
      .def_property_readonly("stages", &stages, "name: wall time, s")
      .def_readonly("time", &Report::time, "s, of the scene, after the step")
      .def("__repr__", [](const Report& r) { return pbd::describe(r.report); });
}

}  // namespace tandem::python
