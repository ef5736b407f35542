#include <cmath>
#include <nlohmann/json.hpp>

#include "tests/fuzz/target.h"
#include "validate/files/hash.h"
#include "validate/prove/certificate.h"

namespace backbend::fuzz {
namespace {

using namespace validate;

ProofQuestion question() {
  ProofQuestion q;
  q.rig = {"isner", {}};
  for (int j = 0; j < 5; ++j) q.chain.joint.emplace_back(0.0, 0.1 * j, 0.0);
  q.box = {"extension=90:120",
           false,
           {{"extension", 90.0, 120.0}, {"side", 0.0, 0.0}, {"twist", 0.0, 0.0}}};
  return q;
}

/// A certificate, its hash made to fit: what is behind the hash is tried.
bool run(Input input) {
  nlohmann::ordered_json json = nlohmann::ordered_json::parse(text_of(input), nullptr, false);
  std::string text(text_of(input));
  if (json.is_object()) {
    json.erase("hash");
    json["hash"] =
        content_hash(json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
    text = json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  }
  try {
    const Certificate read = parse_certificate(text, "fuzzed");
    const ProofShares shares = shares_of(read.tree, read.question.box);
    require(std::abs(shares.certified + shares.refuted + shares.open - 1.0) < 1e-6,
            "the boxes of a certificate fill the whole");
    const Certificate again = parse_certificate(certificate_text(read), "written again");
    require(difference(again.question, read.question).empty(), "the question stays the same");
    require(again.tree.node.size() == read.tree.node.size(), "the tree stays the same");
    return true;
  } catch (const ProofError& error) {
    return refused(error);
  }
}

std::vector<Bytes> seeds() {
  Certificate whole{question(), {}};
  whole.tree.node.front().state = BoxState::certified;
  Certificate split{question(), {}};
  split.tree.node.resize(3);
  split.tree.node[0] = {BoxState::split, 0, true, 1, 0};
  split.tree.node[1].state = BoxState::open;
  split.tree.node[2].state = BoxState::refuted;
  split.tree.refutation.push_back({{114.27, 0.0, 0.0}, "BB001", 180.0, 2, 0});
  return {bytes_of(certificate_text(whole)), bytes_of(certificate_text(split))};
}

const Registration registration{
    {"certificate",
     run,
     seeds,
     {"\"tree\"", "\"refutations\"", "\"question\"", "\"axes\"", "\"joints\"", "\"rig\"",
      "\"gain\"", "0", "a", "C", "R", "S", "G", "O", "P", "1e308", "null"},
     8192}};

}  // namespace
}  // namespace backbend::fuzz
