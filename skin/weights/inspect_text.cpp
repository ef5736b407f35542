#include <algorithm>
#include <cmath>

#include "skin/anatomy/anatomy_hints.h"
#include "skin/anatomy/driver_coverage.h"
#include "skin/anatomy/skeleton_shape.h"
#include "skin/character/printable.h"
#include "skin/weights/inspect.h"
#include "skin/weights/weight_faults.h"
#include "skin/weights/weight_hygiene.h"

namespace backbend::skin {
namespace {

using Index = std::size_t;

std::string name(const Character& character, int node) {
  return printable(character.nodes[static_cast<Index>(node)].name);
}

std::string chain_text(const Character& character, const std::vector<int>& chain) {
  std::string out;
  for (const int node : chain)
    out += (out.empty() ? "" : " > ") + printable(reference_name(character, node));
  return out.empty() ? "none" : out;
}

/// The first few names of a list.
std::string some_names(const Character& character, const std::vector<int>& nodes) {
  constexpr Index kMost = 8;
  std::string out;
  for (Index k = 0; k < nodes.size() && k < kMost; ++k)
    out += (k == 0 ? "" : ", ") + name(character, nodes[k]);
  return nodes.size() > kMost ? out + " and " + std::to_string(nodes.size() - kMost) + " more"
                              : out;
}

std::string percent(double share) {
  return number_text(std::round(1000.0 * share) / 10.0, 3) + " %";
}

std::string axis_text(const glm::dvec3& v) {
  for (int axis = 0; axis < 3; ++axis)
    if (std::abs(v[axis]) > 1.0 - 1e-9)
      return std::string(v[axis] > 0.0 ? "+" : "-") + static_cast<char>('X' + axis);
  return "(" + number_text(v.x, 3) + ", " + number_text(v.y, 3) + ", " + number_text(v.z, 3) + ")";
}

/// Lines of `label  text`, the label once.
class Lines {
 public:
  void add(const std::string& label, const std::string& text) {
    const std::string head = label == last_ ? "" : label;
    last_ = label;
    text_ += "  " + head + std::string(head.size() < 9 ? 9 - head.size() : 1, ' ') + text + "\n";
  }
  void raw(const std::string& line) { text_ += line + "\n"; }
  std::string take() {
    if (!text_.empty()) text_.pop_back();  // no line break at the end
    return std::move(text_);
  }

 private:
  std::string text_, last_;
};

void add_body(const Character& character, const Anatomy& anatomy, Lines& out) {
  if (character.vertex_count() == 0)
    out.add("body", "a skeleton alone: " + plural(character.joints.size(), "joint"));
  else
    out.add("body", plural(character.parts.size(), "part") + ", " +
                        count_text(character.vertex_count()) + " vertices at " +
                        count_text(character.place_count) + " places, " +
                        plural(character.triangles.size(), "triangle") + ", " +
                        plural(character.joints.size(), "joint"));
  const std::string height =
      character.vertex_count() == 0 ? "" : "height " + number_text(anatomy.height) + ", ";
  out.add("size", height + "spine " + number_text(anatomy.spine_length) +
                      " (reference length), in the file's unit");
  out.add("axes", "up " + axis_text(anatomy.up) + ", faces " + axis_text(anatomy.forward) +
                      ", its left " + axis_text(anatomy.left));
}

void add_anatomy(const Character& character, const Anatomy& anatomy, Lines& out) {
  out.add("spine",
          chain_text(character, anatomy.spine) + (anatomy.sure() ? "   sure" : "   uncertain"));
  for (const std::string& doubt : anatomy.doubts) out.add("doubt", doubt);
  const int end = anatomy.spine[anatomy.chest_index];
  out.add("chest", anatomy.chest < 0 ? "none told by arms; driven to " + name(character, end)
                   : anatomy.chest == end
                       ? name(character, end)
                       : name(character, anatomy.chest) + "; driven on to " + name(character, end));
  out.add("arms", chain_text(character, anatomy.left_arm));
  out.add("arms", chain_text(character, anatomy.right_arm));
  out.add("legs", chain_text(character, anatomy.left_leg));
  out.add("legs", chain_text(character, anatomy.right_leg));
  if (!anatomy.tail.empty()) out.add("tail", chain_text(character, anatomy.tail));
  for (const std::string& reason : anatomy.reasons) out.add("why", reason);
}

void add_driven(const Character& character, const Anatomy& anatomy, Lines& out) {
  const SpineDriver driver(character, anatomy);
  std::string joints;
  for (Index k = 0; k <= anatomy.chest_index; ++k)
    joints += (k == 0 ? "" : ", ") + name(character, anatomy.spine[k]) + " " +
              number_text(driver.joint_fractions()[k], 2);
  out.add("driven", "by arc fraction: " + joints);
  if (!anatomy.left_arm.empty() || !anatomy.right_arm.empty())
    out.add("driven", driver.arms_follow_chest()
                          ? "arms go with the chest, which they hang from"
                          : "arms ride on the spine where they start, below its top");
  for (const std::string& line : coverage_lines(character, driver_coverage(character, anatomy)))
    out.add("driven", line);
}

void add_weights(const Character& character, const Anatomy& anatomy, Lines& out) {
  const WeightHygiene weights = judge_weights(character, anatomy);
  std::string by_count;
  for (Index n = 1; n < weights.with_influences.size(); ++n)
    if (weights.with_influences[n] > 0)
      by_count += (by_count.empty() ? "" : ", ") + count_text(weights.with_influences[n]) + " by " +
                  std::to_string(n);
  out.add("weights", "vertices moved " + by_count + " joints");
  out.add("weights",
          "sums: " + (weights.off_sum == 0 ? std::string("all 1")
                                           : count_text(weights.off_sum) + " vertices off, worst " +
                                                 number_text(weights.worst_sum)));
  out.add("weights", "unweighted: " + count_text(weights.unweighted) + ", tiny (below " +
                         number_text(kTinyWeight, 2) + "): " + count_text(weights.tiny) +
                         ", more than 4 joints: " + count_text(weights.more_than_four));
  std::string symmetry = percent(weights.mirrored_share) + " of places have a mirror image";
  if (weights.mirrored_share > 0.0)
    symmetry +=
        ", " + count_text(weights.asymmetric) + " of them weighted differently by over 5 %" +
        (weights.asymmetric == 0 ? ""
                                 : " (worst " + percent(weights.worst_asymmetry) + ", vertex " +
                                       std::to_string(weights.worst_asymmetric_vertex) + ")");
  out.add("weights", "symmetry: " + symmetry);
  for (const std::string& line : weight_fault_lines(character, anatomy)) out.add("weights", line);
  if (weights.bleed.empty()) return out.add("weights", "bleed: none");
  constexpr Index kMost = 6;
  std::vector<Bleed> worst = weights.bleed;
  std::stable_sort(worst.begin(), worst.end(),
                   [](const Bleed& a, const Bleed& b) { return a.largest > b.largest; });
  for (Index k = 0; k < worst.size() && k < kMost; ++k)
    out.add("weights", "bleed: " + name(character, worst[k].node) + " weighs " +
                           plural(worst[k].places, "place") + " apart from its area (largest " +
                           number_text(worst[k].largest, 2) + ", vertex " +
                           std::to_string(worst[k].vertex) + ")");
  if (worst.size() > kMost)
    out.add("weights", "bleed: " + plural(worst.size() - kMost, "joint") + " more, see --json");
}

/// What a node is in the anatomy, for the tree.
std::vector<std::string> marks(const Character& character, const Anatomy& anatomy) {
  std::vector<std::string> out(character.nodes.size());
  const auto mark = [&](const std::vector<int>& chain, const char* text) {
    for (const int node : chain) out[static_cast<Index>(node)] = text;
  };
  mark(anatomy.tail, "tail");
  mark(anatomy.left_leg, "leg L");
  mark(anatomy.right_leg, "leg R");
  mark(anatomy.left_arm, "arm L");
  mark(anatomy.right_arm, "arm R");
  mark(anatomy.spine, "spine");
  out[static_cast<Index>(anatomy.spine.front())] = "hips";
  if (anatomy.chest >= 0) out[static_cast<Index>(anatomy.chest)] = "chest";
  if (anatomy.head >= 0) out[static_cast<Index>(anatomy.head)] = "head";
  return out;
}

void add_tree(const Character& character, const Anatomy& anatomy, Lines& out) {
  const SkeletonShape shape = measure_skeleton(character);
  const auto mark = marks(character, anatomy);
  out.raw(character.vertex_count() == 0 ? "  skeleton" : "  skeleton (weight in vertices)");
  // Depth first, whatever the nodes' order: each branch stands below its own parent.
  std::vector<std::vector<Index>> children(character.nodes.size() + 1);
  for (Index n = character.nodes.size(); n-- > 0;)
    children[static_cast<Index>(character.nodes[n].parent + 1)].push_back(n);
  std::vector<int> depth(character.nodes.size(), 0);
  std::vector<Index> left = children.front();  // the next one last
  while (!left.empty()) {
    const Index n = left.back();
    left.pop_back();
    for (const Index child : children[n + 1]) {
      depth[child] = depth[n] + 1;
      left.push_back(child);
    }
    const bool used = shape.is_joint[n] || shape.weight_below[n] > 0.0;
    if (!used) continue;
    std::string line(static_cast<Index>(4 + 2 * std::min(depth[n], 40)), ' ');
    line += name(character, static_cast<int>(n));
    if (!mark[n].empty()) line += "  [" + mark[n] + "]";
    line += shape.weight[n] > 0.0 ? "  " + number_text(std::round(10.0 * shape.weight[n]) / 10.0, 6)
            : shape.is_joint[n]   ? (character.vertex_count() == 0 ? "" : "  -")
                                  : "  (no joint)";
    out.raw(line);
  }
}

}  // namespace

std::vector<std::string> coverage_lines(const Character& character,
                                        const DriverCoverage& coverage) {
  std::vector<std::string> out;
  if (!coverage.helpers.empty())
    out.push_back(
        plural(coverage.helpers.size(), "helper joint") + ", " + percent(coverage.helper_share) +
        " of torso weight, that go with their parents: " + some_names(character, coverage.helpers));
  if (!coverage.unreached.empty())
    out.push_back(
        plural(coverage.unreached.size(), "joint") + ", " + percent(coverage.unreached_share) +
        " of all weight, that nothing moves: " + some_names(character, coverage.unreached));
  return out;
}

std::string inspect_text(const Character& character, const Anatomy& anatomy) {
  Lines out;
  out.raw(printable(character.file_name));
  add_body(character, anatomy, out);
  add_anatomy(character, anatomy, out);
  add_driven(character, anatomy, out);
  if (character.vertex_count() > 0) add_weights(character, anatomy, out);
  for (const Warning& warning : character.warnings)
    out.add("warning", warning.code + ": " + warning.message);
  add_tree(character, anatomy, out);
  return out.take();
}

}  // namespace backbend::skin
