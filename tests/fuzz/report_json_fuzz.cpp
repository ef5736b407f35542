#include <algorithm>

#include "tests/fuzz/target.h"
#include "tests/validate/report_sample.h"
#include "validate/model/report_json.h"
#include "validate/report/csv.h"
#include "validate/report/html.h"
#include "validate/report/junit.h"
#include "validate/report/markdown.h"
#include "validate/report/terminal.h"

namespace backbend::fuzz {
namespace {

/// Through to every form that is made of a report.
bool run(Input input) {
  try {
    const validate::Report report = validate::parse_report(text_of(input));
    const std::string once = validate::report_json(report);
    require(validate::report_json(validate::parse_report(once)) == once,
            "a report that is written reads back as it was");
    validate::render_html(report);
    validate::junit_xml(report);
    validate::findings_csv(report);
    validate::sweeps_csv(report);
    validate::terminal_summary(report);
    require(validate::markdown_summary(report).size() <= validate::kCommentLimit,
            "a comment is no longer than a comment may be");
    return true;
  } catch (const validate::ReportError& error) {
    return refused(error);
  }
}

/// What is left of the sample with little of everything, which a mutator gets through sooner; and
/// that with the parts of the page beside the findings.
std::vector<Bytes> seeds() {
  const validate::Report whole = validate::sample_report();
  validate::Report small = whole;
  small.rigs.resize(1);
  small.rigs[0].sweeps.resize(1);
  auto& sweep = small.rigs[0].sweeps[0];
  sweep.control_deg.resize(3);
  sweep.frame.resize(std::min<std::size_t>(sweep.frame.size(), 3));
  for (auto& [name, values] : sweep.metric) values.resize(3);
  for (auto& [channel, degrees] : sweep.pose_deg) degrees.resize(3);
  small.comparisons.clear();
  small.findings.resize(1);
  small.pairs.clear();
  small.meshes.clear();
  small.trends.clear();
  small.nights.clear();
  small.checks.resize(std::min<std::size_t>(small.checks.size(), 2));
  validate::Report pages = small;
  const auto first = [](const auto& all) {
    return std::decay_t<decltype(all)>(
        all.begin(),
        all.begin() + static_cast<std::ptrdiff_t>(std::min<std::size_t>(all.size(), 1)));
  };
  pages.rigs.clear();
  pages.comparisons = first(whole.comparisons);
  for (validate::Comparison& each : pages.comparisons) each.sweeps = first(each.sweeps);
  pages.pairs = first(whole.pairs);
  for (validate::PicturePair& each : pages.pairs) each.finding = 0;
  pages.meshes = first(whole.meshes);
  for (validate::MeshView& each : pages.meshes) each.finding = 0;
  pages.trends = first(whole.trends);
  pages.nights = whole.nights;
  return {bytes_of(validate::report_json_compact(small)),
          bytes_of(validate::report_json_compact(pages))};
}

const Registration registration{
    {"report_json", run, seeds, {"null", "1e308", "\\u0000", "-0.0"}, 12288}};

}  // namespace
}  // namespace backbend::fuzz
