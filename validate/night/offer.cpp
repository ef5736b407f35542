#include "validate/night/offer.h"

#include <algorithm>

#include "solver/rig/option_range.h"
#include "validate/files/output_folder.h"
#include "validate/sweeps/external_spec.h"
#include "validate/text/shell_word.h"
#include "validate/verdicts/booking.h"

namespace backbend::validate {

void offer_repair(const std::filesystem::path& file, const std::string& character,
                  const std::string& words, DrivenChain chain, std::vector<Finding>& findings) {
  const std::string kind = file.extension().string();
  if ((kind != ".glb" && kind != ".gltf") || chain == DrivenChain::neck) return;
  for (Finding& finding : findings)
    if (finding.character == character && is_of_weights(finding))
      finding.repair =
          "backbend repair " + words + " -o " + shell_word(file.stem().string() + "_fixed.glb");
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
    if (is_ours(finding)) finding.repair = command;
}

}  // namespace backbend::validate
