#include "validate/model/report_json.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "validate/files/hash.h"
#include "validate/model/web_files.h"
#include "validate/text/escape.h"
#include "validate/text/number_text.h"
#include "validate/verdicts/names.h"

namespace backbend::validate {
namespace {

using nlohmann::json;

template <class T, class F>
json list(const std::vector<T>& items, F to_value) {
  json out = json::array();
  for (const T& item : items) out.push_back(to_value(item));
  return out;
}

json value(const Headroom& h) {
  return {{"channel", h.channel},
          {"clean_to_deg", h.clean_to_deg},
          {"tested_to_deg", h.tested_to_deg},
          {"needs_deg", h.needs_deg},
          {"headroom_deg", h.headroom_deg()},
          {"measured", h.measured}};
}

json value(const Corners& c) {
  return {{"poses", c.poses},   {"clean", c.clean}, {"clean_percent", c.clean_percent()},
          {"needed", c.needed}, {"worst", c.worst}, {"code", c.code}};
}

json value(const CompoundSearch& s) {
  return {{"paths", s.paths},
          {"poses", s.poses},
          {"with_jumps", s.with_jumps},
          {"unsure", s.unsure},
          {"box", s.box}};
}

json value(const HuntedPose& h, const std::vector<SweepSeries>& sweeps) {
  const std::string path = h.sweep < 0 ? "" : sweeps.at(static_cast<std::size_t>(h.sweep)).sweep;
  return {{"code", h.code},   {"unit", h.unit}, {"pose", h.pose}, {"value", h.value},
          {"limit", h.limit}, {"over", h.over}, {"sweep", path}};
}

json value(const PoseHunt& h, const std::vector<SweepSeries>& sweeps) {
  return {{"evaluations", h.evaluations},
          {"seed", h.seed},
          {"box", h.box},
          {"gap", h.gap},
          {"worst", list(h.worst, [&](const auto& w) { return value(w, sweeps); })},
          {"notes", h.notes}};
}

json value(const CleanVolume& v) {
  json certified;
  if (v.proved)
    certified = {
        {"share", v.certified}, {"no_jump", v.no_jump}, {"refuted", v.refuted}, {"gain", v.gain}};
  return {{"box", v.box},
          {"certified", certified},
          {"not_certified", v.not_proved},
          {"searched",
           {{"poses", v.poses},
            {"clean", v.clean},
            {"at_least", v.at_least},
            {"confidence", kVolumeConfidence}}}};
}

json value(const SweepSeries& s) {
  return {{"sweep", s.sweep},
          {"channel", s.channel},
          {"mapping", s.mapping},
          {"control_deg", s.control_deg},
          {"metric", s.metric},
          {"metric_unit", s.metric_unit},
          {"metric_limit", s.metric_limit},
          {"frame", s.frame},
          {"pose_deg", s.pose_deg}};
}

json value(const Coverage& c) {
  return {{"code", c.code},
          {"planned", c.planned},
          {"measured", c.measured},
          {"not_measured", c.not_measured},
          {"not_applicable", c.not_applicable}};
}

json value(const RigResult& r) {
  json out = {{"character", r.character},
              {"rig", r.rig},
              {"system", r.system},
              {"mapping", r.mapping},
              {"role", role_word(r.role)},
              {"options", r.options},
              {"verdict", verdict_word(r.verdict)},
              {"headroom", list(r.headroom, [](const auto& h) { return value(h); })},
              {"corners", value(r.corners)},
              {"search", value(r.search)},
              {"sweeps", list(r.sweeps, [](const auto& s) { return value(s); })},
              {"coverage", list(r.coverage, [](const auto& c) { return value(c); })},
              {"summary", r.summary}};
  if (r.hunt.evaluations > 0 || !r.hunt.notes.empty()) out["hunt"] = value(r.hunt, r.sweeps);
  if (!r.volume.box.empty()) out["volume"] = value(r.volume);
  if (!r.beside.empty())
    out["beside"] = list(r.beside, [](const RigHeadroom& each) {
      return json{{"system", each.system},
                  {"headroom", list(each.headroom, [](const auto& h) { return value(h); })}};
    });
  return out;
}

json value(const CharacterFacts& c) {
  return {{"name", c.name},
          {"file", c.file},
          {"hash", c.hash},
          {"meshes", c.meshes},
          {"vertices", c.vertices},
          {"triangles", c.triangles},
          {"joints", c.joints},
          {"height", c.height},
          {"spine_length", c.spine_length},
          {"spine", c.spine},
          {"arms", {{"left", c.left_arm}, {"right", c.right_arm}}},
          {"sure", c.sure},
          {"kind", c.kind},
          {"kind_reason", c.kind_reason},
          {"envelope", c.envelope},
          {"envelope_reason", c.envelope_reason},
          {"notes", c.notes}};
}

json value(const ImageWitness& image) {
  if (!image.measured && image.note.empty()) return "not_measured";
  return {{"measured", image.measured}, {"visible", image.visible}, {"camera", image.camera},
          {"metric", image.metric},     {"value", image.value},     {"threshold", image.threshold},
          {"pixels", image.pixels},     {"note", image.note}};
}

json place(const Finding& f) {
  json out = json::object();
  if (!f.joint.empty()) out["joint"] = f.joint;
  if (!f.between[0].empty()) out["between"] = f.between;
  if (!f.side.empty()) out["side"] = f.side;
  if (!f.part.empty()) out["mesh_part"] = f.part;
  if (f.slice >= 0) out["slice"] = f.slice;
  if (f.vertex >= 0) out["vertex"] = f.vertex;
  return out;
}

json value(const FindingPictures& p) {
  json out = {{"before", p.before}, {"after", p.after}, {"heat", p.heat}, {"other", p.other}};
  if (!p.other_rig.empty()) out["other_rig"] = p.other_rig;
  if (!p.view.empty()) out["view"] = p.view;
  if (!p.heat_of.empty()) out["heat_of"] = p.heat_of;
  return out;
}

json value(const Finding& f) {
  const bool posed = f.at.pose >= 0;
  json out = {{"code", f.code},
              {"character", f.character},
              {"rig", f.rig},
              {"mapping", f.mapping},
              {"sweep", f.sweep},
              {"pose", f.pose},
              {"pose_index", posed ? json(f.at.pose) : json(nullptr)},
              {"frame", f.frame ? json(*f.frame) : json(nullptr)},
              {"time", f.time_s ? json(*f.time_s) : json(nullptr)},
              {"control_deg", f.control_deg},
              {"place", place(f)},
              {"value", f.value},
              {"limit", f.limit},
              {"unit", f.unit},
              {"verdict", verdict_word(f.verdict)},
              {"owner", owner_word(f.owner)},
              {"inside_envelope", f.inside_envelope},
              {"detail", f.detail},
              {"geometry", f.geometry},
              {"image", value(f.image)},
              {"pictures", value(f.pictures)},
              {"reproduce", f.reproduce}};
  if (!f.cures.empty())
    out["cures"] = list(f.cures, [](const Cure& each) {
      return json{{"command", each.command}, {"gives", each.gives}};
    });
  if (!f.artist.empty()) out["artist"] = f.artist;
  return out;
}

json value(const CanaryResult& c) {
  return {{"rig", c.rig},
          {"code", c.code},
          {"joint", c.joint},
          {"expected_deg", c.expected_deg},
          {"tolerance_deg", c.tolerance_deg},
          {"found_deg", c.found_deg},
          {"found", c.found},
          {"twin_clean", c.twin_clean},
          {"ok", c.ok()},
          {"detail", c.detail}};
}

json value(const CalibrationRow& c) {
  return {{"detector", c.detector},
          {"code", c.code},
          {"body", c.body},
          {"unit", c.unit},
          {"threshold", c.threshold},
          {"threshold_unit", c.threshold_unit},
          {"compared", c.compared},
          {"alike", c.alike},
          {"clean_poses", c.clean},
          {"target", c.target},
          {"false_alarms", c.false_alarms},
          {"smallest", c.smallest},
          {"ok", c.ok}};
}

json value(const ComparedPose& p) {
  return {{"sweep", p.sweep},
          {"pose", p.pose},
          {"index", p.at.pose},
          {"control_deg", p.control_deg},
          {"code", p.code},
          {"unit", p.unit},
          {"a", p.a},
          {"b", p.b},
          {"limit", p.limit},
          {"a_path", p.a_path},
          {"b_path", p.b_path},
          {"a_command", p.a_command},
          {"b_command", p.b_command}};
}

json value(const MetricComparison& m) {
  return {{"metric", m.metric},     {"code", m.code},
          {"unit", m.unit},         {"tolerance", m.tolerance},
          {"a_better", m.a_better}, {"b_better", m.b_better},
          {"same", m.same},         {"median_gain", m.median_gain}};
}

json value(const SweepComparison& s) {
  return {{"sweep", s.sweep},
          {"pose_deg", s.pose_deg},
          {"control_deg", s.control_deg},
          {"marks", s.marks}};
}

json value(const Comparison& c) {
  return {{"a", c.a},
          {"b", c.b},
          {"character", c.character},
          {"mapping", c.mapping},
          {"matched", c.matched},
          {"paired", c.paired},
          {"unpaired", c.unpaired},
          {"a_better", c.a_better},
          {"b_better", c.b_better},
          {"mixed", c.mixed},
          {"same", c.same},
          {"a_over", c.a_over},
          {"b_over", c.b_over},
          {"ahead", c.ahead},
          {"sampled", c.sampled},
          {"metrics", list(c.metrics, [](const auto& m) { return value(m); })},
          {"worst_of_a", list(c.worst_of_a, [](const auto& p) { return value(p); })},
          {"worst_of_b", list(c.worst_of_b, [](const auto& p) { return value(p); })},
          {"sweeps", list(c.sweeps, [](const auto& s) { return value(s); })}};
}

json value(const PicturePair& p) {
  return {{"title", p.title},         {"caption", p.caption}, {"a_path", p.a_path},
          {"a_label", p.a_label},     {"b_path", p.b_path},   {"b_label", p.b_label},
          {"heat_path", p.heat_path}, {"finding", p.finding}};
}

json value(const MediaItem& m) { return {{"kind", m.kind}, {"title", m.title}, {"path", m.path}}; }

json value(const MeshView& m) {
  json out = {
      {"title", m.title},         {"pose_path", m.pose_path}, {"triangles_path", m.triangles_path},
      {"heat", m.heat},           {"unit", m.unit},           {"heat_low", m.heat_low},
      {"heat_high", m.heat_high}, {"finding", m.finding}};
  if (!m.view.empty()) out["view"] = m.view;
  if (!m.mark.empty()) out["mark"] = m.mark;
  return out;
}

json value(const TrendStep& s) {
  return {{"night", s.night},        {"before", s.before},   {"after", s.after},
          {"worse", s.worse},        {"version", s.version}, {"last_before", s.last_before},
          {"recovered", s.recovered}};
}

json value(const Trend& t) {
  return {
      {"character", t.character}, {"rig", t.rig},
      {"mapping", t.mapping},     {"metric", t.metric},
      {"unit", t.unit},           {"more_is_worse", t.more_is_worse},
      {"value", t.value},         {"steps", list(t.steps, [](const auto& s) { return value(s); })}};
}

json value(const CheckLegend& c) {
  return {{"code", c.code},     {"name", c.name},   {"measures", c.measures}, {"unit", c.unit},
          {"reason", c.reason}, {"limit", c.limit}, {"sense", c.sense}};
}

json value(const Report& r) {
  json out = {{"schema", kReportSchemaName},
              {"title", r.title},
              {"suite", r.suite},
              {"headline", r.headline},
              {"reasons", r.reasons},
              {"verdict", verdict_word(r.verdict)},
              {"exit_code", r.exit_code},
              {"provenance", r.provenance},
              {"characters", list(r.characters, [](const auto& c) { return value(c); })},
              {"rigs", list(r.rigs, [](const auto& x) { return value(x); })},
              {"findings", list(r.findings, [](const auto& f) { return value(f); })},
              {"canaries", list(r.canaries, [](const auto& c) { return value(c); })},
              {"detectors", r.detectors},
              {"comparisons", list(r.comparisons, [](const auto& c) { return value(c); })},
              {"pairs", list(r.pairs, [](const auto& p) { return value(p); })},
              {"media", list(r.media, [](const auto& m) { return value(m); })},
              {"meshes", list(r.meshes, [](const auto& m) { return value(m); })},
              {"checks", list(r.checks, [](const auto& c) { return value(c); })},
              {"nights", r.nights},
              {"trends", list(r.trends, [](const auto& t) { return value(t); })},
              {"next", r.next}};
  if (r.is_comparison) out["is_comparison"] = true;
  if (!r.calibration.empty())
    out["calibration"] = list(r.calibration, [](const auto& c) { return value(c); });
  return out;
}

/// JSON text with our own number and string forms; `indent` < 0 writes one line.
class Writer {
 public:
  explicit Writer(bool lines) : lines_(lines) {}

  void write(const json& v, int depth = 0) {
    if (v.is_object())
      write_items(v, '{', '}', depth, true);
    else if (v.is_array())
      write_items(v, '[', ']', depth, has_structure(v));
    else if (v.is_string())
      text_ += json_text(v.get_ref<const std::string&>());
    else if (v.is_number_float())
      text_ += shortest(v.get<double>());
    else
      text_ += v.dump();
  }

  std::string take() { return std::move(text_); }

 private:
  static bool has_structure(const json& array) {
    return std::any_of(array.begin(), array.end(), [](const json& v) { return v.is_structured(); });
  }

  void write_items(const json& v, char open, char close, int depth, bool own_lines) {
    text_ += open;
    bool first = true;
    for (auto item = v.begin(); item != v.end(); ++item) {
      if (!first) text_ += ',';
      if (lines_ && own_lines)
        text_.append(1, '\n').append(static_cast<std::size_t>(depth) + 1, ' ');
      else if (lines_ && !first)
        text_ += ' ';
      if (v.is_object()) text_ += json_text(item.key()) + (lines_ ? ": " : ":");
      write(*item, depth + 1);
      first = false;
    }
    if (lines_ && own_lines && !first)
      text_.append(1, '\n').append(static_cast<std::size_t>(depth), ' ');
    text_ += close;
  }

  bool lines_;
  std::string text_;
};

}  // namespace

std::string report_json(const Report& report) {
  Writer writer(true);
  writer.write(value(report));
  return writer.take() + '\n';
}

std::string comparisons_json(const std::vector<Comparison>& comparisons) {
  Writer writer(true);
  writer.write({{"comparisons", list(comparisons, [](const auto& c) { return value(c); })}});
  return writer.take();
}

std::string report_json_compact(const Report& report) {
  Writer writer(false);
  writer.write(value(report));
  return writer.take();
}

std::string finding_hash(const Finding& finding) {
  Writer writer(false);
  writer.write(value(finding));
  return content_hash(writer.take());
}

std::string_view report_schema() { return web::report_schema_json(); }

}  // namespace backbend::validate
