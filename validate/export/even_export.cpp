#include "validate/export/even_export.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <set>

#include "skin/anatomy/driven_nodes.h"
#include "skin/character/matrix_facts.h"
#include "validate/judge/confirmed.h"

namespace backbend::validate {
namespace {

using Index = std::size_t;
using skin::Anatomy;
using skin::Character;

constexpr double kMostDistance =
    3e-4;                     // of the spine: leaves room below the 0.05 % that we promise
constexpr int kPoses = 2000;  // that it is measured at

/// Where the character's spine joints stand, those in one place once.
std::vector<double> places_of(const std::vector<double>& fraction, std::vector<Index>& index) {
  constexpr double kSamePlace = 1e-6;  // of the spine: SpineDriver joins what is no farther apart
  std::vector<double> out;
  for (const double s : fraction) {
    if (out.empty() || s - out.back() > kSamePlace) out.push_back(s);
    index.push_back(out.size() - 1);
  }
  out.back() = 1.0;
  return out;
}

/// What a joint goes with: a spine joint by its index, or one of these.
constexpr int kNothing = -1, kHips = 0;  // neither moves in `even`

/// Of each node by the file's own hierarchy alone.
std::vector<int> carried_by_parents(const Character& character, const Anatomy& anatomy) {
  std::vector<int> out(character.nodes.size(), kNothing);
  for (Index n = 0; n < out.size(); ++n) {  // parents stand before their children
    const int parent = character.nodes[n].parent;
    if (parent >= 0) out[n] = out[static_cast<Index>(parent)];
    for (Index k = 0; k <= anatomy.chest_index; ++k)
      if (anatomy.spine[k] == static_cast<int>(n)) out[n] = static_cast<int>(k);
  }
  return out;
}

void find_followers(const Character& character, const Anatomy& anatomy, EvenExport& out) {
  const std::vector<int> carried = carried_by_parents(character, anatomy);
  const auto name = [&](int node) { return character.nodes[static_cast<Index>(node)].name; };
  const auto spine_index = [&](int node) {
    const auto end = anatomy.spine.begin() + static_cast<std::ptrdiff_t>(anatomy.chest_index) + 1;
    const auto at = std::find(anatomy.spine.begin(), end, node);
    return at == end ? kNothing : static_cast<int>(at - anatomy.spine.begin());
  };
  std::set<int> done, apart;
  const auto add = [&](const skin::DrivenNode& each) {
    if (done.insert(each.node).second)
      out.followers.push_back({name(each.node), name(each.leader)});
  };
  std::vector<skin::DrivenNode> nodes = skin::driven_nodes(character, anatomy);
  std::erase_if(nodes, [](const skin::DrivenNode& each) { return each.leader < 0; });
  for (const std::vector<int>* arm : {&anatomy.left_arm, &anatomy.right_arm})
    for (const skin::DrivenNode& each : nodes)
      if (!arm->empty() && each.node == arm->front()) add(each);
  for (const skin::DrivenNode& each : nodes) {
    const int parent = character.nodes[static_cast<Index>(each.node)].parent;
    const int now = carried[static_cast<Index>(each.node)];
    if (parent >= 0 && done.contains(parent)) done.insert(each.node);  // comes along
    const int leader = spine_index(each.leader);
    if (leader <= kHips || now == leader || done.contains(each.node)) continue;
    if (parent < 0)
      add(each);
    else if (apart.insert(each.node).second && !apart.contains(parent))
      out.apart.push_back(name(each.node));
  }
}

/// Half the edge of a square that goes around the torso at a control: 95 of 100 of its vertices
/// within an eighth of the spine are inside. Half the control's bone where there are none.
double half_size_at(const Character& character, const std::vector<skin::Region>& region,
                    const solver::EvenGraph::Control& control, double length) {
  std::vector<double> beside;
  for (Index v = 0; v < character.vertex_count(); ++v) {
    if (region[v] != skin::Region::torso) continue;
    const glm::dvec3 off =
        glm::transpose(control.axes) * (glm::dvec3(character.bind_position[v]) - control.place);
    if (std::abs(off.x) <= length / 8.0)
      beside.push_back(std::max(std::abs(off.y), std::abs(off.z)));
  }
  if (beside.empty()) return 0.5 * control.bone;
  const auto nth = beside.begin() + static_cast<std::ptrdiff_t>(0.95 * double(beside.size() - 1));
  std::nth_element(beside.begin(), nth, beside.end());
  return 1.1 * *nth;
}

}  // namespace

EvenExport export_even(const std::filesystem::path& file, const skin::AnatomyHints& hints,
                       const solver::SystemSpec& rig) {
  solver::check_has_graph(rig);
  const ConfirmedCharacter confirmed = load_confirmed(file, hints);
  const Character& character = confirmed.character;
  const Anatomy anatomy = skin::find_anatomy(character, confirmed.hints);
  const skin::SpineDriver driver(character, anatomy);

  EvenExport out;
  out.character = character.file_name;
  out.rig = rig;
  std::vector<Index> index;
  if (out.rig.options.contains("joints"))
    throw solver::RigError(
        "even: option 'joints' cannot be exported: it is those of the character");
  out.rig.options["joints"] = places_of(driver.joint_fractions(), index);
  out.graph =
      solver::even_graph_within(out.rig, driver.rest_chain(), kMostDistance, kPoses, out.distance);
  for (Index k = 0; k <= anatomy.chest_index; ++k) {
    const skin::Node& node = character.nodes[static_cast<Index>(anatomy.spine[k])];
    EvenExport::Joint joint{node.name, index[k], node.world_from_node};
    if (k == 0)
      out.hips = std::move(joint);
    else
      out.joints.push_back(std::move(joint));
  }
  out.left = driver.rest_chain().left;
  find_followers(character, anatomy, out);
  const std::vector<skin::Region> region = skin::vertex_regions(character, anatomy);
  for (Index k = 0; k < 3; ++k)
    out.half_size[k] = half_size_at(character, region, out.graph.control[k], out.graph.length);
  return out;
}

}  // namespace backbend::validate
