#include "validate/report/markdown.h"

#include <algorithm>

#include "validate/compare/comparison.h"
#include "validate/model/digest.h"
#include "validate/model/search_text.h"
#include "validate/text/escape.h"
#include "validate/text/number_text.h"
#include "validate/verdicts/names.h"

namespace backbend::validate {
namespace {

/// A name or sentence from outside: at most this many columns, so that one hostile name cannot push
/// everything else out of the comment.
std::string code(std::string_view text) {
  constexpr std::size_t kLongest = 240;
  return markdown_code(fitted(visible(text), kLongest));
}

/// Text that only grows by whole pieces and never past its limit.
class Comment {
 public:
  explicit Comment(std::size_t limit) : limit_(limit) {}

  /// Adds `piece` if `reserve` more bytes would still fit after it.
  bool add(const std::string& piece, std::size_t reserve = 0) {
    if (text_.size() + piece.size() + reserve > limit_) return false;
    text_ += piece;
    return true;
  }
  /// A table: head, then as many rows as fit; says how many did not.
  void table(const std::string& head, const std::vector<std::string>& rows, const std::string& what,
             std::size_t reserve) {
    constexpr std::size_t kSaying = 120;  // room for the sentence below
    if (rows.empty() || !add(head, reserve + kSaying)) return;
    std::size_t shown = 0;
    while (shown < rows.size() && add(rows[shown], reserve + kSaying)) ++shown;
    if (shown < rows.size())
      add(std::string("\n") + std::to_string(rows.size() - shown) + " more " + what +
          " are in report.json and on the page.\n");
    add("\n");
  }
  std::string take() { return std::move(text_); }

 private:
  std::size_t limit_;
  std::string text_;
};

std::vector<std::string> headroom_rows(const Report& report) {
  std::vector<std::string> rows;
  for (const RigResult& rig : report.rigs) {
    if (rig.role == Role::canary) continue;
    for (const Headroom& h : rig.headroom) {
      const bool short_of = !h.measured || !(h.clean_to_deg >= h.needs_deg);
      const std::string bold = short_of ? "**" : "";
      const std::string left = h.measured ? with_sign(h.headroom_deg(), 0) : "not measured";
      rows.push_back("| " + code(rig.character) + " | " + code(rig.rig) + " | " +
                     code(rig.mapping) + " | " + std::string(role_word(rig.role)) + " | " +
                     code(h.channel) + " | " +
                     (h.measured ? fixed(h.clean_to_deg, 0) : "not measured") + " | " +
                     fixed(h.needs_deg, 0) + " | " + bold + left + bold + " |\n");
    }
    if (const CleanVolume& v = rig.volume; v.poses > 0)
      rows.push_back("| " + code(rig.character) + " | " + code(rig.rig) + " | " +
                     code(rig.mapping) + " | " + std::string(role_word(rig.role)) + " | volume | " +
                     code(sampled_summary(v)) + " | 100 % | " + code(certified_summary(v)) +
                     " |\n");
    const Corners& c = rig.corners;
    if (!c.needed && c.poses == 0) continue;
    const std::string bold = c.covered() && c.clean == c.poses ? "" : "**";
    rows.push_back("| " + code(rig.character) + " | " + code(rig.rig) + " | " + code(rig.mapping) +
                   " | " + std::string(role_word(rig.role)) + " | corners | " +
                   (c.poses > 0
                        ? std::to_string(c.clean) + " of " + std::to_string(c.poses) + " poses"
                        : "not measured") +
                   " | 100 % | " + bold +
                   (c.poses == 0      ? "not measured"
                    : c.worst.empty() ? "clean"
                                      : "worst: " + code(c.worst)) +
                   bold + " |\n");
  }
  return rows;
}

std::vector<std::string> finding_rows(const Report& report, const Digest& digest) {
  std::vector<std::string> rows;
  for (const Finding* f : digest.worst(report.findings.size())) {
    const Role role = digest.role_of(*f);
    std::string verdict(verdict_word(f->verdict));
    std::replace(verdict.begin(), verdict.end(), '_', ' ');
    if (role == Role::reference) verdict = "comparison rig";
    if (f->verdict == Verdict::fail && role == Role::proposed) verdict = "**fail**";
    std::string check = f->code;
    if (const std::string name = finding_name(*f, digest); !name.empty()) check += ' ' + name;
    const std::string rig =
        f->character + " " + f->rig + (f->mapping.empty() ? "" : "/" + f->mapping);
    rows.push_back("| " + verdict + " | " + code(check) + " | " + code(rig) + " | " +
                   code(f->pose) + " | " + code(place_text(*f)) + " | " + code(value_text(*f)) +
                   " | " + std::string(owner_word(f->owner)) + " | " + code(f->detail) + " |\n");
  }
  return rows;
}

std::vector<std::string> comparison_rows(const Report& report) {
  std::vector<std::string> rows;
  for (const Comparison& c : report.comparisons) {
    std::string row = "| " + code(c.a) + " | " + code(c.b) + " | " + code(c.character) + " | " +
                      code(c.mapping) + " |";
    for (const int n : {c.paired, c.a_better, c.same, c.b_better, c.mixed})
      row += " " + std::to_string(n) + " |";
    rows.push_back(row + " " + std::to_string(c.a_over) + " : " + std::to_string(c.b_over) + " | " +
                   code(comparison_verdict(c)) + " |\n");
  }
  return rows;
}

std::string closing(const Report& report, const Digest::Counts& n) {
  std::string out = std::to_string(n.fail) + " in the required range, " + std::to_string(n.stress) +
                    " outside it, " + std::to_string(n.waived) + " waived, " +
                    std::to_string(n.not_measured) + " not measured, " +
                    std::to_string(n.not_applicable) + " not applicable.\n";
  const auto list = [&](const std::string& title, const std::vector<std::string>& items) {
    constexpr std::size_t kShown = 12;
    if (items.empty()) return;
    out += "\n" + title + "\n\n";
    for (std::size_t i = 0; i < std::min(items.size(), kShown); ++i) out += "- " + items[i] + "\n";
    if (items.size() > kShown) out += "- and " + std::to_string(items.size() - kShown) + " more\n";
  };
  std::vector<std::string> canaries, detectors, next;
  for (const CanaryResult& c : report.canaries)
    canaries.push_back((c.ok() ? "passed: " : "**failed**: ") + code(c.rig) + " " + code(c.code));
  for (const std::string& d : report.detectors) detectors.push_back(code(d));
  for (const std::string& n_ : report.next) next.push_back(code(n_));
  list("Self-tests", canaries);
  list("Detectors", detectors);
  list("Next", next);
  return out;
}

}  // namespace

std::string markdown_summary(const Report& report, std::size_t limit) {
  const Digest digest(report);
  Comment comment(limit);
  std::string word(verdict_word(report.verdict));
  std::replace(word.begin(), word.end(), '_', ' ');
  comment.add("### backbend: " + word + "\n\n" + code(report.title) + "\n\n" +
              code(report.headline) + "\n\n");
  for (std::size_t i = 0; i < std::min<std::size_t>(8, report.reasons.size()); ++i)
    comment.add("- " + code(report.reasons[i]) + "\n");
  comment.add("\n");
  const std::string end = closing(report, digest.counts());
  comment.table(
      "| character | rig | mapping | role | channel | clean to, deg | required | headroom |\n"
      "|---|---|---|---|---|--:|--:|--:|\n",
      headroom_rows(report), "channels", end.size());
  comment.table(
      "| side | against | character | mapping | poses | better | same | worse | mixed | over a "
      "limit "
      "| |\n|---|---|---|---|--:|--:|--:|--:|--:|--:|---|\n",
      comparison_rows(report), "comparisons", end.size());
  comment.table(
      "| verdict | check | rig | pose | place | value | owner | detail |\n"
      "|---|---|---|---|---|---|---|---|\n",
      finding_rows(report, digest), "findings", end.size());
  comment.add(end);
  return comment.take();
}

}  // namespace backbend::validate
