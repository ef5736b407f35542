#include "validate/report/handoff.h"

#include "validate/model/digest.h"
#include "validate/text/escape.h"
#include "validate/text/number_text.h"
#include "validate/verdicts/names.h"

namespace backbend::validate {
namespace {

constexpr std::size_t kLongestLine = 200;

}  // namespace

std::string headline_text(const Report& report) {
  const Digest digest(report);
  std::string text;
  const auto line = [&](const std::string& words) { text += fitted(words, kLongestLine) + "\n"; };
  line(std::string(verdict_word(report.verdict)) + ": " + visible(report.title));
  for (const RigResult& rig : report.rigs) {
    if (rig.role != Role::proposed) continue;
    for (const Headroom& h : rig.headroom)
      if (h.measured && h.headroom_deg() < 0)
        line(visible(rig.rig) + " (" + visible(rig.mapping) + ") on " + visible(rig.character) +
             ": " + visible(h.channel) + " clean to " + fixed(h.clean_to_deg, 0) + ", needs " +
             fixed(h.needs_deg, 0));
    const Corners& c = rig.corners;
    if (c.clean < c.poses)
      line(visible(rig.rig) + " (" + visible(rig.mapping) + ") on " + visible(rig.character) +
           ": " + std::to_string(c.clean) + " of " + std::to_string(c.poses) +
           " corner poses clean, worst " + visible(c.worst));
  }
  const Digest::Counts& n = digest.counts();
  line(std::to_string(n.fail) + " in the required range, " + std::to_string(n.stress) +
       " outside it, " + std::to_string(n.waived) + " waived, " + std::to_string(n.not_measured) +
       " not measured");
  for (const Finding* f : digest.worst(1))
    line("worst: " + visible(f->code) + " " + visible(digest.check_name(f->code)) + ", " +
         visible(f->rig) + " at " + visible(f->pose) + ", " + visible(value_text(*f)));
  return text;
}

std::string angles_csv(const Report& report) {
  std::string rows;
  for (const RigResult& rig : report.rigs)
    for (const SweepSeries& sweep : rig.sweeps)
      for (std::size_t i = 0; i < sweep.frame.size(); ++i) {
        if (sweep.frame[i].empty()) continue;
        rows += csv_text(rig.character) + "," + csv_text(rig.rig) + "," + csv_text(sweep.mapping) +
                "," + csv_text(sweep.sweep) + "," +
                std::to_string(kFirstFrame + static_cast<int>(i)) + "," +
                shortest(sweep.control_deg[i]) + "," + csv_text(sweep.frame[i]) + "\r\n";
      }
  return rows.empty() ? "" : "character,rig,mapping,sweep,frame,control_deg,picture\r\n" + rows;
}

}  // namespace backbend::validate
