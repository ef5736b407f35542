#include "skin/anatomy/driven_nodes.h"

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "skin/anatomy/driver_coverage.h"
#include "skin/character/matrix_facts.h"
#include "skin/character/printable.h"
#include "solver/rig/spine_system.h"

namespace backbend::skin {
namespace {

using Index = std::size_t;

/// Every channel at once, so that no two places of the body move alike by chance.
constexpr solver::BodyPose kProbe{0.7, 0.0, 0.2, 0.4, 0.3, 1.0};

std::vector<glm::dmat4> motions(const Character& character, const SpineDriver& driver) {
  const std::unique_ptr<solver::SpineSystem> system =
      solver::build_system({"even", {}}, driver.rest_chain());
  const std::vector<glm::dmat4> posed =
      driver.drive(*system, system->solve(system->controls_for(kProbe, solver::Mapping::chest)));
  std::vector<glm::dmat4> out;
  for (Index n = 0; n < posed.size(); ++n)
    out.push_back(posed[n] * glm::inverse(character.nodes[n].world_from_node));
  return out;
}

/// Whether two motions take the body's extent to the same place, but for rounding.
bool same(const glm::dmat4& a, const glm::dmat4& b, double size) {
  constexpr double kRounding = 1e-9;
  return same_motion(a, b, kRounding, std::max(size, 1.0));
}

/// Share of the torso's weight of each node.
std::vector<double> torso_weights(const Character& character, const Anatomy& anatomy) {
  std::vector<double> share(character.nodes.size(), 0.0);
  if (character.vertex_count() == 0) return share;
  const std::vector<Region> region = vertex_regions(character, anatomy);
  double whole = 0.0;
  for (Index v = 0; v < character.influences.size(); ++v) {
    if (region[v] != Region::torso) continue;
    for (int k = 0; k < kMaxInfluences; ++k) {
      const float weight = character.influences[v].weight[static_cast<Index>(k)];
      if (weight <= 0.0f) continue;
      const Index joint = character.influences[v].joint[static_cast<Index>(k)];
      share[static_cast<Index>(character.joints[joint].node)] += weight;
      whole += weight;
    }
  }
  for (double& each : share) each = whole > 0.0 ? each / whole : 0.0;
  return share;
}

const char* word(DrivenNode::Kind kind) {
  switch (kind) {
    case DrivenNode::Kind::driven:
      return "driven";
    case DrivenNode::Kind::follows:
      return "follows";
    case DrivenNode::Kind::rides:
      return "rides";
    case DrivenNode::Kind::still:
      return "still";
  }
  return "still";
}

}  // namespace

std::vector<DrivenNode> driven_nodes(const Character& character, const Anatomy& anatomy) {
  const SpineDriver driver(character, anatomy);
  const std::vector<glm::dmat4> motion = motions(character, driver);
  // Hips that no channel moves stand as still as a prop, and yet carry the legs.
  const std::vector<bool> still = driver.static_nodes();
  std::vector<bool> shown(character.nodes.size(), false);
  for (const SkinJoint& joint : character.joints) shown[static_cast<Index>(joint.node)] = true;
  for (const int node : anatomy.spine) shown[static_cast<Index>(node)] = true;
  const auto driven_end =
      anatomy.spine.begin() + static_cast<std::ptrdiff_t>(anatomy.chest_index) + 1;
  const std::vector<double> weight = torso_weights(character, anatomy);
  const DriverCoverage coverage = driver_coverage(character, anatomy);
  std::vector<DrivenNode> out;
  for (Index n = 0; n < character.nodes.size(); ++n) {
    if (!shown[n]) continue;
    DrivenNode entry;
    entry.node = static_cast<int>(n);
    if (std::find(anatomy.spine.begin(), driven_end, entry.node) != driven_end) {
      entry.kind = DrivenNode::Kind::driven;
      out.push_back(entry);
      continue;
    }
    if (still[n]) {
      out.push_back(entry);
      continue;
    }
    // The nearest joint above that moves alike and is driven; any other driven one else.
    for (int up = character.nodes[n].parent; up >= 0 && entry.leader < 0;
         up = character.nodes[static_cast<Index>(up)].parent)
      if (std::find(anatomy.spine.begin(), driven_end, up) != driven_end &&
          same(motion[n], motion[static_cast<Index>(up)], anatomy.height))
        entry.leader = up;
    for (auto joint = anatomy.spine.begin(); joint != driven_end && entry.leader < 0; ++joint)
      if (same(motion[n], motion[static_cast<Index>(*joint)], anatomy.height))
        entry.leader = *joint;
    entry.kind = entry.leader >= 0 ? DrivenNode::Kind::follows : DrivenNode::Kind::rides;
    if (std::ranges::find(coverage.helpers, entry.node) != coverage.helpers.end())
      entry.torso_weight = weight[n];
    out.push_back(entry);
  }
  return out;
}

std::string driven_text(const Character& character, const std::vector<DrivenNode>& nodes) {
  const auto count = [&](DrivenNode::Kind kind) {
    return static_cast<Index>(std::ranges::count(nodes, kind, &DrivenNode::kind));
  };
  std::string out = printable(character.file_name) + ": " +
                    plural(count(DrivenNode::Kind::driven), "joint") + " driven, " +
                    std::to_string(count(DrivenNode::Kind::follows)) + " following, " +
                    std::to_string(count(DrivenNode::Kind::rides)) + " riding between joints, " +
                    std::to_string(count(DrivenNode::Kind::still)) + " still";
  Index width = 0;
  const auto name = [&](int node) {
    return printable(character.nodes[static_cast<Index>(node)].name);
  };
  for (const DrivenNode& each : nodes) width = std::max(width, name(each.node).size());
  for (const DrivenNode& each : nodes) {
    const std::string joint = name(each.node);
    out += "\n  " + joint + std::string(width - joint.size() + 2, ' ') + word(each.kind);
    if (each.leader >= 0) out += " " + name(each.leader);
    if (each.torso_weight > 0.0)
      out += "   helper: " + number_text(100.0 * each.torso_weight, 2) +
             " % of the torso's weight, and your own rig may move it";
  }
  return out;
}

std::string driven_json(const Character& character, const std::vector<DrivenNode>& nodes) {
  nlohmann::json joints = nlohmann::json::array();
  const auto name = [&](int node) {
    return printable(character.nodes[static_cast<Index>(node)].name);
  };
  for (const DrivenNode& each : nodes) {
    nlohmann::json entry = {{"name", name(each.node)},
                            {"motion", word(each.kind)},
                            {"torso_weight", each.torso_weight}};
    entry["leader"] = each.leader < 0 ? nlohmann::json(nullptr) : nlohmann::json(name(each.leader));
    joints.push_back(std::move(entry));
  }
  return nlohmann::json{{"schema", "backbend.driven/1"},
                        {"file", printable(character.file_name)},
                        {"joints", std::move(joints)}}
      .dump(2, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace backbend::skin
