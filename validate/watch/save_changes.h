#pragma once
#include <string>
#include <vector>

#include "validate/model/report.h"
#include "validate/text/terminal_style.h"

namespace backbend::validate {

/// One finding of a rig that decides, before a save and after it.
struct SaveChange {
  enum class Kind { worse, fresh, better, gone };
  Kind kind = Kind::fresh;
  const Finding* before = nullptr;  // null: fresh
  const Finding* now = nullptr;     // null: gone
};

/// What of `before` is otherwise in `now`: worse first, then new, better, gone; the furthest over
/// its limit first in each. Findings are the same where check, rig, mapping, sweep and joint are,
/// several of those in their order along the sweep; one is better or worse where the figure that
/// people read is, or where it decides now and did not, or the reverse. Both must outlive the
/// result.
std::vector<SaveChange> changes_between(const Report& before, const Report& now);

/// What one save shows.
struct SaveView {
  const Report* now = nullptr;
  const Report* before = nullptr;    // of the save before; null: this is the first
  const Report* complete = nullptr;  // `now` with pictures, which has the last word; null: not yet
  int save = 1;
  std::string changed;   // which files changed
  std::string seconds;   // from the save to the verdict, as text; empty: not shown
  std::string pictures;  // where they are, or that they follow
  std::string watching;  // what is looked at, and how
  int most_changes = 8;
};

/// Verdict, headroom per channel, what changed since the save before and the worst finding, as
/// lines that fit the style's width. Names are shown with every control character spelled out.
std::string save_text(const SaveView& view, const TerminalStyle& style);

}  // namespace backbend::validate
