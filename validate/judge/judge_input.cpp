#include "validate/judge/judge_input.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>

#include "skin/anatomy/import_checks.h"
#include "skin/anatomy/limb_shift.h"
#include "validate/judge/joint_places.h"

namespace backbend::validate {
namespace {

constexpr std::size_t kMostJoints = 3;  // of one check, each a finding

/// One thing that a check measured on the file.
struct InputFact {
  double value = 0.0;
  int vertex = -1;
  int node = -1;
  double millimetres = 0.0;
  std::size_t places = 0;
  std::string detail;
};

void worst_first(std::vector<InputFact>& facts) {
  std::ranges::stable_sort(facts, std::ranges::greater(), &InputFact::value);
}

/// Where a shift leads, in words that go before what it leads away from.
std::string direction_text(const skin::Anatomy& anatomy, const glm::dvec3& shift) {
  struct Way {
    glm::dvec3 direction;
    std::string_view ahead, behind;
  };
  const Way ways[] = {{anatomy.up, "above", "below"},
                      {anatomy.forward, "in front of", "behind"},
                      {anatomy.left, "to the left of", "to the right of"}};
  const Way& most = *std::ranges::max_element(
      ways, {}, [&](const Way& way) { return std::abs(glm::dot(way.direction, shift)); });
  return std::string(glm::dot(most.direction, shift) > 0.0 ? most.ahead : most.behind);
}

class InputJudge {
 public:
  InputJudge(const RigRecord& rig, const JudgeContext& context, bool judges_weights)
      : rig_(rig), context_(context), judges_weights_(judges_weights) {}

  void ask(std::string_view code, const std::vector<InputFact>& facts) {
    out_.coverage.push_back({std::string(code), 1, 1, 0, 0});
    const Check& check = *find_check(code);
    const double limit = context_.limits.of(code).value;
    std::vector<const InputFact*> failing;
    for (const InputFact& fact : facts)
      if (judge(check, fact.value, limit) == Verdict::fail) failing.push_back(&fact);
    for (std::size_t k = 0; k < failing.size() && k < kMostJoints; ++k) {
      out_.findings.push_back(finding(check, limit, *failing[k]));
      if (k + 1 == kMostJoints && failing.size() > kMostJoints)
        out_.findings.back().detail +=
            "; " + std::to_string(failing.size() - kMostJoints) + " more joints";
    }
  }

  void leave_out(std::string_view code, const std::string& why) {
    out_.coverage.push_back({std::string(code), 1, 0, 0, 1});
    out_.notes.push_back(std::string(code) + " " + std::string(find_check(code)->name) +
                         ", not applicable: " + why);
  }

  /// `story` tells of a joint, its size in per cent and the other joint.
  template <typename Story>
  void ask(std::string_view code, const skin::WeightAnswer& answer, const Story& story) {
    if (!answer.not_applicable.empty()) {
      leave_out(code, answer.not_applicable);
      return;
    }
    std::vector<InputFact> facts;
    for (const skin::WeightFault& fault : answer.faults) {
      if (facts.size() > 4 * kMostJoints) break;
      const double percent = 100.0 * fault.value;
      std::string detail =
          story(joint(fault.node), number_text(percent, 1) + " %", joint(fault.other));
      if (fault.places > 0)
        detail += "; " + std::to_string(fault.places) + " places, " +
                  skin::place_of_fault(character(), context_.stage.anatomy(), fault);
      if (fault.distance > 0.0)
        detail += ", up to " + number_text(1000.0 * fault.distance, 0) + " mm away";
      facts.push_back({percent, fault.places > 0 ? static_cast<int>(fault.vertex) : -1, fault.node,
                       1000.0 * fault.distance, fault.places, std::move(detail)});
    }
    ask(code, facts);
  }

  std::string joint(int node) const { return node < 0 ? "another joint" : name(node); }
  const std::string& name(int node) const {
    return character().nodes[static_cast<std::size_t>(node)].name;
  }
  const skin::Character& character() const { return context_.stage.character(); }
  InputJudgement take() { return std::move(out_); }

 private:
  Finding finding(const Check& check, double limit, const InputFact& fact) const {
    Finding finding;
    finding.code = check.code;
    finding.character = character().name;
    finding.rig = rig_.plan.name;
    finding.mapping = mapping_name(rig_.mapping);
    finding.pose = "rest";
    finding.vertex = fact.vertex;
    if (fact.node >= 0) finding.joint = name(fact.node);
    finding.value = fact.value;
    finding.limit = limit;
    finding.unit = check.unit;
    finding.owner = check.owner;
    finding.verdict = judges_weights_ ? Verdict::fail : Verdict::stress;
    finding.detail = std::string(check.name) + ": " + fact.detail;
    if (fact.millimetres > 0.0) finding.geometry["millimetres"] = fact.millimetres;
    if (fact.places > 0) finding.geometry["places"] = static_cast<double>(fact.places);
    finding.image.note = "no picture metric looks at this";
    finding.reproduce = "backbend inspect " + context_.character;
    return finding;
  }

  const RigRecord& rig_;
  const JudgeContext& context_;
  const bool judges_weights_;
  InputJudgement out_;
};

}  // namespace

InputReading read_input(const Stage& stage) {
  const skin::Character& character = stage.character();
  return {examine_weights(character, character.influences, stage.anatomy().head),
          skin::find_weight_faults(character, stage.anatomy())};
}

InputJudgement judge_input(const RigRecord& rig, const JudgeContext& context,
                           const InputReading& weights, const BodyMetrics& body,
                           bool judges_weights) {
  InputJudge input(rig, context, judges_weights);
  const skin::Character& character = input.character();
  const auto count = [](std::size_t n) { return static_cast<double>(n); };
  // The reader normalised all sums and kept the largest error beyond the storage's rounding.
  input.ask("BB060",
            {{100.0 * std::abs(1.0 - character.worst_weight_sum), character.worst_weight_vertex, -1,
              0.0, 0,
              std::to_string(character.renormalised_vertices) + " vertices, the worst summing to " +
                  number_text(character.worst_weight_sum, 4)}});
  input.ask("BB061",
            {{count(character.unweighted.size()),
              character.unweighted.empty() ? -1 : static_cast<int>(character.unweighted.front()),
              -1, 0.0, 0, std::to_string(character.unweighted.size()) + " vertices stay behind"}});
  input.ask("BB062", {{count(weights.hygiene.stray), weights.hygiene.stray_vertex, -1, 0.0, 0,
                       "the worst has " + number_text(100.0 * weights.hygiene.stray_weight, 1) +
                           " % of its weight on joints that its neighbours do not share"}});

  const skin::WeightFaults& faults = weights.faults;
  using Text = std::string;
  input.ask("BB063", faults.wrong_side,
            [](const Text& joint, const Text& size, const Text& other) -> Text {
              return joint + " has " + size + " of the weight on the other side, where " + other +
                     " belongs";
            });
  input.ask("BB064", faults.far,
            [](const Text& joint, const Text& size, const Text& other) -> Text {
              return joint + " has " + size + " of the weight far from its area, where " + other +
                     " weighs most";
            });
  input.ask("BB065", faults.asymmetry,
            [](const Text& joint, const Text& size, const Text& other) -> Text {
              return joint + " lacks " + size + " of what its mirror image has; " + other +
                     " has it";
            });
  input.ask("BB066", faults.order,
            [](const Text& joint, const Text& size, const Text& other) -> Text {
              if (joint == other)
                return "the weights of " + joint + " and of the joints above it begin " + size +
                       " of the spine away from " + joint;
              return "the weights of " + joint + " stand " + size +
                     " of the spine beyond those of " + other + ", which follows it";
            });
  input.ask("BB067", faults.seams,
            [](const Text& joint, const Text& size, const Text& other) -> Text {
              return joint + " and " + other + ": vertices of one place differ by " + size;
            });

  input.ask("BB069", faults.borders,
            [](const Text& joint, const Text& size, const Text& other) -> Text {
              return "the weights of " + joint + " and " + other + " meet without a blend on " +
                     size + " of the edges between them";
            });

  std::vector<InputFact> off;
  for (const skin::JointBindOff& one : skin::joints_bound_off(character)) {
    const double percent = 100.0 * one.shift / context.stage.anatomy().height;
    off.push_back({percent, static_cast<int>(one.vertex), one.node, 1000.0 * one.shift, 0,
                   input.joint(one.node) + " is bound " + number_text(one.angle_deg, 1) +
                       " deg away from where the joints around it were; the surface stands up to " +
                       number_text(1000.0 * one.shift, 1) + " mm off"});
  }
  input.ask("BB068", off);

  std::vector<InputFact> aside, outside, turned_back;
  for (const JointPlace& place : joint_places(context.stage, body)) {
    const Text side = place.aside > 0.0 ? "left" : "right";
    const double percent = 100.0 * std::abs(place.aside);
    if (std::isfinite(percent))
      aside.push_back({percent, -1, place.node, 0.0, 0,
                       input.joint(place.node) + " stands " + number_text(percent, 0) +
                           " % of the body's half width to the " + side + " of its middle"});
    if (std::isfinite(place.outside))
      outside.push_back({100.0 * place.outside, -1, place.node, 0.0, 0,
                         input.joint(place.node) + " stands outside the body, " +
                             number_text(100.0 * place.outside, 0) +
                             " % of its radius there from the surface"});
    const double back = 100.0 * place.turned_back;
    turned_back.push_back({back, -1, place.node, 0.0, 0,
                           "the chain turns back at " + input.joint(place.node) + ", over " +
                               number_text(back, 1) + " % of the spine"});
  }
  worst_first(aside);
  worst_first(outside);
  worst_first(turned_back);
  if (aside.empty())
    input.leave_out("BB071",
                    "no limbs say where the body's left is, or no cross-section near a "
                    "joint has both sides");
  else
    input.ask("BB071", aside);
  input.ask("BB072", turned_back);
  if (outside.empty())
    input.leave_out("BB073", "no cross-section is near a joint, or it is a figure of bones");
  else
    input.ask("BB073", outside);
  const skin::Anatomy& anatomy = context.stage.anatomy();
  if (const auto limbs = skin::find_limb_shift(character, anatomy)) {
    const double off = glm::length(limbs->shift);
    input.ask("BB074", {{100.0 * limbs->beside, -1, limbs->node, 1000.0 * off, 0,
                         "the limbs stand " + number_text(1000.0 * off, 0) + " mm (" +
                             number_text(100.0 * off / anatomy.height, 1) + " % of the height) " +
                             direction_text(anatomy, limbs->shift) + " their bones, which lie " +
                             number_text(100.0 * limbs->beside, 0) +
                             " % of the way from the middle of what they move to its surface"}});
  } else {
    input.leave_out("BB074", "the limbs' bones agree on no shift from what they move");
  }
  input.ask("BB075", faults.levels,
            [](const Text& joint, const Text& size, const Text& other) -> Text {
              return "half of the vertebrae or more have their weights " + size +
                     " of the spine or more beyond their bones, " + joint + " towards " + other;
            });
  return input.take();
}

}  // namespace backbend::validate
