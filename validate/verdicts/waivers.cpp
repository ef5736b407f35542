#include "validate/verdicts/waivers.h"

#include <array>
#include <charconv>
#include <chrono>

namespace backbend::validate {
namespace {

bool matches(const std::string& wanted, const std::string& found) {
  return wanted.empty() || wanted == found;
}

int number(std::string_view digits) {
  int value = -1;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  return error == std::errc() && end == digits.data() + digits.size() ? value : -1;
}

}  // namespace

bool is_day(std::string_view text) {
  if (text.size() != 10 || text[4] != '-' || text[7] != '-') return false;
  for (std::size_t i : {0, 1, 2, 3, 5, 6, 8, 9})
    if (text[i] < '0' || text[i] > '9') return false;
  const int year = number(text.substr(0, 4)), month = number(text.substr(5, 2)),
            day = number(text.substr(8, 2));
  if (month < 1 || month > 12 || day < 1) return false;
  constexpr std::array<int, 12> kDays{31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31};
  const bool leap = (year % 4 == 0 && year % 100 != 0) || year % 400 == 0;
  return day <= kDays[static_cast<std::size_t>(month - 1)] + (month == 2 && leap);
}

int days_between(std::string_view from, std::string_view to) {
  const auto day = [](std::string_view text) {
    using namespace std::chrono;
    return sys_days(year(number(text.substr(0, 4))) /
                    month(static_cast<unsigned>(number(text.substr(5, 2)))) /
                    std::chrono::day(static_cast<unsigned>(number(text.substr(8, 2)))));
  };
  return static_cast<int>((day(to) - day(from)).count());
}

void check_waiver(const Waiver& waiver) {
  const std::string place = waiver.origin.empty() ? "" : waiver.origin + ": ";
  if (!find_check(waiver.code))
    throw LimitError(place + "waiver of unknown check '" + waiver.code + "'; did you mean " +
                     std::string(nearest_code(waiver.code)) + "?");
  if (waiver.owner.empty() || waiver.reason.empty())
    throw LimitError(place + "waiver of " + waiver.code + " needs an owner and a reason");
  if (!is_day(waiver.expires))
    throw LimitError(place + "waiver of " + waiver.code + " expires on '" + waiver.expires +
                     "', expected a day like 2026-12-15");
  if (!(waiver.from_deg <= waiver.to_deg))
    throw LimitError(place + "waiver of " + waiver.code + " has an empty range of the control");
}

bool covers(const Waiver& waiver, const Finding& finding) {
  if (waiver.code != finding.code || !matches(waiver.character, finding.character) ||
      !matches(waiver.rig, finding.rig) || !matches(waiver.sweep, finding.sweep) ||
      !matches(waiver.joint, finding.joint))
    return false;
  if (finding.control_deg < waiver.from_deg || finding.control_deg > waiver.to_deg) return false;
  if (std::isnan(waiver.worst)) return true;
  const Check* check = find_check(waiver.code);
  return check && judge(*check, finding.value, waiver.worst) == Verdict::pass;
}

WaiverUse apply_waivers(std::span<Finding> findings, std::span<const Waiver> waivers,
                        std::string_view today) {
  WaiverUse out;
  std::vector<char> used(waivers.size(), 0), expired(waivers.size(), 0), holding(waivers.size(), 0);
  for (Finding& finding : findings) {
    if (finding.verdict != Verdict::fail) continue;
    bool holds = false;
    for (std::size_t i = 0; i < waivers.size(); ++i) {
      if (!covers(waivers[i], finding)) continue;
      used[i] = 1;
      // Days in this form sort as text.
      const bool in_time = today <= waivers[i].expires;
      (in_time ? holding : expired)[i] = 1;
      holds = holds || in_time;
    }
    if (holds) {
      finding.verdict = Verdict::waived;
      ++out.waived;
    }
  }
  for (std::size_t i = 0; i < waivers.size(); ++i) {
    if (holding[i]) out.holding.push_back(i);
    if (expired[i]) out.expired.push_back(i);
    if (!used[i]) out.unused.push_back(i);
  }
  return out;
}

}  // namespace backbend::validate
