#include "validate/prove/metric_proof_text.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "validate/prove/proof_map.h"
#include "validate/prove/proof_text.h"
#include "validate/sweeps/suite.h"
#include "validate/text/json_object.h"

namespace backbend::validate {
namespace {

using nlohmann::ordered_json;

std::string_view side_of(const MetricClaim& claim) {
  return claim.check->sense == Sense::at_least ? "at least" : "at most";
}

std::string value_text(const MetricClaim& claim, double value) {
  const std::string unit(claim.check->unit);
  return number_text(value, 3) + (unit == "ratio" ? "" : " " + unit);
}

/// Rounded to the side that is certain.
std::string bound_text(const MetricClaim& claim, double bound) {
  constexpr double kDigits = 1000.0;
  const double scaled = bound * kDigits;
  return value_text(
      claim,
      (claim.check->sense == Sense::at_least ? std::floor(scaled) : std::ceil(scaled)) / kDigits);
}

ProofMap map_of(const MetricQuestion& question, const MetricProof& proof, std::size_t claim,
                std::size_t columns) {
  ProofMap map(question.box, columns);
  for (const UndecidedBox& box : proof.undecided) {
    if (box.state[claim] == ClaimState::certified) continue;
    map.mark(box.box,
             box.state[claim] == ClaimState::refuted ? ProofMap::kRefuted : ProofMap::kOpen);
  }
  return map;
}

}  // namespace

std::string metric_proof_text(const MetricQuestion& q, const MetricProof& proof,
                              const std::string& rig, const TerminalStyle& style) {
  std::string text = rig;
  if (q.stage) text += " on " + q.stage->character().name;
  text += ", mapping " + std::string(mapping_name(q.mapping)) + "\n";
  text += "box: " + q.box.text() + " (" + q.box.name + "), in parts down to " +
          number_text(q.smallest) + " deg\n";
  for (std::size_t i = 0; i < q.claim.size(); ++i) {
    const MetricClaim& claim = q.claim[i];
    const ClaimResult& own = proof.claim[i];
    text += "\n" + std::string(claim.check->code) + " " + std::string(claim.check->name) + ", " +
            std::string(side_of(claim)) + " " + value_text(claim, claim.limit) + "\n";
    text += "  certified  " + share_text(own.certified) + " of the box";
    if (own.certified > 0.0)
      text += ": " + std::string(side_of(claim)) + " " + bound_text(claim, own.bound) + " there";
    text += "\n  refuted    " + share_text(own.refuted) + "\n  open       " + share_text(own.open) +
            "\n";
    if (own.measured) {
      text += "  worst measured " + value_text(claim, own.worst) + " at " +
              pose_text(q.box, own.pose) + "\n";
    }
    if (own.refuted + own.open > 0.0) {
      const std::string map = map_text(map_of(q, proof, i, map_columns(style)), q.box, style);
      text += "  " + map;
    }
  }
  return text;
}

std::string metric_proof_json(const MetricQuestion& q, const MetricProof& proof,
                              const std::string& rig) {
  ordered_json axes = ordered_json::object(), claims = ordered_json::array();
  for (const ProofAxis& a : q.box.axis) axes[a.channel] = {a.low, a.high};
  for (std::size_t i = 0; i < q.claim.size(); ++i) {
    const ClaimResult& own = proof.claim[i];
    ordered_json worst;
    if (own.measured)
      worst = JsonObject<ordered_json>()
                  .with("value", own.worst)
                  .with("pose", pose_json(q.box, own.pose));
    ordered_json bands = ordered_json::array();
    const ProofMap map = map_of(q, proof, i, 60);
    for (const ProofMap::Band& b : map.bands())
      bands.push_back(
          JsonObject<ordered_json>().with("from", b.low).with("to", b.high).with("rows", b.row));
    claims.push_back(
        JsonObject<ordered_json>()
            .with("check", q.claim[i].check->code)
            .with("sense", name_of(q.claim[i].check->sense))
            .with("limit", q.claim[i].limit)
            .with("unit", q.claim[i].check->unit)
            .with("certified", own.certified)
            .with("refuted_share", own.refuted)
            .with("open", own.open)
            .with("bound", own.certified > 0.0 ? ordered_json(own.bound) : ordered_json())
            .with("worst_measured", worst)
            .with("map", JsonObject<ordered_json>()
                             .with("across", q.box.axis[0].channel)
                             .with("up", q.box.axis[map.up()].channel)
                             .with("bands_of", q.box.axis[map.along()].channel)
                             .with("bands", bands)));
  }
  ordered_json json =
      JsonObject<ordered_json>()
          .with("schema", "backbend.bounds/1")
          .with("rig", rig)
          .with("character", q.stage ? ordered_json(q.stage->character().name) : ordered_json())
          .with("mapping", mapping_name(q.mapping))
          .with("box", axes)
          .with("smallest", q.smallest)
          .with("boxes", proof.looked_at)
          .with("claims", claims);
  return json.dump(1) + "\n";
}

}  // namespace backbend::validate
