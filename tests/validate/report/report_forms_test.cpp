// Every form of the report under names that attack it, and read by outside readers where present.
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "tests/temporary_folder.h"
#include "tests/validate/report_sample.h"
#include "validate/model/report_json.h"
#include "validate/report/csv.h"
#include "validate/report/html.h"
#include "validate/report/junit.h"
#include "validate/report/markdown.h"
#include "validate/report/terminal.h"
#include "validate/text/escape.h"

namespace backbend::validate {
namespace {

namespace fs = std::filesystem;

bool is_valid_utf8(const std::string& text) { return valid_utf8(text) == text; }

/// The sections of a page between `open` and `close`, and what is left of the page without them.
std::string without(std::string page, const std::string& open, const std::string& close) {
  for (std::size_t at = page.find(open); at != std::string::npos; at = page.find(open, at)) {
    const std::size_t end = page.find(close, at);
    if (end == std::string::npos) break;
    page.erase(at, end + close.size() - at);
  }
  return page;
}

std::size_t occurrences(const std::string& text, const std::string& part) {
  std::size_t n = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++n;
  return n;
}

TEST(HostileNames, ArePlentyAndDifferent) {
  const auto names = hostile_names();
  EXPECT_GE(names.size(), 200u);
  EXPECT_EQ(std::set<std::string>(names.begin(), names.end()).size(), names.size());
}

TEST(HostileNames, SurviveTheJsonUnchangedWhereTheyAreText) {
  for (const std::string& name : hostile_names()) {
    const Report back = parse_report(report_json(sample_report_named(name)));
    EXPECT_EQ(back.findings[0].detail, valid_utf8(name));
    const std::string again = report_json(back);
    EXPECT_EQ(report_json(parse_report(again)), again);
  }
}

TEST(HostileNames, AddNoTagToThePage) {
  const auto tags = [](const Report& r) {
    const std::string page = render_html_page(r);
    std::map<std::string, std::size_t> out;
    for (const char* tag :
         {"<script", "</script", "<img",   "<svg",  "<iframe",   "<style",     "</style",
          "<meta",   "<base",    "<a ",    "<!--",  "<noscript", "</noscript", "<title",
          "</title", "<object",  "<div",   "</div", "<link",     "<body",      "<form",
          "<input",  "<math",    "<video", "<"})
      out[tag] = occurrences(page, tag);
    return out;
  };
  const auto expected = tags(sample_report_named("plain"));
  for (const std::string& name : hostile_names())
    EXPECT_EQ(tags(sample_report_named(name)), expected) << visible(name);
}

TEST(HostileNames, StayInsideTheirQuotesInThePage) {
  const auto shell_of = [](const std::string& page) {
    return without(without(page, "<script", "</script>"), "<style", "</style>");
  };
  const std::size_t quotes =
      occurrences(shell_of(render_html_page(sample_report_named("x"))), "\"");
  for (const std::string& name : hostile_names()) {
    const std::string page = render_html_page(sample_report_named(name));
    EXPECT_TRUE(is_valid_utf8(page));
    // Outside scripts and style every quote is one of ours: the shell has a fixed number of them.
    const std::string shell = shell_of(page);
    EXPECT_EQ(occurrences(shell, "\""), quotes) << visible(name);
    for (const char c : shell) EXPECT_TRUE(c == '\n' || static_cast<unsigned char>(c) >= 0x20);
  }
}

TEST(HostileNames, LeaveNoControlCharacterInTheTerminal) {
  for (const std::string& name : hostile_names()) {
    const std::string text =
        terminal_summary(sample_report_named(name), {100, false, true, 3, name});
    EXPECT_TRUE(is_valid_utf8(text));
    for (const char c : text)
      EXPECT_TRUE(c == '\n' || static_cast<unsigned char>(c) >= 0x20) << visible(name);
    std::string kept = text;
    kept.erase(std::remove(kept.begin(), kept.end(), '\n'), kept.end());
    EXPECT_EQ(visible(kept), kept) << "nothing that acts is left";
  }
}

TEST(HostileNames, StandInCodeSpansInMarkdown) {
  for (const std::string& name : hostile_names()) {
    const std::string text = markdown_summary(sample_report_named(name));
    EXPECT_LE(text.size(), kCommentLimit);
    EXPECT_TRUE(is_valid_utf8(text));
    // Walk each line as GitHub does: a run of n backticks opens a span that the next run of exactly
    // n closes. What is outside spans must be ours alone: no link, tag, mention or reference.
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
      std::string outside;
      for (std::size_t at = 0; at < line.size();) {
        if (line[at] != '`') {
          outside += line[at++];
          continue;
        }
        const std::size_t run = line.find_first_not_of('`', at) - at;
        std::size_t close = at + run;
        for (;;) {
          close = line.find('`', close);
          ASSERT_NE(close, std::string::npos) << "span not closed: " << visible(name);
          const std::size_t end = std::min(line.find_first_not_of('`', close), line.size());
          if (end - close == run) break;
          close = end;
        }
        at = close + run;
      }
      EXPECT_EQ(outside.find_first_of("<>@[]()&!\\"), std::string::npos) << outside;
      if (!line.starts_with("### ")) {
        EXPECT_EQ(outside.find('#'), std::string::npos) << outside;
      }
    }
  }
}

/// Cells of one CSV text as RFC 4180 reads it.
std::vector<std::vector<std::string>> csv_rows(const std::string& text) {
  std::vector<std::vector<std::string>> rows(1, std::vector<std::string>(1));
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    std::string& cell = rows.back().back();
    if (quoted && c == '"' && i + 1 < text.size() && text[i + 1] == '"') {
      cell += '"';
      ++i;
    } else if (c == '"') {
      quoted = !quoted;
    } else if (!quoted && c == ',') {
      rows.back().emplace_back();
    } else if (!quoted && c == '\r' && i + 1 < text.size() && text[i + 1] == '\n') {
      rows.emplace_back(1, std::string());
      ++i;
    } else {
      cell += c;
    }
  }
  rows.pop_back();
  return rows;
}

TEST(HostileNames, AreNoFormulaInCsv) {
  for (const std::string& name : hostile_names()) {
    const Report report = sample_report_named(name);
    for (const std::string& text : {findings_csv(report), sweeps_csv(report)}) {
      const auto rows = csv_rows(text);
      for (const auto& row : rows) {
        ASSERT_EQ(row.size(), rows[0].size()) << visible(name);
        for (const std::string& cell : row) {
          char* end = nullptr;
          std::strtod(cell.c_str(), &end);
          if (!cell.empty() && *end == 0) continue;  // a number of ours
          const std::size_t first = cell.find_first_not_of(" \t");
          if (first != std::string::npos) {
            EXPECT_EQ(std::string("=+-@").find(cell[first]), std::string::npos) << cell;
          }
        }
      }
    }
    EXPECT_EQ(csv_rows(findings_csv(report)).size(), report.findings.size() + 1);
  }
}

TEST(Csv, KeepsNumbersPlainAndBlankWhereNothingWasMeasured) {
  const auto rows = csv_rows(findings_csv(sample_report()));
  EXPECT_EQ(rows[0][14], "value");
  EXPECT_EQ(rows[1][14], "9.1");
  EXPECT_EQ(rows[6][14], "");
  EXPECT_EQ(rows[6][7], "-24") << "a negative number is no formula";
  EXPECT_EQ(csv_rows(sweeps_csv(sample_report())).size(), 1u + 6 * (91 + 31 + 61));
}

TEST(Markdown, FitsACommentHoweverMuchThereIsToSay) {
  const std::string text = markdown_summary(sample_report_of(10000));
  EXPECT_LE(text.size(), kCommentLimit);
  EXPECT_GT(text.size(), kCommentLimit * 3 / 4);
  EXPECT_NE(text.find("more findings are in report.json"), std::string::npos);
  EXPECT_NE(text.find("`backbend explain BB010`"), std::string::npos) << "the end is never cut off";
  Report long_names = sample_report_of(1000);
  for (Finding& f : long_names.findings) f.detail = std::string(5000, 'x');
  long_names.headline = std::string(100000, 'y');
  EXPECT_LE(markdown_summary(long_names).size(), kCommentLimit);
  EXPECT_LE(markdown_summary(sample_report(), 500).size(), 500u);
}

TEST(Terminal, FitsItsWidthExceptWhatMustBeCopied) {
  for (const int width : {40, 60, 80, 132}) {
    std::istringstream lines(
        terminal_summary(sample_report(), {width, false, true, 3, "runs/a/index.html"}));
    const auto is_copied = [](const std::string& line) {
      for (const char* head : {"backbend ", "page", "maya: ", "blender: "})
        if (line.find(head) != std::string::npos) return true;
      return false;
    };
    for (std::string line; std::getline(lines, line);)
      if (!is_copied(line)) {
        EXPECT_LE(display_width(line), static_cast<std::size_t>(width)) << line;
      }
  }
}

TEST(Terminal, UsesColourOnlyWhenAskedAndThenOnlyColour) {
  const std::string plain = terminal_summary(sample_report(), {80, false, true, 3, ""});
  std::string colored = terminal_summary(sample_report(), {80, true, true, 3, ""});
  EXPECT_EQ(plain.find('\x1b'), std::string::npos);
  EXPECT_NE(colored.find('\x1b'), std::string::npos);
  EXPECT_EQ(without(colored, "\x1b[", "m"), plain);
}

TEST(Terminal, NeverCallsAnUnmeasuredChannelClean) {
  Report report = sample_report();
  for (RigResult& rig : report.rigs)
    for (Headroom& h : rig.headroom) h.measured = false;
  const std::string text = terminal_summary(report);
  EXPECT_NE(text.find("? X"), std::string::npos);
  EXPECT_EQ(text.find("90+"), std::string::npos);
  report.rigs.resize(1);
  EXPECT_NE(terminal_summary(report).find("not measured"), std::string::npos);
}

/// Runs a Python program with `files` written to a folder; nullopt if no Python has `module`:
/// Debian packages are seen by the system's Python only, which need not stand first in PATH.
std::optional<std::string> python(const std::string& module, const std::string& program,
                                  const std::map<std::string, std::string>& files) {
  std::string interpreter;
  for (const char* candidate : {"python3", "/usr/bin/python3"}) {
    const std::string probe =
        std::string(candidate) + " -c 'import " + module + "' >/dev/null 2>&1";
    if (std::system(probe.c_str()) == 0) interpreter = candidate;
  }
  if (interpreter.empty()) return std::nullopt;
  const TemporaryFolder folder;
  for (const auto& [name, text] : files) std::ofstream(folder / name, std::ios::binary) << text;
  std::ofstream(folder / "program.py") << program;
  const std::string command =
      "cd '" + folder.path().string() + "' && " + interpreter + " -W ignore program.py 2>&1";
  std::string output;
  FILE* pipe = popen(command.c_str(), "r");
  std::array<char, 4096> buffer;
  for (std::size_t n; (n = fread(buffer.data(), 1, buffer.size(), pipe)) > 0;)
    output.append(buffer.data(), n);
  pclose(pipe);
  return output;
}

/// The sample, nothing at all, and `names` hostile names in every field, as a JSON array of texts.
template <class F>
std::string all_as_json(std::size_t names, F form) {
  const Report hostile = sample_report_hostile(0, names);
  return nlohmann::json({form(sample_report()), form(Report{}), form(hostile)}).dump();
}

TEST(Junit, IsReadByJunitparserUnderEveryName) {
  const auto output =
      python("junitparser", R"(
import io, json, junitparser
for i, text in enumerate(json.load(open('junit.json'))):
    suites = junitparser.JUnitXml.fromstring(text.encode())
    cases = [c for s in suites for c in s]
    bad = [c for c in cases if any(isinstance(r, (junitparser.Failure, junitparser.Error)) for r in c.result)]
    if i == 0:
        print(len(list(suites)), sorted(c.name for c in bad))
print('read')
)",
             {{"junit.json", all_as_json(1000, [](const Report& r) { return junit_xml(r); })}});
  if (!output) {
    ASSERT_EQ(std::getenv("CI"), nullptr) << "python3-junitparser is not installed";
    GTEST_SKIP() << "python3-junitparser is not installed";
  }
  // run + canaries + six rigs. A proposed rig fails on its kink and drift, is in error where slices
  // were not measured, and no reference rig fails.
  EXPECT_EQ(*output,
            "8 ['BB010 chain kink', 'BB011 mesh kink', 'BB011 mesh kink', 'BB020 arm drift', "
            "'BB030 cross-section collapse', 'BB030 cross-section collapse', 'verdict']\nread\n");
}

TEST(Schema, AcceptsEveryReportWeWriteAndRefusesDamage) {
  nlohmann::json bad = nlohmann::json::array();
  const auto damage = [&](const char* pointer, const nlohmann::json& value) {
    auto document = nlohmann::json::parse(report_json(sample_report()));
    document[nlohmann::json::json_pointer(pointer)] = value;
    bad.push_back(document.dump());
  };
  damage("/schema", "backbend.report/2");
  damage("/findings/0/verdict", "fine");
  damage("/findings/0/value", "9.1");
  damage("/findings/0/frame", 7);
  damage("/findings/0/place", {{"bone", "x"}});
  damage("/findings/0/image", "visible");
  damage("/rigs/0/headroom/0", nlohmann::json::object());
  damage("/rigs/0/coverage/0/planned", -1);
  damage("/surprise", true);
  damage("/findings/1/artist", "cmds.setAttr()");
  damage("/findings/1/artist/maya", 3);
  damage("/findings/1/pictures/other_rig", nullptr);
  damage("/calibration", nlohmann::json::object());
  damage("/calibration/0/clean_poses", -1);
  damage("/calibration/0/smallest", "2 deg");
  const auto output =
      python("jsonschema", R"(
import json, jsonschema
schema = json.load(open('schema.json'))
jsonschema.Draft7Validator.check_schema(schema)
validator = jsonschema.Draft7Validator(schema)
for text in json.load(open('good.json')):
    for error in validator.iter_errors(json.loads(text)):
        print('good report refused:', error.json_path, error.message[:200])
print(sum(validator.is_valid(json.loads(text)) for text in json.load(open('bad.json'))), 'damaged accepted')
)",
             {{"schema.json", std::string(report_schema())},
              {"good.json", all_as_json(30, [](const Report& r) { return report_json(r); })},
              {"bad.json", bad.dump()}});
  if (!output) {
    ASSERT_EQ(std::getenv("CI"), nullptr) << "python3-jsonschema is not installed";
    GTEST_SKIP() << "python3-jsonschema is not installed";
  }
  EXPECT_EQ(*output, "0 damaged accepted\n");
  // Our own reader and the schema agree on the same documents.
  for (const auto& text : bad) EXPECT_THROW(parse_report(text.get<std::string>()), ReportError);
}

TEST(Page, TakesPicturesInsideOnlyWhenGivenTheirBytes) {
  const Report report = sample_report();
  const std::string folder = render_html_page(report);
  EXPECT_EQ(folder.find("data:image/png;base64,"), std::string::npos);
  std::set<std::string> asked;
  const std::string single = render_html_page(
      report, [&](const std::string& path) -> std::optional<std::vector<std::uint8_t>> {
        asked.insert(path);
        if (path != "sheets/extension.png") return std::nullopt;
        return std::vector<std::uint8_t>{'M', 'a'};
      });
  EXPECT_TRUE(asked.contains("sheets/extension.png"));
  EXPECT_FALSE(asked.contains(""));
  EXPECT_NE(single.find("{\"sheets/extension.png\":\"data:image/png;base64,TWE=\"}"),
            std::string::npos);
}

TEST(Page, PacksALargeReport) {
  const std::string small = render_html_page(sample_report());
  EXPECT_NE(small.find("<script type=\"application/json\" id=\"report\">"), std::string::npos);
  const Report large = sample_report_of(10000);
  const std::string json = report_json_compact(large);
  ASSERT_GT(json.size(), 4U << 20);
  const std::string page = render_html_page(large);
  EXPECT_EQ(page.find("<script type=\"application/json\" id=\"report\">"), std::string::npos);
  EXPECT_LT(page.size(), small.size() + json.size() / 3);
  EXPECT_EQ(page, render_html_page(large));
}

TEST(Page, TakesTheMeshesOfTheWorstFindingsUpToItsLimit) {
  Report report = sample_report();
  report.meshes.clear();
  for (int i = 0; i < 60; ++i) {
    MeshView view;
    view.pose_path = "findings/" + std::to_string(i) + "/mesh.pose";
    view.triangles_path = "meshes/" + std::to_string(i / 2) + ".triangles";
    view.finding = i == 0 ? -1 : 60 - i;
    report.meshes.push_back(view);
  }
  // The worst is too large alone; each two of the others share their triangles and take 0.6 MB.
  const auto bytes = [](const std::string& path) {
    return std::optional(
        std::vector<std::uint8_t>(path == "findings/59/mesh.pose" ? 5 << 20 : 200000));
  };
  const std::string page = render_html(report, bytes).at("index.html");
  const auto has = [](const std::string& text, int i) {
    return text.find("\"findings/" + std::to_string(i) + "/mesh.pose\":\"data:") !=
           std::string::npos;
  };
  EXPECT_FALSE(has(page, 59));
  for (int i = 58; i > 45; --i) EXPECT_TRUE(has(page, i)) << i;
  EXPECT_FALSE(has(page, 0));
  EXPECT_FALSE(has(page, 40));
  EXPECT_LT(page.size(), 7U << 20);
  const std::string alone = render_html_page(report, bytes);
  EXPECT_TRUE(has(alone, 59) && has(alone, 0));
}

TEST(Page, IsTheSameForTheSameReport) {
  EXPECT_EQ(render_html_page(sample_report()),
            render_html_page(parse_report(report_json(sample_report()))));
}

TEST(Page, HoldsNoAddressOnTheNetwork) {
  const std::string page = render_html_page(sample_report());
  for (const char* word : {"http://", "https://", "fetch(", "XMLHttpRequest", "WebSocket",
                           "innerHTML", "eval(", "@import", "url("}) {
    // The SVG namespace is a name, not an address; nothing is loaded from it.
    std::string text = page;
    for (std::size_t at; (at = text.find("http://www.w3.org/2000/svg")) != std::string::npos;)
      text.erase(at, 26);
    EXPECT_EQ(text.find(word), std::string::npos) << word;
  }
}

}  // namespace
}  // namespace backbend::validate
