#include "validate/watch/save_changes.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "validate/model/digest.h"
#include "validate/text/escape.h"
#include "validate/text/number_text.h"
#include "validate/verdicts/checks.h"
#include "validate/verdicts/names.h"

namespace backbend::validate {
namespace {

using Key =
    std::tuple<std::string, std::string, std::string, std::string, std::string, std::string>;

/// Findings that a person would act on, by what makes them the same one in two reports.
std::map<Key, std::vector<const Finding*>> open_findings(const Report& report) {
  const Digest digest(report);
  std::map<Key, std::vector<const Finding*>> found;
  for (const Finding& f : report.findings) {
    if (digest.role_of(f) != Role::proposed || f.verdict == Verdict::pass ||
        f.verdict == Verdict::not_applicable)
      continue;
    found[{f.code, f.character, f.rig, f.mapping, f.sweep, f.joint}].push_back(&f);
  }
  for (auto& [key, list] : found) {
    std::stable_sort(list.begin(), list.end(), [](const Finding* a, const Finding* b) {
      return a->control_deg < b->control_deg;
    });
  }
  return found;
}

/// How much a verdict decides.
int weight(Verdict verdict) {
  return verdict == Verdict::fail ? 3 : verdict == Verdict::not_measured ? 2 : 1;
}

/// 1: worse, -1: better, 0: the same to whoever reads it.
int direction(const Finding& before, const Finding& now) {
  if (weight(before.verdict) != weight(now.verdict))
    return weight(now.verdict) > weight(before.verdict) ? 1 : -1;
  if (quantity_text(before, before.value) == quantity_text(now, now.value)) return 0;
  // What could not be measured before, and is open still, is no better.
  if (!std::isfinite(before.value) || !std::isfinite(now.value))
    return std::isfinite(now.value) ? 0 : 1;
  const Check* check = find_check(now.code);
  const bool low_is_bad = check != nullptr && check->sense == Sense::at_least;
  return (now.value > before.value) != low_is_bad ? 1 : -1;
}

const Finding& shown(const SaveChange& change) {
  return change.now != nullptr ? *change.now : *change.before;
}

std::string_view kind_word(SaveChange::Kind kind) {
  switch (kind) {
    case SaveChange::Kind::worse:
      return "worse";
    case SaveChange::Kind::fresh:
      return "new";
    case SaveChange::Kind::better:
      return "better";
    case SaveChange::Kind::gone:
      break;
  }
  return "gone";
}

class Lines {
 public:
  explicit Lines(const TerminalStyle& style)
      : style_(style), width_(static_cast<std::size_t>(std::max(40, style.width))) {}

  void add(const std::string& text, const char* ink = "") {
    const std::string line = fitted(text, width_);
    text_ += style_.color && *ink != '\0' ? std::string("\x1b[") + ink + "m" + line + "\x1b[0m\n"
                                          : line + "\n";
  }
  std::string take() { return std::move(text_); }

 private:
  const TerminalStyle& style_;
  std::size_t width_;
  std::string text_;
};

constexpr const char *kRed = "31;1", *kGreen = "32", *kYellow = "33", *kDim = "2", *kBold = "1";

const Headroom* find_headroom(const Report* report, const RigResult& rig,
                              const std::string& channel) {
  if (report == nullptr) return nullptr;
  for (const RigResult& each : report->rigs) {
    if (each.character != rig.character || each.rig != rig.rig || each.mapping != rig.mapping)
      continue;
    for (const Headroom& h : each.headroom)
      if (h.channel == channel) return &h;
  }
  return nullptr;
}

void headroom(Lines& lines, const SaveView& view) {
  for (const RigResult& rig : view.now->rigs) {
    if (rig.role != Role::proposed) continue;
    for (const Headroom& h : rig.headroom) {
      std::string line = "  " + padded(visible(h.channel), 12);
      if (!h.measured) {
        lines.add(line + "not measured", kRed);
        continue;
      }
      line += "clean to " + padded(fixed(h.clean_to_deg, 0), 5) + "needs " +
              padded(fixed(h.needs_deg, 0), 5) + "headroom " + with_sign(h.headroom_deg(), 0);
      const Headroom* before = find_headroom(view.before, rig, h.channel);
      const bool differs = before != nullptr && before->measured &&
                           fixed(before->clean_to_deg, 0) != fixed(h.clean_to_deg, 0);
      if (differs) line += "  (clean to " + fixed(before->clean_to_deg, 0) + " before)";
      lines.add(line, h.headroom_deg() < 0 || !h.covered() ? kRed : "");
    }
    if (rig.corners.needed || rig.corners.poses > 0)
      lines.add("  " + padded("corners", 12) + std::to_string(rig.corners.clean) + " of " +
                    std::to_string(rig.corners.poses) + " poses clean",
                rig.corners.clean < rig.corners.poses || !rig.corners.covered() ? kRed : "");
  }
}

std::string named(const Finding& f, const Digest& digest) {
  const std::string name = finding_name(f, digest);
  return visible(f.code) + (name.empty() ? "" : " " + visible(name)) + ", " + visible(f.pose);
}

void changes(Lines& lines, const SaveView& view) {
  if (view.before == nullptr) return;
  const std::vector<SaveChange> all = changes_between(*view.before, *view.now);
  int count[4] = {};
  for (const SaveChange& each : all) ++count[static_cast<int>(each.kind)];
  const auto of = [&](SaveChange::Kind kind) {
    return std::to_string(count[static_cast<int>(kind)]) + " " + std::string(kind_word(kind));
  };
  lines.add(
      "since the save before: " +
          (all.empty() ? "the same findings"
                       : of(SaveChange::Kind::worse) + ", " + of(SaveChange::Kind::fresh) + ", " +
                             of(SaveChange::Kind::better) + ", " + of(SaveChange::Kind::gone)),
      kBold);
  const Digest digest(*view.now), earlier(*view.before);
  for (std::size_t i = 0; i < all.size(); ++i) {
    const SaveChange& each = all[i];
    if (static_cast<int>(i) == view.most_changes) {
      lines.add("  and " + std::to_string(all.size() - i) + " more", kDim);
      break;
    }
    std::string line = "  " + padded(kind_word(each.kind), 8) +
                       named(shown(each), each.now != nullptr ? digest : earlier) + ": ";
    if (each.before != nullptr && each.now != nullptr) {
      line += visible(quantity_text(*each.before, each.before->value)) + " -> " +
              visible(value_text(*each.now));
      if (each.before->verdict != each.now->verdict)
        line += ", was " + std::string(verdict_word(each.before->verdict));
    } else {
      line += visible(value_text(shown(each)));
    }
    const bool bad = each.kind == SaveChange::Kind::worse || each.kind == SaveChange::Kind::fresh;
    lines.add(line, bad ? kRed : kGreen);
  }
}

}  // namespace

std::vector<SaveChange> changes_between(const Report& before, const Report& now) {
  const auto earlier = open_findings(before), open = open_findings(now);
  std::vector<SaveChange> all;
  for (const auto& [key, list] : open) {
    const auto old = earlier.find(key);
    const std::size_t known = old == earlier.end() ? 0 : old->second.size();
    for (std::size_t i = 0; i < list.size(); ++i) {
      if (i >= known) {
        all.push_back({SaveChange::Kind::fresh, nullptr, list[i]});
        continue;
      }
      const int way = direction(*old->second[i], *list[i]);
      if (way != 0)
        all.push_back({way > 0 ? SaveChange::Kind::worse : SaveChange::Kind::better, old->second[i],
                       list[i]});
    }
  }
  for (const auto& [key, list] : earlier) {
    const auto still = open.find(key);
    for (std::size_t i = still == open.end() ? 0 : still->second.size(); i < list.size(); ++i)
      all.push_back({SaveChange::Kind::gone, list[i], nullptr});
  }
  std::stable_sort(all.begin(), all.end(), [](const SaveChange& a, const SaveChange& b) {
    if (a.kind != b.kind) return a.kind < b.kind;
    return times_over(shown(a)) > times_over(shown(b));
  });
  return all;
}

std::string save_text(const SaveView& view, const TerminalStyle& style) {
  Lines lines(style);
  const Report& report = view.complete != nullptr ? *view.complete : *view.now;
  const Digest digest(report);
  std::string word(verdict_word(report.verdict));
  for (char& c : word) c = c == '_' ? ' ' : static_cast<char>(c >= 'a' && c <= 'z' ? c - 32 : c);
  lines.add(word + "  " + visible(report.title), report.verdict == Verdict::pass   ? kGreen
                                                 : report.verdict == Verdict::fail ? kRed
                                                                                   : kYellow);
  std::string save = "  save " + std::to_string(view.save);
  if (!view.changed.empty()) save += ": " + visible(view.changed);
  if (!view.seconds.empty()) save += "; verdict after " + view.seconds + " s";
  lines.add(save, kDim);
  headroom(lines, view);
  const Digest::Counts& n = digest.counts();
  lines.add("  " + std::to_string(n.fail) + (n.fail == 1 ? " failure" : " failures") +
            " in the required range, " + std::to_string(n.stress) + " outside it, " +
            std::to_string(n.not_measured) + " not measured");
  changes(lines, view);
  for (const Finding* f : digest.worst(1)) {
    const std::string place = place_text(*f);
    lines.add("worst " + named(*f, digest) + ": " + visible(value_text(*f)) +
                  (f->owner == Owner::none ? "" : "  " + std::string(owner_word(f->owner))),
              f->verdict == Verdict::fail ? kRed : kYellow);
    if (!place.empty()) lines.add("  " + visible(place));
  }
  if (!view.pictures.empty()) lines.add(visible(view.pictures), kDim);
  if (!view.watching.empty()) lines.add(visible(view.watching), kDim);
  return lines.take();
}

}  // namespace backbend::validate
