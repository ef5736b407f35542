#include <array>
#include <string>

#include "solver/rig/naming.h"
#include "solver/rig/nearest_name.h"
#include "solver/rig/option_reader.h"
#include "solver/rig/spine_system.h"
#include "solver/systems/curve_spine.h"
#include "solver/systems/even.h"
#include "solver/systems/isner.h"
#include "solver/systems/matrix_blend.h"
#include "solver/systems/neck.h"
#include "solver/systems/snake.h"
#include "solver/systems/spline_ik.h"
#include "solver/systems/stretchy.h"
#include "solver/systems/three_bone.h"

namespace backbend::solver {
namespace {

using Build = std::unique_ptr<SpineSystem> (*)(const SystemSpec&, const RestChain&);

struct Row {
  SystemInfo info;
  Build build;
};

// Every system backbend knows: one row each.
constexpr Row kSystems[] = {
    {{"three_bone", "three FK bones: the baseline"}, build_three_bone},
    {{"curve", "the thesis's curve spine: a chain on a curve behind three FK controls"},
     build_curve_spine},
    {{"isner", "the quaternion spine of Softimage's biped (an emulation)"}, build_isner},
    {{"even", "ours: every channel spread along the spine by smooth weights"}, build_even},
    {{"stretchy", "a Bezier between hip and chest that blends its length"}, build_stretchy},
    {{"neck", "one controller for a long neck's vertebrae"}, build_neck},
    {{"snake", "a body that slithers along a path by one channel"}, build_snake},
    {{"spline_ik", "bones laid along a spline, as in Blender or Maya (an emulation)"},
     build_spline_ik},
    {{"matrix_blend",
      "fractions of a control's turn for each joint, as in Rigify or mGear (an emulation)"},
     build_matrix_blend},
};

constexpr std::size_t kCount = std::size(kSystems);

constexpr auto kInfos = [] {
  std::array<SystemInfo, kCount> infos{};
  for (std::size_t i = 0; i < kCount; ++i) infos[i] = kSystems[i].info;
  return infos;
}();

/// Takes a naming template out of the options: every system has them, and none needs to know.
std::string take_template(SystemSpec& spec, const std::string& key) {
  const auto given = spec.options.find(key);
  if (given == spec.options.end()) return {};
  const auto* text = std::get_if<std::string>(&given->second);
  if (text == nullptr || text->empty()) {
    throw OptionError(key, spec.system + ": option '" + key +
                               "' must be text with {name} or {index}, such as \"hero_{name}\"");
  }
  std::string result = *text;
  spec.options.erase(given);
  return result;
}

}  // namespace

std::span<const SystemInfo> list_systems() { return kInfos; }

std::unique_ptr<SpineSystem> build_system(const SystemSpec& spec, const RestChain& chain) {
  for (const Row& row : kSystems) {
    if (row.info.name != spec.system) continue;
    SystemSpec own = spec;
    const Naming naming{take_template(own, "control_names"), take_template(own, "joint_names")};
    return name_system(row.build(own, chain), naming);
  }
  std::vector<std::string> known;
  for (const Row& row : kSystems) known.emplace_back(row.info.name);
  throw RigError("unknown system '" + spec.system + "'" + suggestion(spec.system, known));
}

}  // namespace backbend::solver
