#include <nlohmann/json.hpp>

#include "tests/fuzz/target.h"
#include "tests/validate/report_sample.h"
#include "validate/files/hash.h"
#include "validate/history/baseline.h"

namespace backbend::fuzz {
namespace {

const validate::Report& report() {
  static const validate::Report sample = validate::sample_report();
  return sample;
}

std::string hash_of(const std::string& path) { return validate::content_hash(path); }

/// Through to the baseline that they make.
bool run(Input input) {
  try {
    const validate::Approvals approvals =
        validate::parse_approvals(text_of(input), "approvals.json");
    const validate::Baseline baseline =
        validate::approve({}, report(), approvals, "2026-11-22", hash_of);
    require(baseline.approvals.size() <= approvals.cases.size(), "no approval out of nothing");
    return true;
  } catch (const validate::BaselineError& error) {
    return refused(error);
  }
}

std::vector<Bytes> seeds() {
  const validate::Approvals all = validate::approvals_of_all(report());
  nlohmann::json out = {{"schema", "backbend.approvals/1"},
                        {"report", all.report},
                        {"suite", all.suite},
                        {"author", "lead"},
                        {"reason", "show start"},
                        {"until", "2026-12-15"}};
  for (const auto& each : all.cases)
    out["cases"].push_back({{"finding", each.finding}, {"hash", each.hash}});
  return {bytes_of(out.dump())};
}

const Registration registration{
    {"approvals",
     run,
     seeds,
     {"\"schema\"", "backbend.approvals/1", "\"cases\"", "\"finding\"", "\"hash\"", "\"until\"",
      "18446744073709551615", "-1", "null", "2026-02-30"}}};

}  // namespace
}  // namespace backbend::fuzz
