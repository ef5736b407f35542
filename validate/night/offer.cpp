#include "validate/night/offer.h"

#include <algorithm>

#include "solver/rig/option_range.h"
#include "validate/files/import.h"
#include "validate/files/output_folder.h"
#include "validate/model/digest.h"
#include "validate/sweeps/external_spec.h"
#include "validate/text/shell_word.h"
#include "validate/verdicts/booking.h"

namespace backbend::validate {
namespace {

std::string with_clean_weights(const Finding& finding) {
  const auto clean = finding.geometry.find("proxy_weights");
  if (clean == finding.geometry.end()) return {};
  const bool passes =
      judge(*find_check(finding.code), clean->second, finding.limit) == Verdict::pass;
  return "clean weights give " + quantity_text(finding, clean->second) + " in this pose, which " +
         (passes ? "passes" : "does not pass either");
}

}  // namespace

void offer_repair(const std::filesystem::path& file, const std::string& words, DrivenChain chain,
                  std::span<Finding> findings) {
  const std::string kind = file.extension().string();
  if ((kind != ".glb" && kind != ".gltf") || is_imported(file) || chain == DrivenChain::neck)
    return;
  for (Finding& finding : findings)
    if (is_of_weights(finding))
      finding.cures.push_back(
          {"backbend repair " + words + " -o " + shell_word(file.stem().string() + "_fixed.glb"),
           with_clean_weights(finding)});
}

void offer_tune(const RigRecord& rig, const solver::RestChain& rest, DrivenChain chain,
                const std::string& words, std::vector<Finding>& findings) {
  const RigPlan& plan = rig.plan;
  if (plan.role != Role::proposed || is_external(plan.spec)) return;
  const auto is_ours = [](const Finding& finding) {
    return finding.verdict == Verdict::fail && finding.owner == Owner::solver;
  };
  if (std::ranges::none_of(findings, is_ours) || solver::option_ranges(plan.spec, rest).empty())
    return;
  const std::string command = "backbend tune " + shell_word(rig_text(plan.spec)) + " --for " +
                              words +
                              (rig.mapping == solver::Mapping::chest
                                   ? std::string()
                                   : " --mapping " + std::string(mapping_name(rig.mapping))) +
                              (chain == DrivenChain::neck ? " --chain neck" : "") + " -o " +
                              shell_word(file_word(plan.name) + "_tuned.toml");
  for (Finding& finding : findings)
    if (is_ours(finding)) finding.cures.push_back({command, ""});
}

void offer_even(DrivenChain chain, const std::string& words, const std::vector<Headroom>& of_even,
                std::vector<Finding>& findings) {
  if (chain == DrivenChain::neck || of_even.empty()) return;
  for (Finding& finding : findings) {
    if (finding.verdict != Verdict::fail) continue;
    if (finding.owner != Owner::solver && finding.owner != Owner::rig) continue;
    const auto ideal = finding.geometry.find("ideal");
    const bool cured =
        ideal != finding.geometry.end()
            ? judge(*find_check(finding.code), ideal->second, finding.limit) == Verdict::pass
            : finding.code == "BB001" || finding.code == "BB002";  // `even` turns with its controls
    if (!cured) continue;
    finding.cures.push_back({"backbend export even --to blender --for " + words + " -o " +
                                 shell_word(file_word(finding.character) + "_even.py"),
                             "even is clean on this character to " + headroom_text(of_even)});
  }
}

}  // namespace backbend::validate
