#include "cli/external_options.h"

#include "cli/settings.h"
#include "validate/sweeps/external_spec.h"

namespace backbend::cli {

using namespace backbend::validate;

void ExternalOptions::add_to(CLI::App* command) {
  command
      ->add_option("--map", map,
                   "of your own rig: which controls stand for which channel, JSON, or one of the "
                   "presets rigify, spline_ik and b_bone [the sidecar's]")
      ->type_name(kFileType);
  command
      ->add_option("--servers", servers,
                   "of your own rig: programs that are asked side by side [1]")
      ->check(CLI::Range(1, 64));
}

void ExternalOptions::apply_to(std::vector<RigPlan*> rigs) const {
  bool any = false;
  for (RigPlan* rig : rigs) {
    if (!is_external(rig->spec)) continue;
    any = true;
    if (!map.empty()) rig->spec.options["map"] = map;
    if (servers > 0) rig->spec.options["servers"] = static_cast<double>(servers);
  }
  if (!any && !map.empty())
    throw CLI::ValidationError(
        "--map: only for a rig of your own, blender:FILE, maya:FILE or "
        "command:\"PROGRAM ARGS\"");
}

RigPlan ExternalOptions::read_rig(const std::string& text) const {
  RigPlan plan = validate::read_rig(text);
  apply_to({&plan});
  return plan;
}

}  // namespace backbend::cli
