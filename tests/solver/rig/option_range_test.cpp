#include "solver/rig/option_range.h"

#include <gtest/gtest.h>

#include "solver/rig/option_reader.h"
#include "tests/solver/rig_fixture.h"

namespace backbend::solver {
namespace {

using rigs::Options;

/// Systems that a chain of joints alone is enough for.
constexpr const char* kSystems[] = {"curve", "isner",     "even",        "stretchy",
                                    "neck",  "spline_ik", "matrix_blend"};

void expect_refused(const std::string& system, const std::string& key, OptionValue value) {
  try {
    rigs::build(system, {{key, std::move(value)}});
    ADD_FAILURE() << system << " takes " << key;
  } catch (const OptionError& error) {
    EXPECT_EQ(error.key, key);
  }
}

TEST(OptionRanges, AreThoseThatReadingHoldsValuesAgainst) {
  for (const std::string system : kSystems) {
    const auto ranges = option_ranges({system, {}}, rigs::straight());
    ASSERT_FALSE(ranges.empty()) << system;
    const auto options = rigs::build(system)->options();
    for (const auto& [key, range] : ranges) {
      SCOPED_TRACE(system + " " + key);
      if (range.kind == OptionRange::Kind::number || range.kind == OptionRange::Kind::integer) {
        for (const double end : {range.least, range.most})
          EXPECT_NO_THROW(rigs::build(system, {{key, end}}));
        expect_refused(system, key, range.least - 1.0);
        expect_refused(system, key, range.most + 1.0);
      }
      if (range.kind == OptionRange::Kind::integer && range.least < range.most)
        expect_refused(system, key, range.least + 0.5);
      if (range.kind == OptionRange::Kind::word) {
        for (const std::string& word : range.words)
          EXPECT_NO_THROW(rigs::build(system, {{key, word}}));
        expect_refused(system, key, std::string("nonsense"));
      }
      if (range.kind == OptionRange::Kind::numbers) {
        auto list = std::get<std::vector<double>>(options.at(key));
        list.front() = range.most + 1.0;
        expect_refused(system, key, list);
      }
      if (range.kind == OptionRange::Kind::spans) {
        auto rows = std::get<std::vector<std::vector<double>>>(options.at(key));
        rows.back().back() = range.most + 1.0;
        expect_refused(system, key, rows);
      }
    }
  }
}

TEST(OptionRanges, HoldForARigWithNamesOfItsOwn) {
  const auto plain = option_ranges({"even", {}}, rigs::straight());
  const auto named =
      option_ranges({"even", {{"joint_names", std::string("hero_{name}")}}}, rigs::straight());
  EXPECT_EQ(plain.size(), named.size());
}

TEST(OptionRanges, ASystemWithoutOptionsHasNone) {
  EXPECT_TRUE(option_ranges({"three_bone", {}}, rigs::straight()).empty());
}

TEST(OptionRanges, AListOrAWordOfOnesOwnIsLeftOut) {
  const auto words = option_ranges({"even", {}}, rigs::straight());
  EXPECT_EQ(words.count("twist"), 1u);
  const Options list{{"twist", std::vector<double>{1.0, 2.0}}};
  EXPECT_EQ(option_ranges({"even", list}, rigs::straight()).count("twist"), 0u);
}

}  // namespace
}  // namespace backbend::solver
