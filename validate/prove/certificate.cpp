#include "validate/prove/certificate.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "validate/files/hash.h"
#include "validate/files/output_folder.h"
#include "validate/sweeps/suite.h"
#include "validate/text/json_object.h"

namespace backbend::validate {
namespace {

using nlohmann::ordered_json;

constexpr std::string_view kSchema = "backbend.certificate/1";
constexpr std::string_view kLeaves = "CRSGOP";

ordered_json vector_json(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

ordered_json question_json(const ProofQuestion& q) {
  ordered_json joints = ordered_json::array(), axes = ordered_json::array();
  for (const glm::dvec3& j : q.chain.joint) joints.push_back(vector_json(j));
  for (const ProofAxis& a : q.box.axis) axes.push_back({a.channel, a.low, a.high});
  return JsonObject<ordered_json>()
      .with("rig", rig_text(q.rig))
      .with("joints", joints)
      .with("left", vector_json(q.chain.left))
      .with("mapping", mapping_name(q.mapping))
      .with("box", JsonObject<ordered_json>()
                       .with("name", q.box.name)
                       .with("of_controls", q.box.of_controls)
                       .with("axes", axes))
      .with("gain", q.gain)
      .with("smallest", q.smallest)
      .with("boxes", q.boxes);
}

glm::dvec3 vector_of(const ordered_json& json) {
  if (!json.is_array() || json.size() != 3) throw ProofError("a place has not three numbers");
  return {json[0].get<double>(), json[1].get<double>(), json[2].get<double>()};
}

ProofQuestion question_of(const ordered_json& json) {
  ProofQuestion q;
  const std::string rig = json.at("rig").get<std::string>();
  // That would be a file of whoever checks.
  if (rig.ends_with(".toml")) throw ProofError("the rig is a file, not a system with its options");
  q.rig = read_rig(rig).spec;
  for (const ordered_json& j : json.at("joints")) q.chain.joint.push_back(vector_of(j));
  q.chain.left = vector_of(json.at("left"));
  const auto mapping = find_mapping(json.at("mapping").get<std::string>());
  if (!mapping) throw ProofError("the mapping is none");
  q.mapping = *mapping;
  const ordered_json& box = json.at("box");
  q.box.name = box.at("name").get<std::string>();
  q.box.of_controls = box.at("of_controls").get<bool>();
  for (const ordered_json& a : box.at("axes")) {
    q.box.axis.push_back(
        {a.at(0).get<std::string>(), a.at(1).get<double>(), a.at(2).get<double>()});
  }
  if (q.box.axis.empty() || q.box.axis.size() > kProofAxes)
    throw ProofError("the box has no axes, or too many");
  check_box(q.box, "the box");
  q.gain = json.at("gain").get<double>();
  q.smallest = json.at("smallest").get<double>();
  q.boxes = json.at("boxes").get<std::uint64_t>();
  if (!(q.gain > 0.0) || !std::isfinite(q.gain)) throw ProofError("the gain is not above 0");
  if (!(q.smallest > 0.0) || !std::isfinite(q.smallest))
    throw ProofError("the smallest box has no width");
  return q;
}

/// Reads a tree from its text; refutations are taken in order.
ProofTree tree_of(const std::string& text, const ordered_json& refutations, std::size_t axes) {
  ProofTree tree;
  std::vector<std::uint32_t> open{0};
  std::size_t refuted = 0;
  for (const char c : text) {
    if (open.empty()) throw ProofError("the tree goes on after its last box");
    const std::uint32_t at = open.back();
    open.pop_back();
    const bool looked_at = c >= '0' && c < char('0' + axes);
    if (looked_at || (c >= 'a' && c < char('a' + axes))) {
      const auto first = static_cast<std::uint32_t>(tree.node.size());
      tree.node[at].state = BoxState::split;
      tree.node[at].axis = static_cast<std::int8_t>(c - (looked_at ? '0' : 'a'));
      tree.node[at].looked_at = looked_at;
      tree.node[at].first = first;
      tree.node.resize(tree.node.size() + 2);
      open.push_back(first + 1);
      open.push_back(first);
      continue;
    }
    if (kLeaves.find(c) == std::string_view::npos) {
      throw ProofError("the tree holds '" + std::string(1, c) +
                       "', expected a split or the state of a box");
    }
    tree.node[at].state = static_cast<BoxState>(c);
    if (c != 'R' && c != 'S') continue;
    if (refuted == refutations.size()) throw ProofError("a refuted box has no pose");
    const ordered_json& row = refutations[refuted];
    Refutation r;
    for (std::size_t j = 0; j < axes; ++j) r.pose[j] = row.at(0).at(j).get<double>();
    r.check = row.at(1).get<std::string>();
    r.value = row.at(2).get<double>();
    r.joint = row.at(3).get<std::size_t>();
    r.axis = row.at(4).get<int>();
    if ((r.check != "BB001" && r.check != "BB002") || r.axis < 0 || r.axis >= int(axes)) {
      throw ProofError("refuted pose " + std::to_string(refuted + 1) + " names no check or axis");
    }
    tree.node[at].refutation = static_cast<std::uint32_t>(refuted++);
    tree.refutation.push_back(std::move(r));
  }
  if (!open.empty())
    throw ProofError("the tree ends before its last box: the boxes do not fill the whole");
  if (refuted != refutations.size()) throw ProofError("a pose belongs to no refuted box");
  return tree;
}

}  // namespace

std::string certificate_text(const Certificate& certificate) {
  const ProofTree& tree = certificate.tree;
  std::string boxes;
  ordered_json refutations = ordered_json::array();
  std::vector<std::uint32_t> stack{0};
  while (!stack.empty()) {
    const ProofNode& node = tree.node[stack.back()];
    stack.pop_back();
    if (node.state == BoxState::split) {
      boxes += static_cast<char>((node.looked_at ? '0' : 'a') + node.axis);
      stack.push_back(node.first + 1);
      stack.push_back(node.first);
      continue;
    }
    boxes += static_cast<char>(node.state);
    if (node.state != BoxState::refuted && node.state != BoxState::steep) continue;
    const Refutation& r = tree.refutation[node.refutation];
    ordered_json pose = ordered_json::array();
    for (std::size_t j = 0; j < certificate.question.box.axis.size(); ++j)
      pose.push_back(r.pose[j]);
    refutations.push_back({pose, r.check, r.value, r.joint, r.axis});
  }
  ordered_json json = JsonObject<ordered_json>()
                          .with("schema", kSchema)
                          .with("program", BACKBEND_VERSION)
                          .with("question", question_json(certificate.question))
                          .with("gain_bound", tree.gain_bound)
                          .with("looked_at", tree.looked_at)
                          .with("tree", boxes)
                          .with("refutations", refutations);
  json["hash"] = content_hash(json.dump());
  return json.dump() + "\n";
}

Certificate parse_certificate(const std::string& text, const std::string& name) {
  const auto refuse = [&](const std::string& why) { throw ProofError(name + ": " + why); };
  ordered_json json = ordered_json::parse(text, nullptr, false);
  if (json.is_discarded()) refuse("not JSON, or cut short: no certificate");
  if (!json.is_object() || !json.contains("schema")) refuse("no certificate: it has no schema");
  if (json["schema"] != kSchema) {
    refuse("schema " + json["schema"].dump() + ", expected \"" + std::string(kSchema) + "\"");
  }
  if (!json.contains("hash") || !json["hash"].is_string()) refuse("the certificate has no hash");
  const std::string hash = json["hash"].get<std::string>();
  json.erase("hash");
  if (content_hash(json.dump()) != hash)
    refuse("the certificate was changed: its hash does not fit");
  Certificate certificate;
  try {
    certificate.question = question_of(json.at("question"));
    certificate.tree = tree_of(json.at("tree").get<std::string>(), json.at("refutations"),
                               certificate.question.box.axis.size());
    certificate.tree.gain_bound = json.at("gain_bound").get<double>();
    certificate.tree.looked_at = json.at("looked_at").get<std::uint64_t>();
  } catch (const ordered_json::exception&) {
    refuse("the certificate lacks a part, or holds one of the wrong type");
  } catch (const std::runtime_error& error) {
    refuse(error.what());
  }
  return certificate;
}

Certificate read_certificate(const std::filesystem::path& file) {
  return parse_certificate(read_text(file), file.string());
}

void write_certificate(const std::filesystem::path& file, const Certificate& certificate) {
  const std::filesystem::path folder = file.parent_path();
  OutputFolder(folder.empty() ? "." : folder).write(file.filename(), certificate_text(certificate));
}

std::string difference(const ProofQuestion& a, const ProofQuestion& b) {
  const ordered_json mine = question_json(a), other = question_json(b);
  for (const auto& [key, value] : mine.items()) {
    if (value != other.at(key)) return key;
  }
  return {};
}

}  // namespace backbend::validate
