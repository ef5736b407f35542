#include "validate/prove/bounds_record.h"

#include <nlohmann/json.hpp>

#include "validate/files/hash.h"
#include "validate/files/output_folder.h"
#include "validate/prove/proof_text.h"
#include "validate/sweeps/suite.h"
#include "validate/text/json_object.h"

namespace backbend::validate {
namespace {

using nlohmann::ordered_json;

constexpr std::string_view kRecordSchema = "backbend.bounds_record/1";
constexpr std::string_view kStateLetters = "CRO";  // in the order of ClaimState

ordered_json claim_json(const ClaimResult& c) {
  ordered_json json = {c.certified, c.refuted, c.open};
  // The worst value is null where nothing was certified.
  json.push_back(c.certified > 0.0 ? ordered_json(c.bound) : ordered_json());
  json.push_back(c.measured ? ordered_json(c.worst) : ordered_json());
  json.push_back(c.pose);
  return json;
}

void read_claim_result(const ordered_json& json, ClaimResult& c) {
  c.certified = json.at(0).get<double>();
  c.refuted = json.at(1).get<double>();
  c.open = json.at(2).get<double>();
  if (!json.at(3).is_null()) c.bound = json.at(3).get<double>();
  c.measured = !json.at(4).is_null();
  if (c.measured) c.worst = json.at(4).get<double>();
  c.pose = json.at(5).get<std::array<double, kProofAxes>>();
}

ordered_json part_json(const MetricProof& part) {
  ordered_json claims = ordered_json::array(), boxes = ordered_json::array();
  for (const ClaimResult& c : part.claim) claims.push_back(claim_json(c));
  for (const UndecidedBox& b : part.undecided) {
    std::string states;
    for (const ClaimState s : b.state) states += kStateLetters[std::size_t(s)];
    boxes.push_back({b.box.low, b.box.high, states});
  }
  return JsonObject<ordered_json>()
      .with("looked_at", part.looked_at)
      .with("claims", claims)
      .with("undecided", boxes);
}

void read_part(const ordered_json& json, MetricProof& part) {
  const ordered_json& claims = json.at("claims");
  if (claims.size() != part.claim.size()) throw ProofError("a part has other claims");
  for (std::size_t i = 0; i < claims.size(); ++i) read_claim_result(claims[i], part.claim[i]);
  for (const ordered_json& row : json.at("undecided")) {
    UndecidedBox box;
    box.box.low = row.at(0).get<std::array<double, kProofAxes>>();
    box.box.high = row.at(1).get<std::array<double, kProofAxes>>();
    for (const char c : row.at(2).get<std::string>()) {
      const std::size_t state = kStateLetters.find(c);
      if (state == std::string_view::npos) throw ProofError("a box has no state");
      box.state.push_back(static_cast<ClaimState>(state));
    }
    if (box.state.size() != claims.size()) throw ProofError("a box has other claims");
    part.undecided.push_back(std::move(box));
  }
  part.looked_at = json.at("looked_at").get<std::uint64_t>();
}

/// Which key of two questions is not the same.
std::string difference_of(const ordered_json& mine, const ordered_json& other) {
  for (const auto& [key, value] : mine.items())
    if (!other.contains(key) || other[key] != value) return key;
  return {};
}

}  // namespace

std::string bounds_question(const MetricQuestion& question, const std::string& rig,
                            const solver::RestChain& chain) {
  const skin::Character* character = question.stage ? &question.stage->character() : nullptr;
  ordered_json joints = ordered_json::array(), axes = ordered_json::array(),
               claims = ordered_json::array();
  for (const glm::dvec3& j : chain.joint) joints.push_back({j.x, j.y, j.z});
  for (const ProofAxis& a : question.box.axis) axes.push_back({a.channel, a.low, a.high});
  for (const MetricClaim& c : question.claim) claims.push_back({c.check->code, c.limit});
  const ordered_json json =
      JsonObject<ordered_json>()
          .with("program", BACKBEND_VERSION)
          .with("rig", rig)
          .with(
              "character",
              character ? hash_text(character->content_hash_high, character->content_hash_low) : "")
          .with("spine", joints)
          .with("mapping", mapping_name(question.mapping))
          .with("box", axes)
          .with("bound", claims)
          .with("smallest", question.smallest);
  return json.dump();
}

void write_bounds_record(const std::filesystem::path& file, const std::string& question_text,
                         const MetricParts& parts) {
  ordered_json rows = ordered_json::array();
  for (const auto& part : parts) rows.push_back(part ? part_json(*part) : ordered_json());
  ordered_json json = JsonObject<ordered_json>()
                          .with("schema", kRecordSchema)
                          .with("question", ordered_json::parse(question_text))
                          .with("parts", rows);
  json["hash"] = content_hash(json.dump());
  const std::filesystem::path folder = file.parent_path();
  OutputFolder(folder.empty() ? "." : folder).write(file.filename(), json.dump() + "\n");
}

MetricParts read_bounds_record(const std::filesystem::path& file, const MetricQuestion& question,
                               const std::string& question_text) {
  const auto refuse = [&](const std::string& why) { throw ProofError(file.string() + ": " + why); };
  ordered_json json = ordered_json::parse(read_text(file), nullptr, false);
  if (json.is_discarded()) refuse("not JSON, or cut short");
  if (!json.is_object() || !json.contains("schema") || json["schema"] != kRecordSchema)
    refuse("expected schema \"" + std::string(kRecordSchema) + "\"");
  const std::string hash = json.value("hash", ordered_json()).dump();
  json.erase("hash");
  if (ordered_json(content_hash(json.dump())).dump() != hash)
    refuse("the file was changed: its hash does not fit");
  if (!json.contains("question") || !json.contains("parts")) refuse("a part of it is missing");
  const ordered_json mine = ordered_json::parse(question_text);
  if (const std::string what = difference_of(mine, json["question"]); !what.empty())
    refuse("of another search: its " + what + " is not the same");
  MetricParts parts;
  try {
    for (const ordered_json& row : json["parts"]) {
      parts.emplace_back();
      if (row.is_null()) continue;
      parts.back() = nothing_yet(question);
      read_part(row, *parts.back());
    }
  } catch (const ordered_json::exception&) {
    refuse("a part of it is of the wrong type");
  } catch (const ProofError& error) {
    refuse(error.what());
  }
  if (parts.size() != parts_not_looked_at(question).size()) refuse("its parts do not fill the box");
  return parts;
}

}  // namespace backbend::validate
