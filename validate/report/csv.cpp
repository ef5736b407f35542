#include "validate/report/csv.h"

#include <cmath>
#include <set>

#include "validate/model/digest.h"
#include "validate/text/escape.h"
#include "validate/text/number_text.h"
#include "validate/verdicts/names.h"

namespace backbend::validate {
namespace {

class Row {
 public:
  Row& text(std::string_view value) { return cell(csv_text(value)); }
  Row& number(double value) { return cell(std::isfinite(value) ? shortest(value) : ""); }
  Row& index(int value) { return cell(value >= 0 ? std::to_string(value) : ""); }
  std::string end() { return line_ + "\r\n"; }

 private:
  Row& cell(const std::string& value) {
    if (!first_) line_ += ',';
    line_ += value;
    first_ = false;
    return *this;
  }
  bool first_ = true;
  std::string line_;
};

std::string row(const Finding& f) {
  return Row()
      .text(f.code)
      .text(f.character)
      .text(f.rig)
      .text(f.mapping)
      .text(f.sweep)
      .text(f.pose)
      .index(f.frame.value_or(-1))
      .number(f.control_deg)
      .text(place_text(f))
      .text(f.joint)
      .text(f.side)
      .text(f.part)
      .index(f.slice)
      .index(f.vertex)
      .number(f.value)
      .number(f.limit)
      .text(f.unit)
      .text(verdict_word(f.verdict))
      .text(owner_word(f.owner))
      .text(f.inside_envelope ? "yes" : "no")
      .text(!f.image.measured ? "not_measured"
            : f.image.visible ? "visible"
                              : "not_visible")
      .number(f.image.measured ? f.image.pixels : std::nan(""))
      .text(f.image.camera)
      .text(f.detail)
      .text(f.reproduce)
      .end();
}

}  // namespace

std::string findings_csv(const Report& report) {
  std::string out =
      "code,character,rig,mapping,sweep,pose,frame,control_deg,place,joint,side,mesh_part,slice,"
      "vertex,"
      "value,limit,unit,verdict,owner,inside_envelope,image,pixels,camera,detail,reproduce\r\n";
  for (const Finding& f : report.findings) out += row(f);
  return out;
}

std::string sweeps_csv(const Report& report) {
  std::set<std::string> metrics;
  for (const RigResult& rig : report.rigs)
    for (const SweepSeries& s : rig.sweeps)
      for (const auto& item : s.metric) metrics.insert(item.first);
  Row head;
  for (const char* name : {"character", "rig", "mapping", "sweep", "frame", "control_deg"})
    head.text(name);
  for (const std::string& name : metrics) head.text(name);
  std::string out = head.end();
  for (const RigResult& rig : report.rigs)
    for (const SweepSeries& s : rig.sweeps)
      for (std::size_t pose = 0; pose < s.control_deg.size(); ++pose) {
        Row line;
        line.text(rig.character).text(rig.rig).text(s.mapping).text(s.sweep);
        line.index(kFirstFrame + static_cast<int>(pose)).number(s.control_deg[pose]);
        for (const std::string& name : metrics) {
          const auto found = s.metric.find(name);
          const bool known = found != s.metric.end() && pose < found->second.size();
          line.number(known ? found->second[pose] : std::nan(""));
        }
        out += line.end();
      }
  return out;
}

}  // namespace backbend::validate
