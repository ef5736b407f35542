#include "validate/history/baseline.h"

#include "tests/fuzz/target.h"
#include "tests/validate/report_sample.h"
#include "validate/files/hash.h"

namespace backbend::fuzz {
namespace {

const validate::Report& report() {
  static const validate::Report sample = validate::sample_report();
  return sample;
}

bool run(Input input) {
  try {
    const validate::Baseline baseline = validate::parse_baseline(text_of(input), "baseline.json");
    const std::string once = validate::baseline_json(baseline);
    require(validate::baseline_json(validate::parse_baseline(once, "again")) == once,
            "a baseline that is written reads back as it was");
    std::vector<validate::Finding> findings = report().findings;
    validate::apply_baseline(
        findings, [](const validate::Finding&) { return validate::Role::proposed; }, baseline,
        "2026-11-22");
    return true;
  } catch (const validate::BaselineError& error) {
    return refused(error);
  }
}

std::vector<Bytes> seeds() {
  validate::Approvals all = validate::approvals_of_all(report());
  all.author = "lead";
  all.reason = "show start";
  all.until = "2026-12-15";
  return {bytes_of(validate::baseline_json(
      validate::approve({}, report(), all, "2026-11-22",
                        [](const std::string& path) { return validate::content_hash(path); })))};
}

const Registration registration{
    {"baseline",
     run,
     seeds,
     {"\"schema\"", "backbend.baseline/1", "null", "1e308", "2026-02-30"},
     8192}};

}  // namespace
}  // namespace backbend::fuzz
