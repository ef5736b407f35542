#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "validate/model/report_json.h"
#include "validate/text/escape.h"
#include "validate/verdicts/names.h"

namespace backbend::validate {
namespace {

using nlohmann::json;

/// One place in the document: a value and the path that leads to it. Readers of objects take their
/// keys one by one; `done` then refuses what nobody took.
class Place {
 public:
  Place(const json& value, std::string path, std::string_view file)
      : value_(value), path_(std::move(path)), file_(file) {}

  [[noreturn]] void refuse(const std::string& what) const {
    throw ReportError(visible(file_) + ": " + path_ + ": " + what);
  }

  Place at(const std::string& key) {
    if (!value_.is_object()) refuse("expected an object, found " + kind());
    const auto found = value_.find(key);
    if (found == value_.end()) refuse("the key '" + key + "' is missing");
    taken_.insert(key);
    return {*found, path_ + "." + key, file_};
  }

  bool has(const std::string& key) const {
    return !value_.is_object() || value_.find(key) != value_.end();
  }

  /// `at`, but an absent key is allowed and gives the fallback.
  template <class T, class F>
  T optional(const std::string& key, T fallback, F read) {
    return has(key) ? read(at(key)) : fallback;
  }

  void done() const {
    for (const auto& item : value_.items())
      if (!taken_.contains(item.key())) refuse("unknown key '" + visible(item.key()) + "'");
  }

  std::string text() const {
    if (!value_.is_string()) refuse("expected a string, found " + kind());
    return value_.get<std::string>();
  }
  bool is_text(std::string_view wanted) const {
    return value_.is_string() && value_.get_ref<const std::string&>() == wanted;
  }
  bool is_null() const { return value_.is_null(); }
  /// null is what was not measured.
  double number() const {
    if (value_.is_null()) return std::numeric_limits<double>::quiet_NaN();
    if (!value_.is_number()) refuse("expected a number or null, found " + kind());
    return value_.get<double>();
  }
  int integer() const {
    if (!value_.is_number_integer()) refuse("expected a whole number, found " + kind());
    const bool fits = value_.is_number_unsigned()
                          ? value_.get<std::uint64_t>() <= std::numeric_limits<int>::max()
                          : value_.get<std::int64_t>() >= std::numeric_limits<int>::min();
    if (!fits) refuse("the number is out of range");
    return value_.get<int>();
  }
  int count() const {
    const int n = integer();
    if (n < 0) refuse("expected a count, found " + std::to_string(n));
    return n;
  }
  bool flag() const {
    if (!value_.is_boolean()) refuse("expected true or false, found " + kind());
    return value_.get<bool>();
  }
  template <class F>
  auto word(F from_word) const {
    const std::string found = text();
    const auto value = from_word(found);
    if (!value) refuse("unknown word '" + visible(found) + "'");
    return *value;
  }
  template <class F>
  auto list(F read) const {
    if (!value_.is_array()) refuse("expected an array, found " + kind());
    std::vector<decltype(read(std::declval<Place>()))> out;
    out.reserve(value_.size());
    for (std::size_t i = 0; i < value_.size(); ++i)
      out.push_back(read(Place(value_[i], path_ + "[" + std::to_string(i) + "]", file_)));
    return out;
  }
  template <class F>
  auto map(F read) const {
    if (!value_.is_object()) refuse("expected an object, found " + kind());
    std::map<std::string, decltype(read(std::declval<Place>()))> out;
    for (const auto& item : value_.items())
      out.emplace(item.key(), read(Place(item.value(), path_ + "." + visible(item.key()), file_)));
    return out;
  }

 private:
  std::string kind() const {
    return value_.is_null() ? "null" : std::string("a value of type ") + value_.type_name();
  }

  const json& value_;
  std::string path_;
  std::string_view file_;
  std::set<std::string> taken_;
};

std::string text(const Place& p) { return p.text(); }
double number(const Place& p) { return p.number(); }
std::vector<std::string> texts(const Place& p) { return p.list(text); }

/// A value that follows from others is kept in the file for its readers; here it must agree.
void expect_same(const Place& p, double derived) {
  const double found = p.number();
  if (!(found == derived || (std::isnan(found) && !std::isfinite(derived))))
    p.refuse("does not follow from its neighbours");
}

Headroom headroom(Place p) {
  Headroom h;
  h.channel = p.at("channel").text();
  h.clean_to_deg = p.at("clean_to_deg").number();
  h.tested_to_deg = p.at("tested_to_deg").number();
  h.needs_deg = p.at("needs_deg").number();
  h.measured = p.at("measured").flag();
  expect_same(p.at("headroom_deg"), h.headroom_deg());
  p.done();
  return h;
}

RigHeadroom rig_headroom(Place p) {
  RigHeadroom r{p.at("system").text(), p.at("headroom").list(headroom)};
  p.done();
  return r;
}

Corners corners(Place p) {
  Corners c;
  c.poses = p.at("poses").count();
  c.clean = p.at("clean").count();
  if (c.clean > c.poses) p.refuse("more clean poses than poses");
  c.needed = p.at("needed").flag();
  c.worst = p.at("worst").text();
  c.code = p.at("code").text();
  expect_same(p.at("clean_percent"), c.clean_percent());
  p.done();
  return c;
}

CompoundSearch search(Place p) {
  CompoundSearch s;
  s.paths = p.at("paths").count();
  s.poses = p.at("poses").count();
  s.with_jumps = p.at("with_jumps").count();
  s.unsure = p.at("unsure").count();
  s.box = p.at("box").text();
  p.done();
  return s;
}

double share(const Place& p) {
  const double value = p.number();
  if (!(value >= 0.0 && value <= 1.0)) p.refuse("expected a share from 0 to 1");
  return value;
}

/// Of the sweep of that name; -1: none has it.
int number_of(const std::string& name, const std::vector<SweepSeries>& sweeps) {
  const auto found = std::ranges::find(sweeps, name, &SweepSeries::sweep);
  return name.empty() || found == sweeps.end() ? -1 : static_cast<int>(found - sweeps.begin());
}

HuntedPose hunted_pose(Place p, const std::vector<SweepSeries>& sweeps) {
  HuntedPose h;
  h.code = p.at("code").text();
  h.unit = p.at("unit").text();
  h.pose = p.at("pose").text();
  h.value = p.at("value").number();
  h.limit = p.at("limit").number();
  h.over = p.at("over").flag();
  const Place path = p.at("sweep");
  h.sweep = number_of(path.text(), sweeps);
  if (h.sweep < 0 && !path.text().empty()) path.refuse("names no sweep of the rig");
  p.done();
  return h;
}

PoseHunt hunt(Place p, const std::vector<SweepSeries>& sweeps) {
  PoseHunt h;
  h.evaluations = p.at("evaluations").count();
  h.seed = p.at("seed").count();
  h.box = p.at("box").text();
  h.gap = share(p.at("gap"));
  h.worst = p.at("worst").list([&](const Place& each) { return hunted_pose(each, sweeps); });
  h.notes = p.at("notes").list(text);
  p.done();
  return h;
}

CleanVolume volume(Place p) {
  CleanVolume v;
  v.box = p.at("box").text();
  if (Place c = p.at("certified"); !c.is_null()) {
    v.proved = true;
    v.certified = share(c.at("share"));
    v.no_jump = share(c.at("no_jump"));
    v.refuted = share(c.at("refuted"));
    v.gain = c.at("gain").number();
    c.done();
  }
  v.not_proved = p.at("not_certified").text();
  Place s = p.at("searched");
  v.poses = s.at("poses").count();
  v.clean = s.at("clean").count();
  if (v.clean > v.poses) s.refuse("more clean poses than poses");
  v.at_least = share(s.at("at_least"));
  expect_same(s.at("confidence"), kVolumeConfidence);
  s.done();
  p.done();
  return v;
}

SweepSeries sweep(Place p) {
  SweepSeries s;
  s.sweep = p.at("sweep").text();
  s.channel = p.at("channel").text();
  s.mapping = p.at("mapping").text();
  s.control_deg = p.at("control_deg").list(number);
  s.metric = p.at("metric").map([](const Place& m) { return m.list(number); });
  s.metric_unit = p.at("metric_unit").map(text);
  s.metric_limit = p.at("metric_limit").map(number);
  s.frame = p.at("frame").list(text);
  s.pose_deg = p.at("pose_deg").map([](const Place& c) { return c.list(number); });
  for (const auto& [name, values] : s.metric)
    if (values.size() != s.control_deg.size())
      p.refuse("metric '" + visible(name) + "' has " + std::to_string(values.size()) +
               " values for " + std::to_string(s.control_deg.size()) + " poses");
  for (const auto& [channel, values] : s.pose_deg)
    if (values.size() != s.control_deg.size())
      p.refuse("channel '" + visible(channel) + "' has " + std::to_string(values.size()) +
               " values for " + std::to_string(s.control_deg.size()) + " poses");
  if (!s.frame.empty() && s.frame.size() != s.control_deg.size())
    p.refuse("there are " + std::to_string(s.frame.size()) + " frames for " +
             std::to_string(s.control_deg.size()) + " poses");
  p.done();
  return s;
}

Coverage coverage(Place p) {
  Coverage c;
  c.code = p.at("code").text();
  c.planned = p.at("planned").count();
  c.measured = p.at("measured").count();
  c.not_measured = p.at("not_measured").count();
  c.not_applicable = p.at("not_applicable").count();
  // In 64 bits: three counts that each fit may not fit together.
  if (std::int64_t{c.measured} + c.not_measured + c.not_applicable != c.planned)
    p.refuse("measured, not_measured and not_applicable do not add up to planned");
  p.done();
  return c;
}

RigResult rig(Place p) {
  RigResult r;
  r.character = p.at("character").text();
  r.rig = p.at("rig").text();
  r.system = p.at("system").text();
  r.mapping = p.at("mapping").text();
  r.role = p.at("role").word(role_from_word);
  r.options = p.at("options").map(text);
  r.verdict = p.at("verdict").word(verdict_from_word);
  r.headroom = p.at("headroom").list(headroom);
  r.beside =
      p.optional("beside", r.beside, [](const Place& each) { return each.list(rig_headroom); });
  r.corners = p.optional("corners", r.corners, corners);
  r.search = p.optional("search", r.search, search);
  r.volume = p.optional("volume", r.volume, volume);
  r.sweeps = p.at("sweeps").list(sweep);
  r.hunt = p.optional("hunt", r.hunt, [&](const Place& each) { return hunt(each, r.sweeps); });
  r.coverage = p.at("coverage").list(coverage);
  r.summary = p.at("summary").map(number);
  p.done();
  return r;
}

CharacterFacts character(Place p) {
  CharacterFacts c;
  c.name = p.at("name").text();
  c.file = p.at("file").text();
  c.hash = p.at("hash").text();
  c.meshes = p.at("meshes").count();
  c.vertices = p.at("vertices").count();
  c.triangles = p.at("triangles").count();
  c.joints = p.at("joints").count();
  c.height = p.at("height").number();
  c.spine_length = p.at("spine_length").number();
  c.spine = texts(p.at("spine"));
  Place arms = p.at("arms");
  c.left_arm = texts(arms.at("left"));
  c.right_arm = texts(arms.at("right"));
  arms.done();
  const bool sure = p.at("sure").flag();
  c.doubts = p.optional("doubts", c.doubts, texts);
  if (!sure && c.doubts.empty()) c.doubts.emplace_back("the spine");  // an earlier version's
  c.kind = p.optional("kind", c.kind, text);
  c.kind_reason = p.optional("kind_reason", c.kind_reason, text);
  c.envelope = p.at("envelope").text();
  c.envelope_reason = p.optional("envelope_reason", c.envelope_reason, text);
  c.notes = texts(p.at("notes"));
  p.done();
  return c;
}

ImageWitness image(Place p) {
  ImageWitness w;
  if (p.is_text("not_measured")) return w;
  w.measured = p.at("measured").flag();
  w.visible = p.at("visible").flag();
  w.camera = p.at("camera").text();
  w.metric = p.at("metric").text();
  w.value = p.at("value").number();
  w.threshold = p.at("threshold").number();
  w.pixels = p.at("pixels").number();
  w.note = p.at("note").text();
  p.done();
  return w;
}

FindingPictures pictures(Place p) {
  FindingPictures out{p.at("before").text(),
                      p.at("after").text(),
                      p.at("heat").text(),
                      p.at("other").text(),
                      p.optional("other_rig", std::string(), text),
                      p.optional("view", std::string(), text),
                      p.optional("heat_of", std::string(), text)};
  p.done();
  return out;
}

/// Where on the sweep a finding stands, and in a clip at which frame and second of its own.
///
/// Reports written before findings had `pose_index` count the poses from frame 1001, 24 to a
/// second, for clips too; nothing of a clip's own time is in them.
void when(Place& p, Finding& f) {
  const Place frame = p.at("frame"), time = p.at("time");
  if (frame.is_null() != time.is_null())
    (frame.is_null() ? time : frame).refuse("'frame' and 'time' stand together");
  if (!p.has("pose_index")) {
    if (frame.is_null()) return;
    f.at.pose = frame.count() - kFirstFrame;
    if (f.at.pose < 0) frame.refuse("sequences start at frame 1001");
    expect_same(time, f.at.pose / kFramesPerSecond);
    return;
  }
  if (const Place pose = p.at("pose_index"); !pose.is_null()) f.at.pose = pose.count();
  if (frame.is_null()) return;
  f.frame = frame.count();
  f.time_s = time.number();
}

Cure cure(Place p) {
  Cure c{p.at("command").text(), p.at("gives").text()};
  p.done();
  return c;
}

Finding finding(Place p) {
  Finding f;
  f.code = p.at("code").text();
  f.character = p.at("character").text();
  f.rig = p.at("rig").text();
  f.mapping = p.at("mapping").text();
  f.sweep = p.at("sweep").text();
  f.pose = p.at("pose").text();
  when(p, f);
  f.control_deg = p.at("control_deg").number();
  Place place = p.at("place");
  f.joint = place.optional("joint", std::string(), text);
  const auto pair = [](const Place& names) {
    const std::vector<std::string> two = texts(names);
    if (two.size() != 2) names.refuse("expected two joints");
    return std::array<std::string, 2>{two[0], two[1]};
  };
  f.between = place.optional("between", f.between, pair);
  f.side = place.optional("side", std::string(), text);
  f.part = place.optional("mesh_part", std::string(), text);
  const auto index = [](const Place& i) { return i.count(); };
  f.slice = place.optional("slice", -1, index);
  f.vertex = place.optional("vertex", -1, index);
  place.done();
  f.value = p.at("value").number();
  f.limit = p.at("limit").number();
  f.unit = p.at("unit").text();
  f.verdict = p.at("verdict").word(verdict_from_word);
  f.owner = p.at("owner").word(owner_from_word);
  f.inside_envelope = p.at("inside_envelope").flag();
  f.detail = p.at("detail").text();
  f.geometry = p.at("geometry").map(number);
  f.image = image(p.at("image"));
  f.pictures = pictures(p.at("pictures"));
  f.reproduce = p.at("reproduce").text();
  f.cures = p.optional("cures", f.cures, [](const Place& each) { return each.list(cure); });
  // Reports of earlier versions name one command.
  if (p.has("repair")) f.cures.push_back({p.at("repair").text(), ""});
  f.artist = p.optional("artist", f.artist, [](const Place& each) { return each.map(text); });
  p.done();
  return f;
}

CanaryResult canary(Place p) {
  CanaryResult c;
  c.rig = p.at("rig").text();
  c.code = p.at("code").text();
  c.joint = p.at("joint").text();
  c.expected_deg = p.at("expected_deg").number();
  c.tolerance_deg = p.at("tolerance_deg").number();
  c.found_deg = p.at("found_deg").number();
  c.found = p.at("found").flag();
  c.twin_clean = p.at("twin_clean").flag();
  c.detail = p.at("detail").text();
  if (p.at("ok").flag() != c.ok()) p.refuse("'ok' does not follow from found and twin_clean");
  p.done();
  return c;
}

CalibrationRow calibration(Place p) {
  CalibrationRow c;
  c.detector = p.at("detector").text();
  c.code = p.at("code").text();
  c.body = p.at("body").text();
  c.unit = p.at("unit").text();
  c.threshold = p.at("threshold").number();
  c.threshold_unit = p.at("threshold_unit").text();
  c.compared = p.at("compared").count();
  c.alike = p.at("alike").count();
  if (c.alike > c.compared) p.refuse("'alike' is more than 'compared'");
  c.clean = p.at("clean_poses").count();
  c.false_alarms = p.at("false_alarms").count();
  c.target = p.at("target").number();
  c.smallest = p.at("smallest").number();
  c.ok = p.at("ok").flag();
  p.done();
  return c;
}

ComparedPose compared_pose(Place p) {
  ComparedPose out;
  out.sweep = p.at("sweep").text();
  out.pose = p.at("pose").text();
  out.at.pose = p.at("index").integer();
  out.control_deg = p.at("control_deg").number();
  out.code = p.at("code").text();
  out.unit = p.at("unit").text();
  out.a = p.at("a").number();
  out.b = p.at("b").number();
  out.limit = p.at("limit").number();
  out.a_path = p.at("a_path").text();
  out.b_path = p.at("b_path").text();
  out.a_command = p.at("a_command").text();
  out.b_command = p.at("b_command").text();
  p.done();
  return out;
}

MetricComparison metric_comparison(Place p) {
  MetricComparison out;
  out.metric = p.at("metric").text();
  out.code = p.at("code").text();
  out.unit = p.at("unit").text();
  out.tolerance = p.at("tolerance").number();
  out.a_better = p.at("a_better").count();
  out.b_better = p.at("b_better").count();
  out.same = p.at("same").count();
  out.median_gain = p.at("median_gain").number();
  p.done();
  return out;
}

SweepComparison sweep_comparison(Place p) {
  SweepComparison out;
  out.sweep = p.at("sweep").text();
  out.pose_deg = p.at("pose_deg").map([](const Place& c) { return c.list(number); });
  out.control_deg = p.at("control_deg").list(number);
  Place marks = p.at("marks");
  out.marks = marks.text();
  if (out.marks.size() != out.control_deg.size() ||
      out.marks.find_first_not_of("+-x=?") != std::string::npos)
    marks.refuse("expected one of + - x = ? for each pose");
  p.done();
  return out;
}

Comparison comparison(Place p) {
  Comparison c;
  c.a = p.at("a").text();
  c.b = p.at("b").text();
  c.character = p.at("character").text();
  c.mapping = p.at("mapping").text();
  c.matched = p.at("matched").number();
  c.paired = p.at("paired").count();
  c.unpaired = p.at("unpaired").count();
  c.a_better = p.at("a_better").count();
  c.b_better = p.at("b_better").count();
  c.mixed = p.at("mixed").count();
  c.same = p.at("same").count();
  c.a_over = p.at("a_over").count();
  c.b_over = p.at("b_over").count();
  Place ahead = p.at("ahead");
  c.ahead = ahead.text();
  if (c.ahead != "a" && c.ahead != "b" && !c.ahead.empty())
    ahead.refuse("unknown word '" + visible(c.ahead) + "'");
  c.sampled = p.at("sampled").text();
  c.metrics = p.at("metrics").list(metric_comparison);
  c.worst_of_a = p.at("worst_of_a").list(compared_pose);
  c.worst_of_b = p.at("worst_of_b").list(compared_pose);
  c.sweeps = p.at("sweeps").list(sweep_comparison);
  p.done();
  return c;
}

PicturePair pair(Place p) {
  PicturePair out;
  out.title = p.at("title").text();
  out.caption = p.at("caption").text();
  out.a_path = p.at("a_path").text();
  out.a_label = p.at("a_label").text();
  out.b_path = p.at("b_path").text();
  out.b_label = p.at("b_label").text();
  out.heat_path = p.at("heat_path").text();
  out.finding = p.at("finding").integer();
  p.done();
  return out;
}

MediaItem media(Place p) {
  MediaItem m{p.at("kind").text(), p.at("title").text(), p.at("path").text()};
  p.done();
  return m;
}

MeshView mesh(Place p) {
  MeshView m;
  m.title = p.at("title").text();
  m.pose_path = p.at("pose_path").text();
  m.triangles_path = p.at("triangles_path").text();
  m.heat = p.at("heat").text();
  m.unit = p.at("unit").text();
  m.heat_low = p.at("heat_low").number();
  m.heat_high = p.at("heat_high").number();
  m.finding = p.at("finding").integer();
  m.view = p.optional("view", std::string(), text);
  const auto point = [](const Place& mark) {
    std::vector<double> xyz = mark.list(number);
    if (!xyz.empty() && xyz.size() != 3) mark.refuse("expected three numbers");
    return xyz;
  };
  m.mark = p.optional("mark", m.mark, point);
  p.done();
  return m;
}

TrendStep trend_step(Place p) {
  TrendStep s;
  s.night = p.at("night").count();
  s.before = p.at("before").number();
  s.after = p.at("after").number();
  s.worse = p.at("worse").flag();
  s.version = p.at("version").text();
  s.last_before = p.at("last_before").text();
  s.recovered = p.at("recovered").text();
  p.done();
  return s;
}

Trend trend(Place p, std::size_t nights) {
  Trend t;
  t.character = p.at("character").text();
  t.rig = p.at("rig").text();
  t.mapping = p.at("mapping").text();
  t.metric = p.at("metric").text();
  t.unit = p.at("unit").text();
  t.more_is_worse = p.at("more_is_worse").flag();
  t.value = p.at("value").list(number);
  t.steps = p.at("steps").list(trend_step);
  if (t.value.size() != nights)
    p.refuse("there are " + std::to_string(t.value.size()) + " values for " +
             std::to_string(nights) + " nights");
  for (const TrendStep& s : t.steps)
    if (static_cast<std::size_t>(s.night) >= nights) p.refuse("a step names no night");
  p.done();
  return t;
}

CheckLegend check(Place p) {
  CheckLegend c;
  c.code = p.at("code").text();
  c.name = p.at("name").text();
  c.measures = p.at("measures").text();
  c.unit = p.at("unit").text();
  c.reason = p.at("reason").text();
  c.limit = p.at("limit").number();
  c.sense = p.optional("sense", c.sense, text);
  p.done();
  return c;
}

/// nlohmann keeps the last of two equal keys; a report that says two things is damaged.
json parse_without_doubles(std::string_view text, std::string_view name) {
  std::vector<std::set<std::string>> open;
  const auto watch = [&](int, json::parse_event_t event, json& parsed) {
    if (event == json::parse_event_t::object_start) open.emplace_back();
    if (event == json::parse_event_t::object_end) open.pop_back();
    if (event == json::parse_event_t::key && !open.back().insert(parsed.get<std::string>()).second)
      throw ReportError(visible(name) + ": the key '" + visible(parsed.get<std::string>()) +
                        "' stands twice in one object");
    return true;
  };
  try {
    return json::parse(text.begin(), text.end(), watch);
  } catch (const json::exception& e) {
    throw ReportError(visible(name) + ": not JSON: " + visible(e.what()));
  }
}

}  // namespace

void number_findings(Report& report) {
  for (Finding& f : report.findings) {
    const auto rig = std::ranges::find_if(report.rigs, [&](const RigResult& each) {
      return each.character == f.character && each.rig == f.rig && each.mapping == f.mapping;
    });
    const bool known = rig != report.rigs.end();
    f.at.rig = known ? static_cast<int>(rig - report.rigs.begin()) : -1;
    f.at.sweep = known ? number_of(f.sweep, rig->sweeps) : -1;
  }
}

Report parse_report(std::string_view text_in, std::string_view name) {
  const json document = parse_without_doubles(text_in, name);
  Place p(document, "$", name);
  const Place schema = p.at("schema");
  if (!schema.is_text(kReportSchemaName))
    schema.refuse("expected '" + std::string(kReportSchemaName) + "'; this file is from another " +
                  "version of backbend, or not a report");
  Report r;
  r.title = p.at("title").text();
  r.suite = p.at("suite").text();
  r.headline = p.at("headline").text();
  r.reasons = texts(p.at("reasons"));
  r.verdict = p.at("verdict").word(verdict_from_word);
  r.exit_code = p.at("exit_code").integer();
  r.provenance = p.at("provenance").map(text);
  r.characters = p.at("characters").list(character);
  r.rigs = p.at("rigs").list(rig);
  r.findings = p.at("findings").list(finding);
  number_findings(r);
  r.canaries = p.at("canaries").list(canary);
  r.detectors = texts(p.at("detectors"));
  r.is_comparison =
      p.optional("is_comparison", false, [](const Place& each) { return each.flag(); });
  r.calibration = p.optional("calibration", r.calibration,
                             [](const Place& each) { return each.list(calibration); });
  const auto expect_finding = [&](const char* list, std::size_t i, int finding) {
    if (finding < -1 || finding >= static_cast<int>(r.findings.size()))
      p.refuse(list + ("[" + std::to_string(i)) + "].finding names no finding");
  };
  r.comparisons = p.at("comparisons").list(comparison);
  r.pairs = p.at("pairs").list(pair);
  for (std::size_t i = 0; i < r.pairs.size(); ++i) expect_finding("pairs", i, r.pairs[i].finding);
  r.media = p.at("media").list(media);
  r.meshes = p.at("meshes").list(mesh);
  for (std::size_t i = 0; i < r.meshes.size(); ++i)
    expect_finding("meshes", i, r.meshes[i].finding);
  r.checks = p.at("checks").list(check);
  r.nights = texts(p.at("nights"));
  r.trends = p.at("trends").list([&](const Place& each) { return trend(each, r.nights.size()); });
  r.next = texts(p.at("next"));
  p.done();
  return r;
}

}  // namespace backbend::validate
