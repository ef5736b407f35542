#include "validate/model/report_json.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "validate/files/hash.h"
#include "validate/model/web_files.h"
#include "validate/text/escape.h"
#include "validate/text/json_object.h"
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
  return JsonObject<json>()
      .with("channel", h.channel)
      .with("clean_to_deg", h.clean_to_deg)
      .with("tested_to_deg", h.tested_to_deg)
      .with("needs_deg", h.needs_deg)
      .with("headroom_deg", h.headroom_deg())
      .with("measured", h.measured);
}

json value(const Corners& c) {
  return JsonObject<json>()
      .with("poses", c.poses)
      .with("clean", c.clean)
      .with("clean_percent", c.clean_percent())
      .with("needed", c.needed)
      .with("worst", c.worst)
      .with("code", c.code);
}

json value(const CompoundSearch& s) {
  return JsonObject<json>()
      .with("paths", s.paths)
      .with("poses", s.poses)
      .with("with_jumps", s.with_jumps)
      .with("unsure", s.unsure)
      .with("box", s.box);
}

json value(const HuntedPose& h, const std::vector<SweepSeries>& sweeps) {
  const std::string path = h.sweep < 0 ? "" : sweeps.at(static_cast<std::size_t>(h.sweep)).sweep;
  return JsonObject<json>()
      .with("code", h.code)
      .with("unit", h.unit)
      .with("pose", h.pose)
      .with("value", h.value)
      .with("limit", h.limit)
      .with("over", h.over)
      .with("sweep", path);
}

json value(const PoseHunt& h, const std::vector<SweepSeries>& sweeps) {
  return JsonObject<json>()
      .with("evaluations", h.evaluations)
      .with("seed", h.seed)
      .with("box", h.box)
      .with("gap", h.gap)
      .with("worst", list(h.worst, [&](const auto& w) { return value(w, sweeps); }))
      .with("notes", h.notes);
}

json value(const CleanVolume& v) {
  json certified;
  if (v.proved)
    certified = JsonObject<json>()
                    .with("share", v.certified)
                    .with("no_jump", v.no_jump)
                    .with("refuted", v.refuted)
                    .with("gain", v.gain);
  return JsonObject<json>()
      .with("box", v.box)
      .with("certified", certified)
      .with("not_certified", v.not_proved)
      .with("searched", JsonObject<json>()
                            .with("poses", v.poses)
                            .with("clean", v.clean)
                            .with("at_least", v.at_least)
                            .with("confidence", kVolumeConfidence));
}

json value(const SweepSeries& s) {
  return JsonObject<json>()
      .with("sweep", s.sweep)
      .with("channel", s.channel)
      .with("mapping", s.mapping)
      .with("control_deg", s.control_deg)
      .with("metric", s.metric)
      .with("metric_unit", s.metric_unit)
      .with("metric_limit", s.metric_limit)
      .with("frame", s.frame)
      .with("pose_deg", s.pose_deg);
}

json value(const Coverage& c) {
  return JsonObject<json>()
      .with("code", c.code)
      .with("planned", c.planned)
      .with("measured", c.measured)
      .with("not_measured", c.not_measured)
      .with("not_applicable", c.not_applicable);
}

json value(const RigResult& r) {
  json out = JsonObject<json>()
                 .with("character", r.character)
                 .with("rig", r.rig)
                 .with("system", r.system)
                 .with("mapping", r.mapping)
                 .with("role", role_word(r.role))
                 .with("options", r.options)
                 .with("verdict", verdict_word(r.verdict))
                 .with("headroom", list(r.headroom, [](const auto& h) { return value(h); }))
                 .with("corners", value(r.corners))
                 .with("search", value(r.search))
                 .with("sweeps", list(r.sweeps, [](const auto& s) { return value(s); }))
                 .with("coverage", list(r.coverage, [](const auto& c) { return value(c); }))
                 .with("summary", r.summary);
  if (r.hunt.evaluations > 0 || !r.hunt.notes.empty()) out["hunt"] = value(r.hunt, r.sweeps);
  if (!r.volume.box.empty()) out["volume"] = value(r.volume);
  if (!r.beside.empty())
    out["beside"] = list(r.beside, [](const RigHeadroom& each) {
      return json(
          JsonObject<json>()
              .with("system", each.system)
              .with("headroom", list(each.headroom, [](const auto& h) { return value(h); })));
    });
  return out;
}

json value(const CharacterFacts& c) {
  return JsonObject<json>()
      .with("name", c.name)
      .with("file", c.file)
      .with("hash", c.hash)
      .with("meshes", c.meshes)
      .with("vertices", c.vertices)
      .with("triangles", c.triangles)
      .with("joints", c.joints)
      .with("height", c.height)
      .with("spine_length", c.spine_length)
      .with("spine", c.spine)
      .with("arms", JsonObject<json>().with("left", c.left_arm).with("right", c.right_arm))
      .with("sure", c.doubts.empty())
      .with("doubts", c.doubts)
      .with("kind", c.kind)
      .with("kind_reason", c.kind_reason)
      .with("envelope", c.envelope)
      .with("envelope_reason", c.envelope_reason)
      .with("notes", c.notes);
}

json value(const ImageWitness& image) {
  if (!image.measured && image.note.empty()) return "not_measured";
  return JsonObject<json>()
      .with("measured", image.measured)
      .with("visible", image.visible)
      .with("camera", image.camera)
      .with("metric", image.metric)
      .with("value", image.value)
      .with("threshold", image.threshold)
      .with("pixels", image.pixels)
      .with("note", image.note);
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
  json out = JsonObject<json>()
                 .with("before", p.before)
                 .with("after", p.after)
                 .with("heat", p.heat)
                 .with("other", p.other);
  if (!p.other_rig.empty()) out["other_rig"] = p.other_rig;
  if (!p.view.empty()) out["view"] = p.view;
  if (!p.heat_of.empty()) out["heat_of"] = p.heat_of;
  return out;
}

json value(const Finding& f) {
  const bool posed = f.at.pose >= 0;
  json out = JsonObject<json>()
                 .with("code", f.code)
                 .with("character", f.character)
                 .with("rig", f.rig)
                 .with("mapping", f.mapping)
                 .with("sweep", f.sweep)
                 .with("pose", f.pose)
                 .with("pose_index", posed ? json(f.at.pose) : json(nullptr))
                 .with("frame", f.frame ? json(*f.frame) : json(nullptr))
                 .with("time", f.time_s ? json(*f.time_s) : json(nullptr))
                 .with("control_deg", f.control_deg)
                 .with("place", place(f))
                 .with("value", f.value)
                 .with("limit", f.limit)
                 .with("unit", f.unit)
                 .with("verdict", verdict_word(f.verdict))
                 .with("owner", owner_word(f.owner))
                 .with("inside_envelope", f.inside_envelope)
                 .with("detail", f.detail)
                 .with("geometry", f.geometry)
                 .with("image", value(f.image))
                 .with("pictures", value(f.pictures))
                 .with("reproduce", f.reproduce);
  if (!f.cures.empty())
    out["cures"] = list(f.cures, [](const Cure& each) {
      return json(JsonObject<json>().with("command", each.command).with("gives", each.gives));
    });
  if (!f.artist.empty()) out["artist"] = f.artist;
  return out;
}

json value(const CanaryResult& c) {
  return JsonObject<json>()
      .with("rig", c.rig)
      .with("code", c.code)
      .with("joint", c.joint)
      .with("expected_deg", c.expected_deg)
      .with("tolerance_deg", c.tolerance_deg)
      .with("found_deg", c.found_deg)
      .with("found", c.found)
      .with("twin_clean", c.twin_clean)
      .with("ok", c.ok())
      .with("detail", c.detail);
}

json value(const CalibrationRow& c) {
  return JsonObject<json>()
      .with("detector", c.detector)
      .with("code", c.code)
      .with("body", c.body)
      .with("unit", c.unit)
      .with("threshold", c.threshold)
      .with("threshold_unit", c.threshold_unit)
      .with("compared", c.compared)
      .with("alike", c.alike)
      .with("clean_poses", c.clean)
      .with("target", c.target)
      .with("false_alarms", c.false_alarms)
      .with("smallest", c.smallest)
      .with("ok", c.ok);
}

json value(const ComparedPose& p) {
  return JsonObject<json>()
      .with("sweep", p.sweep)
      .with("pose", p.pose)
      .with("index", p.at.pose)
      .with("control_deg", p.control_deg)
      .with("code", p.code)
      .with("unit", p.unit)
      .with("a", p.a)
      .with("b", p.b)
      .with("limit", p.limit)
      .with("a_path", p.a_path)
      .with("b_path", p.b_path)
      .with("a_command", p.a_command)
      .with("b_command", p.b_command);
}

json value(const MetricComparison& m) {
  return JsonObject<json>()
      .with("metric", m.metric)
      .with("code", m.code)
      .with("unit", m.unit)
      .with("tolerance", m.tolerance)
      .with("a_better", m.a_better)
      .with("b_better", m.b_better)
      .with("same", m.same)
      .with("median_gain", m.median_gain);
}

json value(const SweepComparison& s) {
  return JsonObject<json>()
      .with("sweep", s.sweep)
      .with("pose_deg", s.pose_deg)
      .with("control_deg", s.control_deg)
      .with("marks", s.marks);
}

json value(const Comparison& c) {
  return JsonObject<json>()
      .with("a", c.a)
      .with("b", c.b)
      .with("character", c.character)
      .with("mapping", c.mapping)
      .with("matched", c.matched)
      .with("paired", c.paired)
      .with("unpaired", c.unpaired)
      .with("a_better", c.a_better)
      .with("b_better", c.b_better)
      .with("mixed", c.mixed)
      .with("same", c.same)
      .with("a_over", c.a_over)
      .with("b_over", c.b_over)
      .with("ahead", c.ahead)
      .with("sampled", c.sampled)
      .with("metrics", list(c.metrics, [](const auto& m) { return value(m); }))
      .with("worst_of_a", list(c.worst_of_a, [](const auto& p) { return value(p); }))
      .with("worst_of_b", list(c.worst_of_b, [](const auto& p) { return value(p); }))
      .with("sweeps", list(c.sweeps, [](const auto& s) { return value(s); }));
}

json value(const PicturePair& p) {
  return JsonObject<json>()
      .with("title", p.title)
      .with("caption", p.caption)
      .with("a_path", p.a_path)
      .with("a_label", p.a_label)
      .with("b_path", p.b_path)
      .with("b_label", p.b_label)
      .with("heat_path", p.heat_path)
      .with("finding", p.finding);
}

json value(const MediaItem& m) {
  return JsonObject<json>().with("kind", m.kind).with("title", m.title).with("path", m.path);
}

json value(const MeshView& m) {
  json out = JsonObject<json>()
                 .with("title", m.title)
                 .with("pose_path", m.pose_path)
                 .with("triangles_path", m.triangles_path)
                 .with("heat", m.heat)
                 .with("unit", m.unit)
                 .with("heat_low", m.heat_low)
                 .with("heat_high", m.heat_high)
                 .with("finding", m.finding);
  if (!m.view.empty()) out["view"] = m.view;
  if (!m.mark.empty()) out["mark"] = m.mark;
  return out;
}

json value(const TrendStep& s) {
  return JsonObject<json>()
      .with("night", s.night)
      .with("before", s.before)
      .with("after", s.after)
      .with("worse", s.worse)
      .with("version", s.version)
      .with("last_before", s.last_before)
      .with("recovered", s.recovered);
}

json value(const Trend& t) {
  return JsonObject<json>()
      .with("character", t.character)
      .with("rig", t.rig)
      .with("mapping", t.mapping)
      .with("metric", t.metric)
      .with("unit", t.unit)
      .with("more_is_worse", t.more_is_worse)
      .with("value", t.value)
      .with("steps", list(t.steps, [](const auto& s) { return value(s); }));
}

json value(const CheckLegend& c) {
  return JsonObject<json>()
      .with("code", c.code)
      .with("name", c.name)
      .with("measures", c.measures)
      .with("unit", c.unit)
      .with("reason", c.reason)
      .with("limit", c.limit)
      .with("sense", c.sense);
}

json value(const Report& r) {
  json out = JsonObject<json>()
                 .with("schema", kReportSchemaName)
                 .with("title", r.title)
                 .with("suite", r.suite)
                 .with("headline", r.headline)
                 .with("reasons", r.reasons)
                 .with("verdict", verdict_word(r.verdict))
                 .with("exit_code", r.exit_code)
                 .with("provenance", r.provenance)
                 .with("characters", list(r.characters, [](const auto& c) { return value(c); }))
                 .with("rigs", list(r.rigs, [](const auto& x) { return value(x); }))
                 .with("findings", list(r.findings, [](const auto& f) { return value(f); }))
                 .with("canaries", list(r.canaries, [](const auto& c) { return value(c); }))
                 .with("detectors", r.detectors)
                 .with("comparisons", list(r.comparisons, [](const auto& c) { return value(c); }))
                 .with("pairs", list(r.pairs, [](const auto& p) { return value(p); }))
                 .with("media", list(r.media, [](const auto& m) { return value(m); }))
                 .with("meshes", list(r.meshes, [](const auto& m) { return value(m); }))
                 .with("checks", list(r.checks, [](const auto& c) { return value(c); }))
                 .with("nights", r.nights)
                 .with("trends", list(r.trends, [](const auto& t) { return value(t); }))
                 .with("next", r.next);
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
  writer.write(JsonObject<json>().with("comparisons",
                                       list(comparisons, [](const auto& c) { return value(c); })));
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
