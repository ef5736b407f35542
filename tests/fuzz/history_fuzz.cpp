#include "validate/history/history.h"

#include "tests/fuzz/target.h"
#include "tests/validate/report_sample.h"
#include "validate/history/history_text.h"
#include "validate/history/trend.h"

namespace backbend::fuzz {
namespace {

bool run(Input input) {
  try {
    const std::vector<validate::Night> nights = validate::parse_history(text_of(input), "h.jsonl");
    for (const validate::Night& night : nights) {
      const std::string line = validate::night_json(night);
      require(validate::night_json(validate::parse_history(line + "\n", "again").at(0)) == line,
              "a night that is written reads back as it was");
    }
    if (nights.empty()) return true;
    const auto table = validate::trends_of(nights, nights.back().suite);
    validate::history_text(table, {});
    for (const validate::NightFailure& each : nights.back().failures)
      if (const auto onset = validate::first_bad(nights, each.character, each.code))
        validate::onset_text(each.character, each.code, *onset, {});
    return true;
  } catch (const validate::HistoryError& error) {
    return refused(error);
  }
}

std::vector<Bytes> seeds() {
  std::string lines;
  for (const char* date : {"2026-11-20", "2026-11-21", "2026-11-22"}) {
    validate::Night night = validate::night_of(validate::sample_report(), date, "v013");
    night.values.resize(std::min<std::size_t>(night.values.size(), 3));
    night.failures.resize(std::min<std::size_t>(night.failures.size(), 2));
    lines += validate::night_json(night) + "\n";
  }
  return {bytes_of(lines)};
}

const Registration registration{
    {"history",
     run,
     seeds,
     {"\"schema\"", "backbend.night/1", "backbend.night/2", "\"date\"", "\"label\"", "\"suite\"",
      "\"report\"", "\"metrics\"", "\"verdict\"", "\"version\"", "\"values\"", "\"failures\"",
      "null", "1e308", "\n"},
     8192}};

}  // namespace
}  // namespace backbend::fuzz
