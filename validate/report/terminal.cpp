#include "validate/report/terminal.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "validate/compare/comparison.h"
#include "validate/history/history_text.h"
#include "validate/model/digest.h"
#include "validate/model/search_text.h"
#include "validate/text/escape.h"
#include "validate/text/number_text.h"
#include "validate/verdicts/names.h"

namespace backbend::validate {
namespace {

enum class Ink { plain, red, green, yellow, dim, bold };

class Page {
 public:
  explicit Page(const TerminalStyle& style)
      : style_(style), width_(static_cast<std::size_t>(std::max(40, style.width))) {}

  std::size_t width() const { return width_; }
  bool unicode() const { return style_.unicode; }

  std::string ink(Ink ink, const std::string& text) const {
    if (!style_.color || ink == Ink::plain) return text;
    const char* code = ink == Ink::red      ? "31;1"
                       : ink == Ink::green  ? "32"
                       : ink == Ink::yellow ? "33"
                       : ink == Ink::dim    ? "2"
                                            : "1";
    return std::string("\x1b[") + code + "m" + text + "\x1b[0m";
  }

  /// One line: `head` in colour, then `rest`; the rest is cut where the line is full.
  void line(const std::string& head, const std::string& rest = {}, Ink head_ink = Ink::plain,
            Ink rest_ink = Ink::plain) {
    const std::string shown = fitted(head, width_);
    const std::size_t used = display_width(shown);
    text_ += ink(head_ink, shown) + ink(rest_ink, fitted(rest, width_ - used)) + '\n';
  }
  /// A line that must stay whole to be copied.
  void whole_line(const std::string& text) { text_ += text + '\n'; }
  /// Words of `text` over as many lines as they need, each starting with `indent` blanks.
  void paragraph(std::size_t indent, const std::string& text, Ink ink_of = Ink::plain);
  /// A paragraph whose first line starts with `head` instead of blanks.
  void headed(const std::string& head, const std::string& text, Ink head_ink, Ink text_ink);
  void blank() { text_ += '\n'; }
  std::string take() { return std::move(text_); }

 private:
  const TerminalStyle& style_;
  std::size_t width_;
  std::string text_;
};

void Page::headed(const std::string& head, const std::string& text, Ink head_ink, Ink text_ink) {
  const std::size_t start = text_.size();
  paragraph(head.size(), text, text_ink);
  if (text_.size() == start) text_ += std::string(head.size(), ' ') + '\n';
  text_.replace(start, head.size(), ink(head_ink, head));
}

void Page::paragraph(std::size_t indent, const std::string& text, Ink ink_of) {
  const std::size_t room = width_ - std::min(indent, width_ / 2);
  std::string current;
  const auto flush = [&] {
    if (!current.empty()) text_ += std::string(indent, ' ') + ink(ink_of, current) + '\n';
    current.clear();
  };
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t space = std::min(text.find(' ', at), text.size());
    const std::string word = fitted(text.substr(at, space - at), room);
    at = space + 1;
    if (word.empty()) continue;
    if (!current.empty() && display_width(current) + 1 + display_width(word) > room) flush();
    current += (current.empty() ? "" : " ") + word;
  }
  flush();
}

std::string count_of(int n, const std::string& what) { return std::to_string(n) + ' ' + what; }

bool falls_short(const Headroom& h) { return !h.measured || !(h.clean_to_deg >= h.needs_deg); }

/// Clean as far as it was measured, which is not as far as it has to be.
bool ends_early(const Headroom& h) {
  return h.measured && !h.covered() && h.clean_to_deg >= h.tested_to_deg;
}

bool falls_short(const Corners& c) { return !c.covered() || c.clean < c.poses; }

std::string corners_share(const Corners& c) {
  // 99.6 % is not all of them.
  return c.poses == 0 ? "?" : fixed(std::floor(c.clean_percent()), 0) + " %";
}

std::string bar(const Headroom& h, std::size_t cells, bool unicode) {
  const double end = std::max({h.tested_to_deg, h.needs_deg, 1.0});
  const double part = h.measured && std::isfinite(h.clean_to_deg)
                          ? std::clamp(h.clean_to_deg / end, 0.0, 1.0)
                          : 0.0;
  const auto full = static_cast<std::size_t>(std::lround(part * static_cast<double>(cells)));
  std::string text;
  for (std::size_t i = 0; i < cells; ++i)
    text += unicode ? (i < full ? "\xe2\x96\x88" : "\xe2\x96\x91") : (i < full ? "#" : ".");
  return text;
}

/// One rig alone: the row of first-ten-minutes, with a bar.
void headroom_table(Page& page, const RigResult& rig) {
  constexpr std::size_t kName = 14;
  page.line("  " + padded("", kName) + " clean to   required   headroom", "", Ink::dim);
  for (const Headroom& h : rig.headroom) {
    const bool untested_beyond = h.measured && h.clean_to_deg >= h.tested_to_deg;
    const std::string left =
        h.measured ? with_sign(h.headroom_deg(), 0) + (falls_short(h) ? " X" : "  ") : "?  ";
    std::string row = "  " + padded(visible(h.channel), kName);
    const auto right = [](const std::string& text, std::size_t width) {
      return std::string(width - std::min(width, text.size()), ' ') + text;
    };
    row += right(clean_text(h), 6) + (h.measured ? " deg" : "    ") +
           right(fixed(h.needs_deg, 0), 9) + right(left, 12) + "  ";
    const std::string note = !h.measured     ? "not measured"
                             : ends_early(h) ? "not measured beyond " + fixed(h.tested_to_deg, 0)
                             : untested_beyond && h.headroom_deg() == 0 ? "met; not tested further"
                             : page.width() < display_width(row) + 16   ? ""
                                                                      : bar(h, 16, page.unicode());
    page.line(row, note, falls_short(h) ? Ink::red : Ink::plain,
              falls_short(h) ? Ink::red : Ink::green);
  }
  for (const RigHeadroom& other : rig.beside)
    page.line(
        "  " + padded(visible(other.system), kName) + " here: " + headroom_text(other.headroom), "",
        Ink::dim);
  const Corners& c = rig.corners;
  if (!c.needed && c.poses == 0) return;
  const auto right = [](const std::string& text, std::size_t width) {
    return std::string(width - std::min(width, text.size()), ' ') + text;
  };
  const Ink ink = falls_short(c) ? Ink::red : Ink::plain;
  page.line("  " + padded("corners", kName) + right(corners_share(c), 8) + right("100 %", 9) +
                right(falls_short(c) ? "X" : "", 11) + "  ",
            c.poses == 0      ? "not measured"
            : c.worst.empty() ? std::to_string(c.poses) + " poses"
                              : "worst: " + visible(c.worst) + " (" + visible(c.code) + ")",
            ink, falls_short(c) ? Ink::red : Ink::green);
}

/// Several rigs on one character under one mapping: a column each.
void comparison_table(Page& page, const std::vector<const RigResult*>& rigs) {
  std::vector<std::string> channels;
  for (const RigResult* rig : rigs)
    for (const Headroom& h : rig->headroom)
      if (std::find(channels.begin(), channels.end(), h.channel) == channels.end())
        channels.push_back(h.channel);
  // As many rigs as fit, each as wide as its name needs.
  std::vector<std::size_t> column;
  std::string head = padded("", 16) + padded("required", 10), roles = padded("", 26);
  for (const RigResult* rig : rigs) {
    const std::string name = visible(rig->rig);
    const std::size_t width = std::clamp<std::size_t>(display_width(name) + 2, 11, 24);
    if (!column.empty() && display_width(head) + width > page.width()) break;
    column.push_back(width);
    head += padded(fitted(name, width - 1), width);
    roles += padded(role_word(rig->role), width);
  }
  const std::size_t shown = column.size();
  page.line(head,
            shown < rigs.size() ? count_of(static_cast<int>(rigs.size() - shown), "more") : "");
  page.line(roles, "", Ink::dim);
  for (const std::string& channel : channels) {
    std::string needs = "-", cells;
    bool proposed_short = false;
    for (std::size_t i = 0; i < shown; ++i) {
      std::string cell = "-";
      for (const Headroom& h : rigs[i]->headroom)
        if (h.channel == channel) {
          needs = fixed(h.needs_deg, 0);
          cell = clean_text(h);
          if (h.measured) cell.append(1, ' ').append(with_sign(h.headroom_deg(), 0));
          if (falls_short(h)) cell += " X";
          proposed_short |= falls_short(h) && rigs[i]->role == Role::proposed;
        }
      cells += padded(cell, column[i]);
    }
    page.line("  " + padded(visible(channel), 14) + padded(needs, 10) + cells, "",
              proposed_short ? Ink::red : Ink::plain);
  }
  std::string cells;
  bool any = false, proposed_short = false;
  for (std::size_t i = 0; i < shown; ++i) {
    const Corners& c = rigs[i]->corners;
    const bool has = c.needed || c.poses > 0;
    any = any || has;
    proposed_short |= has && falls_short(c) && rigs[i]->role == Role::proposed;
    cells += padded(has ? corners_share(c) + (falls_short(c) ? " X" : "") : "-", column[i]);
  }
  if (any)
    page.line("  " + padded("corners", 14) + padded("100 %", 10) + cells, "",
              proposed_short ? Ink::red : Ink::plain);
}

/// How each rig bends over its leading sweep: one row of marks per rig, all on their own scale.
void kink_sparks(Page& page, const std::vector<const RigResult*>& rigs) {
  constexpr std::size_t kName = 14, kMost = 24;
  for (const RigResult* rig : rigs) {
    if (rig->sweeps.empty()) continue;
    const SweepSeries& sweep = rig->sweeps.front();
    const auto metric = std::find_if(
        sweep.metric.begin(), sweep.metric.end(),
        [](const auto& each) { return each.first == "chain_kink" || each.first == "kink"; });
    if (metric == sweep.metric.end()) continue;
    double worst = std::nan("");
    for (const double value : metric->second)
      if (std::isfinite(value) && !(worst >= value)) worst = value;
    // Every n-th pose, so that the whole sweep is in sight.
    const std::size_t step = (metric->second.size() + kMost - 1) / kMost;
    std::vector<double> shown;
    for (std::size_t i = 0; i < metric->second.size(); i += step)
      shown.push_back(metric->second[i]);
    page.line("  " + padded(visible(rig->rig), kName) + " ",
              sparkline(shown, kMost, page.unicode()) + "  kink to " +
                  (std::isfinite(worst) ? significant(worst, 3) : "-") + " deg over " +
                  visible(sweep.sweep),
              Ink::plain, Ink::dim);
  }
}

void headroom(Page& page, const Report& report) {
  std::vector<const RigResult*> rest;
  for (const RigResult& rig : report.rigs)
    if (rig.role != Role::canary && !rig.headroom.empty()) rest.push_back(&rig);
  while (!rest.empty()) {
    const RigResult& first = *rest.front();
    std::vector<const RigResult*> group, others;
    for (const RigResult* rig : rest)
      (rig->character == first.character && rig->mapping == first.mapping ? group : others)
          .push_back(rig);
    const std::string mapping = first.mapping.empty() ? "" : ", mapping " + visible(first.mapping);
    page.line("  " + visible(first.character) + mapping + ", degrees each channel is clean to", "",
              Ink::bold);
    if (group.size() == 1)
      headroom_table(page, first);
    else
      comparison_table(page, group);
    kink_sparks(page, group);
    page.blank();
    rest = others;
  }
}

void counts(Page& page, const Report& report, const Digest& digest) {
  const Digest::Counts& n = digest.counts();
  std::string text = count_of(n.fail, n.fail == 1 ? "failure" : "failures") +
                     " in the required range, " + count_of(n.stress, "outside it") + ", " +
                     count_of(n.not_measured, "not measured") + ", " +
                     count_of(n.not_applicable, "not applicable");
  if (n.waived > 0) text += ", " + count_of(n.waived, "waived");
  page.paragraph(2, text, report.verdict == Verdict::pass ? Ink::green : Ink::plain);
  if (n.reference > 0)
    page.paragraph(2, std::to_string(n.reference) +
                          (n.reference == 1 ? " on a comparison rig, which does not decide"
                                            : " on comparison rigs, which do not decide"));
}

void finding(Page& page, const Finding& f, const Digest& digest) {
  const Role role = digest.role_of(f);
  const bool decides = f.verdict == Verdict::fail && role == Role::proposed;
  std::string head = std::string(decides ? "  X " : "  - ") + visible(f.code);
  if (const std::string check = finding_name(f, digest); !check.empty())
    head += ' ' + visible(check);
  const std::string pose = "  " + visible(f.pose);
  std::string place = visible(place_text(f)), end;
  if (f.owner != Owner::none) end += "  " + std::string(owner_word(f.owner));
  if (role == Role::reference)
    end += "  comparison rig";
  else if (f.verdict == Verdict::stress || !f.inside_envelope)
    end += f.inside_envelope ? "  shown" : "  outside the required range";
  else if (!decides)
    end += "  " + visible(verdict_word(f.verdict));
  // A place that has no room beside the owner starts the next line.
  const bool fits = display_width(head + pose + end) + 2 + display_width(place) <= page.width();
  page.line(head, pose + (fits && !place.empty() ? "  " + place : "") + end,
            decides ? Ink::red : Ink::yellow);
  std::string detail = fits || place.empty() ? "" : place + ": ";
  detail += visible(value_text(f)) + ", rig " + visible(f.rig);
  if (!f.mapping.empty()) detail += ", " + visible(mapping_words(f.mapping));
  if (!f.detail.empty()) detail += "; " + visible(f.detail);
  if (!f.image.measured)
    detail += "; image not measured";
  else if (f.image.visible)
    detail += "; visible: " + significant(f.image.pixels, 3) + " px " + visible(f.image.camera);
  else
    detail += "; not visible in pictures";
  page.paragraph(6, detail);
}

std::string side_text(const Comparison& c, const ComparedPose& p) {
  return visible(p.pose) + ": " + visible(c.a) + ' ' + significant(p.a, 3) + ", " + visible(c.b) +
         ' ' + significant(p.b, 3) + ' ' + visible(p.unit);
}

/// The grid of poses as marks: a row for each side bend, a block for each twist.
void pose_map(Page& page, const Comparison& c) {
  std::map<int, std::map<int, std::string>> rows;  // by side, by twist: marks over extension
  std::size_t columns = 0;
  double last = 0;
  for (const SweepComparison& sweep : c.sweeps) {
    if (!sweep.sweep.starts_with("grid ") || sweep.marks.empty()) continue;
    const auto of = [&](const char* channel) {
      const auto found = sweep.pose_deg.find(channel);
      return found == sweep.pose_deg.end() || found->second.empty()
                 ? 0
                 : static_cast<int>(std::lround(found->second.front()));
    };
    rows[of("side")][of("twist")] = sweep.marks;
    columns = std::max(columns, sweep.marks.size());
    if (!sweep.control_deg.empty()) last = sweep.control_deg.back();
  }
  if (rows.empty()) return;
  page.line(
      "  side   twist " +
          [&] {
            std::string head;
            for (const auto& [twist, marks] : rows.begin()->second)
              head += padded(std::to_string(twist), columns + 2);
            return head;
          }(),
      "", Ink::dim);
  for (const auto& [side, cells] : rows) {
    std::string text;
    for (const auto& [twist, marks] : cells) text += padded(marks, columns + 2);
    page.line("  " + padded(std::to_string(side), 13) + text);
  }
  page.paragraph(2,
                 "each row of marks: extension 0 to " + fixed(last, 0) + "; + " + visible(c.a) +
                     " is better, - " + visible(c.b) + " is, x each in something, = neither",
                 Ink::dim);
}

std::string where(const Comparison& c) {
  return visible(c.character) + (c.mapping.empty() ? "" : ", " + visible(c.mapping));
}

void comparison(Page& page, const Comparison& c) {
  page.line("  " + visible(c.a) + " against " + visible(c.b), "  " + where(c), Ink::bold);
  page.paragraph(
      4, count_of(c.paired, "poses paired") +
             (c.unpaired > 0 ? ", " + std::to_string(c.unpaired) + " without a partner" : "") +
             (std::isfinite(c.matched)
                  ? ", " + fixed(100.0 * c.matched, 1) + " % of the surface matched"
                  : "") +
             ": better " + std::to_string(c.a_better) + ", same " + std::to_string(c.same) +
             ", worse " + std::to_string(c.b_better) + ", mixed " + std::to_string(c.mixed) +
             "; over a limit " + std::to_string(c.a_over) + " against " + std::to_string(c.b_over) +
             ": " + visible(comparison_verdict(c)));
  if (!c.sampled.empty()) page.paragraph(4, visible(c.sampled));
  for (const MetricComparison& m : c.metrics) {
    if (m.a_better + m.b_better == 0) continue;
    std::string name = m.metric;
    std::replace(name.begin(), name.end(), '_', ' ');
    // A difference by rounding is not shown.
    const double gain = std::abs(m.median_gain) < 1e-6 * m.tolerance ? 0.0 : m.median_gain;
    page.line("    " + visible(m.code) + ' ' + padded(visible(name), 20),
              "better " + padded(std::to_string(m.a_better), 6) + "worse " +
                  padded(std::to_string(m.b_better), 6) + "median " + (gain > 0 ? "+" : "") +
                  significant(gain, 2) + ' ' + visible(m.unit));
  }
  const auto worst = [&](const std::string& side, const std::vector<ComparedPose>& poses) {
    for (const ComparedPose& p : poses)
      page.paragraph(4, "against " + visible(side) + " " + visible(p.code) + " " + side_text(c, p));
  };
  worst(c.a, c.worst_of_a);
  worst(c.b, c.worst_of_b);
  pose_map(page, c);
}

/// Several comparisons: a row each, under a line for every side that is set against others.
void comparison_rows(Page& page, const std::vector<Comparison>& all) {
  const Comparison* before = nullptr;
  for (const Comparison& c : all) {
    if (before == nullptr || before->a != c.a || before->character != c.character ||
        before->mapping != c.mapping)
      page.line("  " + visible(c.a) + ", pose by pose against", "  " + where(c), Ink::bold);
    before = &c;
    page.line("  " + padded(visible(c.b), 14) + " better " + padded(std::to_string(c.a_better), 5) +
                  "worse " + padded(std::to_string(c.b_better), 5) + "mixed " +
                  padded(std::to_string(c.mixed), 5) + "over a limit " +
                  padded(std::to_string(c.a_over) + " : " + std::to_string(c.b_over), 10),
              c.ahead == "a"   ? "ahead"
              : c.ahead == "b" ? "behind"
                               : "draw",
              c.ahead == "b" ? Ink::red : Ink::plain);
  }
}

void comparisons(Page& page, const Report& report) {
  if (report.comparisons.empty()) return;
  if (report.comparisons.size() == 1)
    comparison(page, report.comparisons.front());
  else
    comparison_rows(page, report.comparisons);
  page.blank();
}

/// What the search between the sweeps looked at, rig by rig.
void searches(Page& page, const Report& report) {
  for (const RigResult& rig : report.rigs) {
    const CompoundSearch& s = rig.search;
    if (s.paths == 0) continue;
    const std::string jumps =
        s.with_jumps == 0 ? "no jump" : "jumps on " + std::to_string(s.with_jumps);
    page.headed("  search    ",
                visible(rig.rig) + (rig.mapping.empty() ? "" : "/" + visible(rig.mapping)) + ": " +
                    jumps + (s.with_jumps == 0 ? " on " : " of ") + std::to_string(s.paths) +
                    " compound paths, " + std::to_string(s.poses) + " poses of " + s.box +
                    (s.unsure > 0 ? "; " + std::to_string(s.unsure) + " not certified" : ""),
                Ink::dim, s.with_jumps > 0 ? Ink::yellow : Ink::plain);
  }
}

/// What was searched for the worst poses, and how much of the envelope is clean.
void hunts(Page& page, const Report& report) {
  for (const RigResult& rig : report.rigs) {
    const std::string who =
        visible(rig.rig) + (rig.mapping.empty() ? "" : "/" + visible(rig.mapping)) + ": ";
    const bool found =
        std::ranges::any_of(rig.hunt.worst, [](const HuntedPose& each) { return each.sweep >= 0; });
    if (const std::string text = hunt_summary(rig.hunt); !text.empty())
      page.headed("  hunt      ", who + visible(text), Ink::dim, found ? Ink::yellow : Ink::plain);
    if (const std::string text = volume_summary(rig.volume); !text.empty())
      page.headed("  volume    ", who + visible(text), Ink::dim, Ink::plain);
  }
}

void canaries(Page& page, const Report& report) {
  // A clip's planted fault stands at a frame, a rig's at a control angle.
  const bool frames = std::any_of(report.rigs.begin(), report.rigs.end(),
                                  [](const RigResult& rig) { return rig.system == "clip"; });
  const auto at = [&](double value) {
    return frames ? "at frame " + significant(value, 6) : "at " + significant(value, 6) + " deg";
  };
  for (const CanaryResult& c : report.canaries) {
    std::string text = visible(c.rig) + ": " + visible(c.code) + ' ';
    text += !c.found ? "NOT detected, expected " + at(c.expected_deg)
            : c.ok() ? "detected " + at(c.found_deg) + " (expected)"
                     : "detected " + at(c.found_deg) + ", but its repaired twin is not clean";
    page.headed("  self-test ", text, c.ok() ? Ink::dim : Ink::red, c.ok() ? Ink::plain : Ink::red);
  }
}

}  // namespace

std::string terminal_summary(const Report& report, const TerminalStyle& style) {
  Page page(style);
  const Digest digest(report);
  std::string word(verdict_word(report.verdict));
  for (char& c : word) c = c == '_' ? ' ' : static_cast<char>(c >= 'a' && c <= 'z' ? c - 32 : c);
  const Ink ink = report.verdict == Verdict::pass   ? Ink::green
                  : report.verdict == Verdict::fail ? Ink::red
                                                    : Ink::yellow;
  // No side of a comparison passes for being better than the other.
  if (report.is_comparison && report.verdict == Verdict::pass) word = "COMPARED";
  headroom(page, report);
  comparisons(page, report);
  page.line(word, "  " + visible(report.title), ink, Ink::bold);
  if (!report.headline.empty()) page.paragraph(2, visible(report.headline));
  for (const std::string& reason : report.reasons) page.paragraph(2, visible(reason));
  counts(page, report, digest);
  const auto shown = digest.worst(static_cast<std::size_t>(std::max(0, style.worst)));
  for (const Finding* f : shown) {
    finding(page, *f, digest);
    if (f != shown.front()) continue;
    for (const auto& [program, line] : f->artist)
      page.whole_line("      " + visible(program) + ": " + visible(line));
  }
  searches(page, report);
  hunts(page, report);
  canaries(page, report);
  for (const std::string& detector : report.detectors)
    page.headed("  detectors ", visible(detector), Ink::dim, Ink::plain);
  if (!style.page.empty() || !report.next.empty()) page.blank();
  if (!style.page.empty()) page.whole_line("  page  " + visible(style.page));
  std::string head = "  next  ";
  for (const std::string& command : report.next) {
    page.whole_line(head + visible(command));
    head = "        ";
  }
  if (report.is_comparison && !report.comparisons.empty()) {
    page.blank();
    page.paragraph(0, visible(comparison_summary(report)), Ink::bold);
  }
  return page.take();
}

std::string comparisons_text(const Report& report, const TerminalStyle& style) {
  Page page(style);
  for (const Comparison& each : report.comparisons) {
    comparison(page, each);
    page.blank();
  }
  return page.take();
}

}  // namespace backbend::validate
