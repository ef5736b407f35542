#include "validate/prove/proof_text.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "validate/prove/proof_map.h"
#include "validate/sweeps/suite.h"
#include "validate/text/json_object.h"

namespace backbend::validate {
namespace {

using nlohmann::ordered_json;

ProofMap map_of(const Certificate& proof, std::size_t columns) {
  ProofMap map(proof.question.box, columns);
  each_leaf(proof.tree, proof.question.box, [&](const SubBox& leaf, const ProofNode& node) {
    if (node.state == BoxState::certified) return;
    const bool refuted = node.state == BoxState::refuted || node.state == BoxState::steep;
    map.mark(leaf, refuted ? ProofMap::kRefuted : ProofMap::kOpen);
  });
  return map;
}

std::string plural(std::uint64_t count, const std::string& one, const std::string& many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

std::string unit_of(const ProofBox& box, const solver::SpineSystem& system, int axis) {
  for (const solver::Channel& c : system.channels()) {
    if (box.of_controls && c.name == box.axis[std::size_t(axis)].channel &&
        c.kind != solver::Channel::Kind::rotation)
      return "deg per unit";
  }
  return "deg/deg";
}

/// The boxes that are open, largest first.
std::vector<SubBox> open_boxes(const Certificate& proof) {
  std::vector<SubBox> open;
  each_leaf(proof.tree, proof.question.box, [&](const SubBox& leaf, const ProofNode& node) {
    if (node.state == BoxState::open || node.state == BoxState::smooth ||
        node.state == BoxState::pending)
      open.push_back(leaf);
  });
  const auto size = [&](const SubBox& b) { return share_of(b, proof.question.box); };
  std::stable_sort(open.begin(), open.end(),
                   [&](const SubBox& a, const SubBox& b) { return size(a) > size(b); });
  return open;
}

/// Without those that show what one before them shows: boxes that touch find the same pose.
std::vector<Refutation> distinct(const std::vector<Refutation>& all) {
  constexpr double kSame = 1e-3;  // of a channel's unit
  constexpr std::size_t kCompared = 50;
  std::vector<Refutation> kept;
  for (const Refutation& r : all) {
    const auto end = kept.begin() + std::ptrdiff_t(std::min(kept.size(), kCompared));
    const bool known = std::any_of(kept.begin(), end, [&](const Refutation& k) {
      bool near = k.check == r.check && k.joint == r.joint;
      for (std::size_t j = 0; j < kProofAxes; ++j)
        near = near && std::abs(k.pose[j] - r.pose[j]) < kSame;
      return near;
    });
    if (!known) kept.push_back(r);
  }
  return kept;
}

std::string box_text(const ProofBox& whole, const SubBox& part) {
  std::string text;
  for (std::size_t j = 0; j < whole.axis.size(); ++j) {
    if (!whole.axis[j].varies()) continue;
    text += (text.empty() ? "" : ", ") + whole.axis[j].channel + " " + number_text(part.low[j], 4) +
            ".." + number_text(part.high[j], 4);
  }
  return text;
}

}  // namespace

std::string bound_text(double bound) {
  constexpr int kDecimals = 9;
  return number_text(std::ceil(bound * 1e9) * 1e-9, kDecimals);
}

std::vector<Refutation> worst_first(const ProofTree& tree) {
  std::vector<Refutation> worst = tree.refutation;
  std::stable_sort(worst.begin(), worst.end(), [](const Refutation& a, const Refutation& b) {
    if (a.check != b.check) return a.check < b.check;
    return a.value > b.value;
  });
  return worst;
}

std::string proof_text(const Certificate& proof, const solver::SpineSystem& system,
                       const TerminalStyle& style) {
  constexpr std::size_t kShown = 5;
  const ProofQuestion& q = proof.question;
  const ProofShares shares = shares_of(proof.tree, q.box);
  std::string text = rig_text(q.rig) + ", mapping " + std::string(mapping_name(q.mapping)) + "\n";
  text += "box: " + q.box.text() + " (" + q.box.name + ")\n";
  text += "claim: no joint's frame jumps, and none turns by more than " + number_text(q.gain) +
          " deg per deg of any one channel\n\n";
  text += "certified  " + share_text(shares.certified) + " of the box, in " +
          plural(shares.certified_boxes, "box", "boxes");
  if (shares.certified_boxes > 0)
    text += "; gain there at most " + bound_text(proof.tree.gain_bound);
  text += "\n";
  text += "refuted    " + share_text(shares.refuted);
  if (shares.refuted_boxes > 0) {
    text += ": " + plural(shares.refuted_boxes, "box holds", "boxes hold") +
            " a pose that breaks the claim";
  }
  text += "\n";
  text += "open       " + share_text(shares.open);
  if (shares.open_boxes > 0) text += ", in " + plural(shares.open_boxes, "box", "boxes");
  text += "\n";
  if (shares.certified < 1.0) text += "no jump    proved on " + share_text(shares.no_jump) + "\n";

  const std::vector<Refutation> worst = distinct(worst_first(proof.tree));
  if (!worst.empty()) {
    text += "\nworst poses, measured with the plain solver:\n";
    for (std::size_t i = 0; i < std::min(kShown, worst.size()); ++i) {
      const Refutation& r = worst[i];
      const std::string size = r.check == "BB001" ? "jumps by " + number_text(r.value, 2) + " deg"
                                                  : "turns " + number_text(r.value, 1) + " " +
                                                        unit_of(q.box, system, r.axis);
      text += "  " + r.check + "  " + system.joint_names()[r.joint] + " " + size + " along " +
              q.box.axis[std::size_t(r.axis)].channel + " at " + pose_text(q.box, r.pose) + "\n";
    }
    if (worst.size() > kShown) text += "  and " + std::to_string(worst.size() - kShown) + " more\n";
  }
  if (const auto open = open_boxes(proof); !open.empty()) {
    text += "\nlargest open boxes (a smaller --smallest may decide them):\n";
    for (std::size_t i = 0; i < std::min<std::size_t>(3, open.size()); ++i)
      text += "  " + box_text(q.box, open[i]) + "\n";
  }
  if (shares.certified < 1.0)
    text += "\n" + map_text(map_of(proof, map_columns(style)), q.box, style);
  return text;
}

ordered_json pose_json(const ProofBox& box, const std::array<double, kProofAxes>& pose) {
  ordered_json json = ordered_json::object();
  for (std::size_t j = 0; j < box.axis.size(); ++j) {
    if (box.axis[j].channel == "extension" && pose[j] < 0.0)
      json["flexion"] = -pose[j];
    else
      json[box.axis[j].channel] = pose[j];
  }
  return json;
}

std::string proof_json(const Certificate& proof, const solver::SpineSystem& system) {
  constexpr std::size_t kMost = 1000;
  const ProofQuestion& q = proof.question;
  const ProofShares shares = shares_of(proof.tree, q.box);
  ordered_json axes = ordered_json::object();
  for (const ProofAxis& a : q.box.axis) axes[a.channel] = {a.low, a.high};
  ordered_json refuted = ordered_json::array(), open = ordered_json::array(),
               map = ordered_json::array();
  const std::vector<Refutation> worst = worst_first(proof.tree);
  for (std::size_t i = 0; i < std::min(kMost, worst.size()); ++i) {
    const Refutation& r = worst[i];
    refuted.push_back(JsonObject<ordered_json>()
                          .with("pose", pose_json(q.box, r.pose))
                          .with("check", r.check)
                          .with("value", r.value)
                          .with("unit", r.check == "BB001" ? "deg" : unit_of(q.box, system, r.axis))
                          .with("along", q.box.axis[std::size_t(r.axis)].channel)
                          .with("joint", system.joint_names()[r.joint]));
  }
  const std::vector<SubBox> boxes = open_boxes(proof);
  for (std::size_t i = 0; i < std::min(kMost, boxes.size()); ++i) {
    ordered_json part = ordered_json::object();
    for (std::size_t j = 0; j < q.box.axis.size(); ++j)
      part[q.box.axis[j].channel] = {boxes[i].low[j], boxes[i].high[j]};
    open.push_back(part);
  }
  const ProofMap bands = map_of(proof, 60);
  for (const ProofMap::Band& b : bands.bands())
    map.push_back(
        JsonObject<ordered_json>().with("from", b.low).with("to", b.high).with("rows", b.row));
  ordered_json json =
      JsonObject<ordered_json>()
          .with("schema", "backbend.proof/1")
          .with("rig", rig_text(q.rig))
          .with("mapping", mapping_name(q.mapping))
          .with("box", axes)
          .with("claims",
                JsonObject<ordered_json>().with("no_jump", true).with("gain_at_most", q.gain))
          .with("certified", shares.certified)
          .with("open", shares.open)
          .with("refuted_share", shares.refuted)
          .with("no_jump", shares.no_jump)
          .with("gain_bound",
                shares.certified_boxes > 0 ? ordered_json(proof.tree.gain_bound) : ordered_json())
          .with("boxes", JsonObject<ordered_json>()
                             .with("certified", shares.certified_boxes)
                             .with("refuted", shares.refuted_boxes)
                             .with("open", shares.open_boxes)
                             .with("looked_at", proof.tree.looked_at))
          .with("refuted", refuted)
          .with("open_boxes", open)
          .with("map", JsonObject<ordered_json>()
                           .with("across", q.box.axis[0].channel)
                           .with("up", q.box.axis[bands.up()].channel)
                           .with("bands_of", q.box.axis[bands.along()].channel)
                           .with("bands", map));
  return json.dump(1) + "\n";
}

}  // namespace backbend::validate
