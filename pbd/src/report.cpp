// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/pbd/report.h"

#include <ostream>
#include <sstream>
#include <utility>

namespace tandem::pbd {
namespace {

/// Names, separated into used and unused ones.
class Lists {
 public:
  void add(std::string_view name, bool used) {
    std::string& list = used ? used_ : unused_;
    if (!list.empty()) list += ", ";
    list += name;
  }
  void write(std::string_view title, std::ostream& out) const {
    out << title << ": " << (used_.empty() ? "none" : used_);
    if (!unused_.empty()) out << "; left out: " << unused_;
    out << "\n";
  }

 private:
  std::string used_, unused_;
};

}  // namespace

std::string describe(const StepReport& report) {
  Lists stages;
  for (std::size_t i = 0; i < kStageNames.size(); ++i) stages.add(kStageNames[i], report.ran[i]);
  const StepParts& p = report.parts;
  Lists parts;
  for (const auto& [name, used] : {std::pair<std::string_view, bool>{"contacts", p.contacts},
                                   {"friction", p.friction},
                                   {"restitution", p.restitution},
                                   {"joints", p.joints},
                                   {"rotation", p.rotation},
                                   {"sleep", p.sleep},
                                   {"refinement", p.refinement},
                                   {"targets", p.targets}}) {
    parts.add(name, used);
  }
  std::ostringstream text;
  stages.write("stages", text);
  parts.write("parts", text);
  text << "rows:";
  for (const BlockReport& block : report.blocks) text << " " << block.name << " " << block.rows;
  if (report.blocks.empty()) text << " none";
  text << "\nbodies: " << report.bodies << ", " << report.awake << " awake, " << report.turning
       << " turning; substeps " << report.substeps << ", threads " << report.threads << "\n";
  return text.str();
}

}  // namespace tandem::pbd
