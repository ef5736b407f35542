#include "tests/battery/tables.h"

#include <algorithm>
#include <cstdio>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "validate/sweeps/sweep.h"

namespace backbend::battery {
namespace {

using nlohmann::json;
using validate::number_text;

constexpr double kWanted = 0.95;  // of the faults of a plain size

bool is_clean(const json& each) { return each["family"].get<std::string>().starts_with("clean"); }

/// `spine of 7` counts as `spine of`, `hero.glb` stays.
std::string kind_of_step(const std::string& step) {
  std::string out;
  for (const char c : step)
    if (!std::isdigit(static_cast<unsigned char>(c)) && c != '.') out += c;
  while (!out.empty() && (out.back() == ' ' || out.back() == '-')) out.pop_back();
  return out.substr(std::min(out.find_first_not_of(" -"), out.size()));
}

struct Count {
  int cases = 0, wrong = 0;
  void add(bool is_wrong) {
    ++cases;
    wrong += is_wrong;
  }
};

void print_counts(const char* head, const std::map<std::string, Count>& counts) {
  std::printf("\n| %s | cases | failed |\n|---|---|---|\n", head);
  for (const auto& [name, count] : counts)
    std::printf("| %s | %d | %d |\n", name.c_str(), count.cases, count.wrong);
}

int print_clean(const std::vector<json>& cases) {
  std::map<std::string, Count> by_character, by_step;
  std::map<std::string, int> by_code, refusals;
  Count all;
  for (const json& each : cases) {
    if (!is_clean(each) || !each.contains("exit")) continue;
    const bool wrong = each["exit"] != 0;
    all.add(wrong);
    const std::string family = each["family"];
    by_character[family + ", " + each["character"].get<std::string>()].add(wrong);
    std::set<std::string> kinds;
    for (const json& step : each["steps"])
      if (const std::string kind = kind_of_step(step); !kind.starts_with("from"))
        kinds.insert(kind);
    for (const std::string& kind : kinds) by_step[family + ", " + kind].add(wrong);
    std::set<std::string> codes;
    for (const json& finding : each["findings"])
      codes.insert(finding["code"].get<std::string>() + " " + finding["owner"].get<std::string>());
    for (const std::string& code : codes) ++by_code[family + ", " + code];
    if (wrong && codes.empty())
      ++by_code[family + ", exit " + std::to_string(each["exit"].get<int>())];
    if (const std::string why = each["refused"]; !why.empty())
      ++refusals[each["character"].get<std::string>() + ": " + why.substr(why.find(": ") + 2)];
  }
  if (all.cases == 0) return 0;
  std::printf("Clean cases: %d, failed: %d (%s %%)\n", all.cases, all.wrong,
              number_text(100.0 * all.wrong / all.cases, 2).c_str());
  print_counts("clean", by_character);
  print_counts("made by", by_step);
  std::printf("\n| failed by | cases |\n|---|---|\n");
  for (const auto& [code, count] : by_code) std::printf("| %s | %d |\n", code.c_str(), count);
  for (const auto& [why, count] : refusals) std::printf("refused %d: %s\n", count, why.c_str());
  return all.wrong;
}

/// What limits are set by (even seeds) and compared with (odd ones).
void print_worst(const std::vector<json>& cases) {
  std::map<std::string, std::vector<double>> worst;
  for (const json& each : cases)
    if (is_clean(each) && each.contains("worst"))
      for (const auto& [metric, value] : each["worst"].items())
        worst[each["family"].get<std::string>() + ", " + metric].push_back(value);
  if (worst.empty()) return;
  std::printf(
      "\n| worst of a clean case | cases | median | 95 of 100 | largest "
      "|\n|---|---|---|---|---|\n");
  for (auto& [metric, values] : worst) {
    std::sort(values.begin(), values.end());
    const auto at = [&](double share) {
      return number_text(
          values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))], 3);
    };
    std::printf("| %s | %zu | %s | %s | %s |\n", metric.c_str(), values.size(), at(0.5).c_str(),
                at(0.95).c_str(), at(1.0).c_str());
  }
}

struct FaultCount {
  int cases = 0, found = 0, placed = 0, owned = 0, measured = 0, sized = 0;
  bool plain = false;
  std::string unit;
};

bool print_faults(const std::vector<json>& cases) {
  std::map<std::string, std::map<double, FaultCount>> kinds;
  FaultCount plain;
  const auto add = [](FaultCount& count, const json& each) {
    ++count.cases;
    count.found += each["found"].get<bool>();
    count.placed += each["placed"].get<bool>();
    count.owned += each["owned"].get<bool>();
    if (each.contains("sized")) {
      ++count.measured;
      count.sized += each["sized"].get<bool>();
    }
  };
  for (const json& each : cases) {
    if (!each.contains("fault")) continue;
    FaultCount& count = kinds[each["fault"]][each["size"]];
    count.plain = each["plain"];
    count.unit = each["unit"];
    add(count, each);
    if (count.plain) add(plain, each);
  }
  if (kinds.empty()) return true;
  std::printf(
      "\n| fault | size | cases | found | at its place | size within 5 %% | owner |\n"
      "|---|---|---|---|---|---|---|\n");
  for (const auto& [kind, sizes] : kinds)
    for (const auto& [size, count] : sizes)
      std::printf("| %s | %s %s%s | %d | %d | %d | %s | %d |\n", kind.c_str(),
                  number_text(size, 1).c_str(), count.unit.c_str(), count.plain ? ", plain" : "",
                  count.cases, count.found, count.placed,
                  count.measured > 0 ? std::to_string(count.sized).c_str() : "", count.owned);
  std::printf("\n| fault | smallest size from which on 95 of 100 are found |\n|---|---|\n");
  for (const auto& [kind, sizes] : kinds) {
    std::string smallest = "none";
    for (auto at = sizes.rbegin(); at != sizes.rend(); ++at) {
      if (at->second.found < kWanted * at->second.cases) break;
      smallest = number_text(at->first, 1) + " " + at->second.unit;
    }
    std::printf("| %s | %s |\n", kind.c_str(), smallest.c_str());
  }
  const auto share = [&](int of, int all) {
    return all == 0 ? std::string("-") : number_text(100.0 * of / all, 1) + " %";
  };
  std::printf(
      "\nFaults of a plain size: %d; found %s, at their place %s, size within 5 %% %s of %d, owner "
      "%s\n",
      plain.cases, share(plain.found, plain.cases).c_str(),
      share(plain.placed, plain.cases).c_str(), share(plain.sized, plain.measured).c_str(),
      plain.measured, share(plain.owned, plain.cases).c_str());
  return plain.found >= kWanted * plain.cases;
}

}  // namespace

bool print_tables(const std::vector<json>& cases) {
  std::map<std::string, int> not_made;
  for (const json& each : cases)
    if (each.contains("not_made"))
      ++not_made[each["family"].get<std::string>() + ": " + each["not_made"].get<std::string>()];
  const bool clean = print_clean(cases) == 0;
  print_worst(cases);
  const bool found = print_faults(cases);
  for (const auto& [why, count] : not_made) std::printf("not made %d, %s\n", count, why.c_str());
  return clean && found;
}

}  // namespace backbend::battery
