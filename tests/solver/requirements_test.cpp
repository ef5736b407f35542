// docs/requirements.md says where every requirement is tested. This holds it to its word.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "tests/source_folder.h"

namespace {

const std::filesystem::path kSource = backbend::source_folder();

std::string text_of(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

/// A row of the table: | R12 | what is required | tests | options or reason |
struct Row {
  std::string id;  // R12, W3
  std::string what, tests, note;
};

std::vector<Row> rows_of(const std::string& text) {
  std::vector<Row> rows;
  std::istringstream lines(text);
  const std::regex row(R"(\| ([RW][0-9]+) \| ([^|]*) \| ([^|]*) \| ([^|]*) \|)");
  for (std::string line; std::getline(lines, line);) {
    std::smatch match;
    if (std::regex_match(line, match, row))
      rows.push_back({match[1], match[2], match[3], match[4]});
  }
  return rows;
}

/// The names of the tests that each file of tests/ defines: "Suite.Name" by
/// "solver/curves/curve_test.cpp".
using Defined = std::map<std::string, std::set<std::string>>;

Defined defined_tests() {
  Defined defined;
  const std::regex test(R"(\bTEST(_F|_P)?\(\s*(\w+),\s*(\w+)\s*\))");
  for (const auto& entry : std::filesystem::recursive_directory_iterator(kSource / "tests")) {
    const std::string name = entry.path().filename().string();
    if (!name.ends_with("_test.cpp") || !entry.is_regular_file()) continue;
    const std::string text = text_of(entry.path());
    auto& names = defined[std::filesystem::relative(entry.path(), kSource / "tests").string()];
    for (std::sregex_iterator it(text.begin(), text.end(), test), end; it != end; ++it) {
      names.insert((*it)[2].str() + "." + (*it)[3].str());
    }
  }
  return defined;
}

/// What is wrong with the `tests` cell of a row: "`solver/systems/neck_test.cpp` Neck.A, Neck.B;
/// `..` ..".
std::vector<std::string> complaints(const Row& row, const Defined& defined) {
  std::vector<std::string> wrong;
  if (row.what.size() < 4) wrong.push_back(row.id + ": says nothing");
  if (row.tests == "–") {
    if (std::count(row.note.begin(), row.note.end(), ' ') < 3) {
      wrong.push_back(row.id + ": no test and no reason");
    }
    return wrong;
  }
  if (row.note.empty()) wrong.push_back(row.id + ": no options");
  const std::regex group(R"(`([a-z_]+/[a-z_/]+_test\.cpp)` (\w+\.\w+(?:, \w+\.\w+)*))");
  const std::regex whole(
      "(?:"
      R"(`[a-z_]+/[a-z_/]+_test\.cpp` \w+\.\w+(?:, \w+\.\w+)*(?:; |$))"
      ")+");
  if (!std::regex_match(row.tests, whole)) {
    wrong.push_back(row.id + ": not a list of tests: " + row.tests);
  }
  for (std::sregex_iterator it(row.tests.begin(), row.tests.end(), group), end; it != end; ++it) {
    const auto file = defined.find((*it)[1]);
    if (file == defined.end()) {
      wrong.push_back(row.id + ": no file tests/" + (*it)[1].str());
      continue;
    }
    std::istringstream names((*it)[2].str());
    for (std::string name; std::getline(names >> std::ws, name, ',');) {
      if (!file->second.contains(name)) {
        wrong.push_back(row.id + ": no test " + name + " in " + file->first);
      }
    }
  }
  return wrong;
}

/// What is wrong with a whole page.
std::vector<std::string> complaints(const std::string& page, const Defined& defined) {
  std::vector<std::string> wrong;
  std::map<std::string, int> count;
  for (const Row& row : rows_of(page)) {
    ++count[row.id];
    const auto more = complaints(row, defined);
    wrong.insert(wrong.end(), more.begin(), more.end());
  }
  const auto expect_all = [&](const char* letter, int last) {
    for (int i = 1; i <= last; ++i) {
      const std::string id = letter + std::to_string(i);
      if (count[id] != 1) wrong.push_back(id + ": " + std::to_string(count[id]) + " rows");
      count.erase(id);
    }
  };
  expect_all("R", 170);
  expect_all("W", 18);
  for (const auto& [id, times] : count) wrong.push_back(id + ": there is no such number");
  return wrong;
}

TEST(RequirementsPage, AccountsForEveryNumberAndNamesTestsThatExist) {
  const std::string page = text_of(kSource / "docs/requirements.md");
  for (const std::string& line : complaints(page, defined_tests())) ADD_FAILURE() << line;
}

TEST(RequirementsPage, CannotLieUnnoticed) {  // every way to be wrong is seen
  const std::string page = text_of(kSource / "docs/requirements.md");
  const Defined defined = defined_tests();
  ASSERT_TRUE(complaints(page, defined).empty());
  const auto seen = [&](const std::string& from, const std::string& to, const std::string& said) {
    std::string damaged = page;
    const std::size_t at = damaged.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    damaged.replace(at, from.size(), to);
    const auto wrong = complaints(damaged, defined);
    EXPECT_TRUE(std::any_of(wrong.begin(), wrong.end(), [&](const std::string& line) {
      return line.find(said) != std::string::npos;
    })) << said;
  };
  seen("| R17 |", "| R16 |", "R16: 2 rows");
  seen("| R17 |", "| R16 |", "R17: 0 rows");
  seen("| W18 |", "| W19 |", "W19: there is no such number");
  seen("ThreeBone.StraightChain", "ThreeBone.BentChain", "R1: no test ThreeBone.BentChain");
  seen("`solver/systems/three_bone_test.cpp`", "`solver/four_bone_test.cpp`",
       "no file tests/solver/four");
  const std::string start = "| – | ";
  const std::size_t reason = page.find(start) + start.size();
  seen(page.substr(reason, page.find(" |\n", reason) - reason), "later", "no test and no reason");
}

}  // namespace
