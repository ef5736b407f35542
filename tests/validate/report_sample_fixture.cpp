#include "tests/validate/report_sample.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>

#include "tests/source_folder.h"
#include "validate/model/report_json.h"
#include "validate/text/number_text.h"

namespace backbend::validate {
namespace {

constexpr double kNotMeasured = std::numeric_limits<double>::quiet_NaN();
constexpr double kIsnerFlip = 114.3;  // spec 4.3: the top vertebra, chest pitched in place

std::string picture_of(const std::string& rig, const std::string& mapping, const std::string& sweep,
                       int pose) {
  return "frames/" + mapping + "/" + sweep + "/" + rig + "/" + std::to_string(kFirstFrame + pose) +
         ".png";
}

double bump(double x, double center, double width) {
  const double t = (x - center) / width;
  return std::exp(-t * t);
}

SweepSeries series(const std::string& rig, const std::string& mapping, const std::string& sweep,
                   double from, double to, int poses, bool pictures) {
  SweepSeries s;
  s.sweep = sweep;
  s.channel = sweep;
  s.mapping = mapping;
  const bool extension = sweep == "extension";
  const double ease = mapping == "spread" ? 0.72 : 1.0;
  for (int i = 0; i < poses; ++i) {
    const double a = from + (to - from) * i / (poses - 1);
    const double bend = std::abs(a) * ease;
    double gain = 1, kink = bend * 0.02, drift = 0, area = 1 - bend * 0.0006;
    if (rig == "curve") {
      gain = 1.05 + (extension ? 3.1 * bump(bend, 128, 22) : 0);
      kink = bend * 0.018 + (extension ? 11 * bump(bend, 140, 30) : 0);
      drift = extension ? 0.00021 * bend * bend * 0.6 : 0.01 * bend;
      area = 1 - bend * 0.0009 - (sweep == "twist" ? bend * 0.0028 : 0);
    } else if (rig == "isner") {
      const bool flip = extension && mapping == "chest" && a > kIsnerFlip - 1 && a < kIsnerFlip + 2;
      gain = flip ? 88 : 1.4 + 9 * bump(bend, kIsnerFlip, 9) * (extension ? 1 : 0);
      kink = bend * 0.022 + (extension ? 7 * bump(bend, 118, 12) : 0);
      drift = extension && a > kIsnerFlip && mapping == "chest" ? 171 - (a - kIsnerFlip) * 0.4
                                                                : 0.03 * bend;
      area = 1 - bend * 0.0011;
    } else {
      kink = bend * 0.34;
      area = 1 - bend * 0.0021;
    }
    if (!extension && i == 7) area = kNotMeasured;
    s.control_deg.push_back(a);
    s.metric["gain"].push_back(gain);
    s.metric["kink"].push_back(kink);
    s.metric["drift"].push_back(drift);
    s.metric["slice area"].push_back(area);
    s.frame.push_back(pictures ? picture_of(rig, mapping, sweep, i) : "");
  }
  s.metric_unit = {
      {"gain", "deg/deg"}, {"kink", "deg"}, {"drift", "deg"}, {"slice area", "of rest"}};
  s.metric_limit = {{"gain", 3}, {"kink", 8}, {"drift", 0.5}, {"slice area", 0.75}};
  s.pose_deg = {{sweep, s.control_deg}};
  return s;
}

/// Curve against Isner over the sweep and a small grid of side and twist.
Comparison sample_comparison(const std::string& mapping) {
  Comparison c;
  c.a = "curve";
  c.b = "isner";
  c.character = "human";
  c.mapping = mapping;
  c.metrics = {{"kink", "BB010", "deg", 0.1, 40, 3, 48, 1.2},
               {"slice area", "BB030", "ratio", 0.0375, 2, 9, 80, 0}};
  c.worst_of_a = {{"extension",
                   "extension 150",
                   {-1, 0, 75},
                   150,
                   "BB030",
                   "ratio",
                   0.61,
                   0.8,
                   0.75,
                   picture_of("curve", mapping, "extension", 75),
                   picture_of("isner", mapping, "extension", 75),
                   "backbend render human.glb --rig curve",
                   "backbend render human.glb --rig isner"}};
  c.worst_of_b = {{"extension",
                   "extension 116",
                   {-1, 0, 58},
                   116,
                   "BB010",
                   "deg",
                   1.1,
                   171.4,
                   2,
                   picture_of("curve", mapping, "extension", 58),
                   picture_of("isner", mapping, "extension", 58),
                   "",
                   ""}};
  for (const double side : {-30.0, 0.0, 30.0})
    for (const double twist : {-45.0, 0.0, 45.0}) {
      SweepComparison s;
      s.sweep = "grid side " + std::to_string(static_cast<int>(side)) + " twist " +
                std::to_string(static_cast<int>(twist));
      s.control_deg = {0, 30, 60, 90, 120, 150};
      s.pose_deg = {{"extension", s.control_deg},
                    {"side", std::vector<double>(6, side)},
                    {"twist", std::vector<double>(6, twist)}};
      s.marks = "==++x-";
      c.sweeps.push_back(s);
    }
  c.paired = 54;
  c.same = c.a_better = 18;
  c.mixed = c.b_better = 9;
  c.a_over = 18;
  c.b_over = 27;
  c.ahead = "a";
  return c;
}

RigResult rig_result(const std::string& rig, const std::string& mapping, Role role,
                     std::vector<double> clean_to) {
  RigResult r;
  r.character = "human";
  r.rig = r.system = rig;
  r.mapping = mapping;
  r.role = role;
  r.verdict = Verdict::fail;
  if (rig == "curve") r.options = {{"bones", "10"}, {"basis", "bspline"}, {"follow", "chase"}};
  if (rig == "isner") r.options = {{"vertebrae", "5"}, {"length", "fixed"}, {"aim", "project"}};
  const std::vector<std::string> channels{"extension", "flexion", "side", "twist"};
  const std::vector<double> tested{180, 90, 45, 90}, needs{60, 90, 45, 60};
  for (std::size_t i = 0; i < channels.size(); ++i)
    r.headroom.push_back({channels[i], clean_to[i], tested[i], needs[i], true});
  r.sweeps = {series(rig, mapping, "extension", 0, 180, 91, true),
              series(rig, mapping, "side", -45, 45, 31, true),
              series(rig, mapping, "twist", -90, 90, 61, true)};
  r.coverage = {{"BB001", 183, 183, 0, 0}, {"BB010", 183, 183, 0, 0}, {"BB011", 183, 181, 2, 0},
                {"BB020", 183, 183, 0, 0}, {"BB030", 183, 180, 3, 0}, {"BB031", 183, 0, 0, 183}};
  r.summary = {{"gain", rig == "isner" ? 88 : 4.2},
               {"kink", rig == "curve" ? 14.2 : 11.0},
               {"drift", rig == "isner" ? 171 : 4.1},
               {"slice area", 0.71}};
  return r;
}

Finding finding(const std::string& code, const std::string& rig, const std::string& mapping,
                const std::string& sweep, double at, double value, double limit,
                const std::string& unit) {
  Finding f;
  f.code = code;
  f.character = "human";
  f.rig = rig;
  f.mapping = mapping;
  f.sweep = sweep;
  f.control_deg = at;
  f.pose = sweep + " " + significant(at, 5);
  const bool extension = sweep == "extension";
  f.at.pose = static_cast<int>(extension ? at / 2 : (at + (sweep == "side" ? 45 : 90)) / 3);
  f.value = value;
  f.limit = limit;
  f.unit = unit;
  f.verdict = Verdict::fail;
  f.owner = Owner::solver;
  f.pictures.before = picture_of(rig, mapping, sweep, f.at.pose);
  f.pictures.after = picture_of(rig, mapping, sweep, f.at.pose + 1);
  f.pictures.heat = "heat/" + f.pictures.after.substr(7);
  f.pictures.other_rig = rig == "isner" ? "curve" : "isner";
  f.pictures.other = picture_of(f.pictures.other_rig, mapping, sweep, f.at.pose);
  f.reproduce = "backbend render --character human.glb --rig " + rig + " --mapping " + mapping +
                " --pose " + sweep + "=" + significant(at, 7) + " --view profile";
  return f;
}

/// Forty nights in which kinks stepped up at v012, twist headroom fell and came back, and the rest
/// stayed.
void add_trends(Report& r) {
  for (int n = 0; n < 40; ++n)
    r.nights.push_back(
        "2026-" + std::string(n < 9 ? "10-" : "11-") +
        (n < 9 ? std::to_string(23 + n) : (n < 18 ? "0" : "") + std::to_string(n - 8)) +
        (n < 20 ? " v011" : " v012"));
  const auto add = [&](const char* metric, const char* unit, bool more, auto value) {
    Trend t;
    t.character = "human";
    t.rig = "curve";
    t.mapping = "chest";
    t.metric = metric;
    t.unit = unit;
    t.more_is_worse = more;
    for (int n = 0; n < 40; ++n) t.value.push_back(value(n));
    r.trends.push_back(t);
  };
  add("kink", "deg", true, [](int n) { return n < 20 ? 11.2 : 14.2; });
  r.trends.back().steps = {{20, 11.2, 14.2, true, r.nights[20], r.nights[19], ""}};
  add("headroom twist", "deg", false, [](int n) { return n >= 8 && n < 15 ? 12.0 : 30.0; });
  r.trends.back().steps = {{8, 30, 12, true, r.nights[8], r.nights[7], r.nights[15]},
                           {15, 12, 30, false, r.nights[15], r.nights[14], ""}};
  add("headroom extension", "deg", false, [](int n) { return n == 31 ? kNotMeasured : -4.0; });
  add("drift", "deg", true, [](int) { return 4.1; });
}

void add_findings(Report& r) {
  Finding kink = finding("BB010", "curve", "chest", "extension", 58, 9.1, 8, "deg");
  kink.joint = "bone_07";
  kink.detail = "bone_07 bends 9.1 deg where the intended curve turns 4.0; max/mean 2.9";
  kink.geometry = {{"intended_deg", 4.0}, {"max_over_mean", 2.9}};
  kink.image = {true, true, "profile", "silhouette_hausdorff_px", 3.4, 1.0, 212, ""};
  Finding drift = finding("BB020", "curve", "chest", "extension", 58, 0.66, 0.5, "deg");
  drift.joint = "clavicle.L";
  drift.detail = "hidden Euler twist 0.5, holonomy 0.1, aim 0.1";
  drift.artist = {
      {"maya", "from maya import cmds; cmds.setAttr(\"chest_ctl.rotateX\", -58)"},
      {"blender", "import bpy, math; c = bpy.context.object.pose.bones[\"chest_ctl\"]"}};
  drift.image = {true, false, "three-quarter", "arm_centroid_px", 0.3, 0.5, 0, ""};
  Finding wrapper = finding("BB030", "curve", "spread", "twist", 60, 0.71, 0.75, "of rest area");
  wrapper.owner = Owner::weights;
  wrapper.cures = {
      {"backbend repair human.glb -o human_fixed.glb", "clean weights give 0.91 in this pose"}};
  wrapper.slice = 41;
  wrapper.joint = "spine01";
  wrapper.between = {"spine02", "spine01"};
  wrapper.side = "left";
  wrapper.part = "body";
  wrapper.detail =
      "slice 41 of 64 between spine02 and spine01 keeps 0.71 of its area; dual quaternions would "
      "give 0.94";
  wrapper.image = {true, true, "three-quarter", "silhouette_hausdorff_px", 2.2, 1.0, 22, ""};
  Finding far = finding("BB010", "curve", "chest", "extension", 140, 14.2, 8, "deg");
  far.verdict = Verdict::stress;
  far.inside_envelope = false;
  far.joint = "bone_08";
  far.detail = "kinks before it folds";
  Finding waived = finding("BB011", "curve", "spread", "extension", 52, 5.0, 4, "deg");
  waived.verdict = Verdict::waived;
  waived.owner = Owner::weights;
  waived.slice = 18;
  waived.detail = "show start; drift ticket RIG-212, until 2026-12-15";
  Finding unseen =
      finding("BB030", "curve", "chest", "side", -24, kNotMeasured, 0.75, "of rest area");
  unseen.verdict = Verdict::not_measured;
  unseen.owner = Owner::tool;
  unseen.slice = 33;
  unseen.detail = "slice 33 has no closed contour at this pose";
  Finding flip = finding("BB001", "isner", "chest", "extension", kIsnerFlip, 179.4, 20, "deg");
  flip.joint = "vertebra_top";
  flip.detail =
      "turns 179.4 deg about its bone between 114.29999 and 114.30001; class up-vector; both arms "
      "follow";
  flip.geometry = {{"from_deg", 114.29999}, {"to_deg", 114.30001}, {"jump_cm", 41.2}};
  flip.image = {true, true, "profile", "flip_mean", 0.21, 0.02, 8412, ""};
  flip.inside_envelope = false;
  Finding second = finding("BB001", "isner", "chest", "extension", 100.9, 178.8, 20, "deg");
  second.joint = "vertebra_5";
  second.detail = "turns 178.8 deg about its bone; class up-vector";
  second.inside_envelope = false;
  second.image.note = "no passes at this pose";
  r.findings = {kink, drift, wrapper, far, waived, unseen, flip, second};
}

}  // namespace

Report sample_report() {
  Report r;
  r.title = "human: curve against isner";
  r.suite = "nightly";
  r.verdict = Verdict::fail;
  r.exit_code = 1;
  r.headline =
      "curve is clean to 57 degrees of extension and the envelope needs 60; isner flips at 114.3.";
  r.reasons = {"curve kinks at extension 58 (bone_07: 9.1 > 8 deg) inside the envelope",
               "curve lets the arms drift 0.66 deg at extension 58",
               "curve loses 29 % of a slice's area at twist 60 under spread"};
  r.provenance = {{"backbend", "0.1.0"},
                  {"suite", "xxh3:51a0b6c7d8e9f001"},
                  {"limits", "xxh3:9e21aa00c41b7d55"},
                  {"embree", "3.13.5"}};
  CharacterFacts human;
  human.name = "human";
  human.file = "human.glb";
  human.hash = "xxh3:77c0ffee12345678";
  human.meshes = 1;
  human.vertices = 13380;
  human.triangles = 26756;
  human.joints = 163;
  human.height = 1.75;
  human.spine_length = 0.52;
  human.spine = {"root", "spine05", "spine04", "spine03", "spine02", "spine01", "neck01"};
  human.left_arm = {"clavicle.L", "shoulder01.L"};
  human.right_arm = {"clavicle.R", "shoulder01.R"};
  human.envelope = "human";
  human.notes = {"6 helper joints (8 % of torso weight) go with their parents"};
  r.characters = {human};
  for (const char* mapping : {"chest", "spread"}) {
    const bool chest = std::string(mapping) == "chest";
    r.rigs.push_back(rig_result("curve", mapping, Role::proposed,
                                {chest ? 56.0 : 84.0, 90, 42, chest ? 90.0 : 57.0}));
    r.rigs.push_back(
        rig_result("isner", mapping, Role::reference, {chest ? 100.0 : 126.0, 90, 45, 90}));
    r.rigs.push_back(rig_result("three_bone", mapping, Role::reference, {22, 24, 20, 48}));
  }
  r.rigs[1].verdict = Verdict::stress;
  r.rigs[0].beside = {{"even", r.rigs[0].headroom}};
  r.rigs[0].beside[0].headroom[0].clean_to_deg = r.rigs[0].headroom[0].tested_to_deg;
  add_findings(r);
  add_trends(r);
  r.canaries = {
      {"isner_chest", "BB001", "vertebra_top", 114.3, 0.3, 114.30001, true, true,
       "top vertebra flips, twin is clean"},
      {"curve_rest_length", "BB010", "bone_09", 44, 3, 43.1, true, true, "kinks, twin is clean"}};
  r.detectors = {
      "flip from 1.2 deg, kink from 2 deg at 6 joints, drift from 0.05 deg; 0 of 2000 clean poses "
      "flagged"};
  r.calibration = {
      {"flip", "BB001", "10 bones", "deg", 1, "deg", 200, 0, 1.2, 1.2, true},
      {"picture of a kink", "BB011", "24 bones", "deg", 1.25, "ratio", 200, 0, 16, 16, true, 1000,
       640},
      {"chain kink", "BB010", "24 bones", "deg", 0.2, "deg", 200, 3, 0.5, kNotMeasured, false}};
  r.comparisons = {sample_comparison("chest"), sample_comparison("spread")};
  r.pairs = {{"Isner flips at extension 114.3", "one step of 0.00002 degrees apart",
              picture_of("isner", "chest", "extension", 57), "114.29999",
              picture_of("isner", "chest", "extension", 58), "114.30001",
              "heat/chest/extension/isner/1059.png", 6},
             {"The same pose under both rigs", "extension 140",
              picture_of("curve", "chest", "extension", 70), "curve",
              picture_of("isner", "chest", "extension", 70), "isner", "", -1}};
  r.media = {{"contact_sheet", "Extreme poses, profile", "sheets/extension.png"},
             {"video", "Extension 0 to 180, both rigs", "review/extension.mp4"},
             {"turntable", "curve at extension 90", "turntable/curve.png"}};
  r.meshes = {{"isner (chest), extension 114.3",
               "meshes/isner.pose",
               "meshes/human.triangles",
               "turn over a bone",
               "deg",
               0,
               5,
               6,
               "profile",
               {0.0, 1.2, 0.1}},
              {"curve (chest), extension 58", "meshes/curve.pose", "meshes/human.triangles",
               "turn over a bone", "deg", 0, 5, 0}};
  r.next = {"backbend explain BB010", "backbend approve --run latest --reason WHY",
            "backbend check --watch human.glb"};
  r.checks = {{"BB001", "flip", "turn of a joint that stays when the step is halved", "deg",
               "a jump has no place in a sweep", 20, "at most"},
              {"BB010", "chain kink", "joint angle against the intended curve's turning", "deg",
               "seen in profile from 8 on", 8, "at most"},
              {"BB011", "mesh kink", "second difference of slice turning over one bone", "deg",
               "visible on a clay render", 4, "at most"},
              {"BB020", "arm drift", "turn of the arm roots against the chest control", "deg",
               "half a pixel at the hand", 0.5, "at most"},
              {"BB030", "cross-section collapse", "area of a material slice against rest",
               "of rest area", "volume loss is seen from a quarter on", 0.75, "at least"},
              {"BB031", "volume", "volume of a closed mesh against rest", "of rest",
               "has no meaning for an open mesh", 0.9, "at least"}};
  number_findings(r);
  return r;
}

Report sample_report_named(const std::string& name) {
  Report r = sample_report();
  r.title = r.suite = r.headline = name;
  r.reasons = r.detectors = r.next = {name};
  r.provenance = {{name, name}};
  for (CharacterFacts& c : r.characters) {
    c.name = c.file = c.hash = c.envelope = name;
    c.spine = c.left_arm = c.right_arm = c.notes = {name};
  }
  r.rigs.resize(3);
  for (RigResult& rig : r.rigs) {
    rig.sweeps.resize(1);
    rig.character = rig.rig = rig.system = rig.mapping = name;
    rig.options = {{name, name}};
    rig.summary = {{name, 1.0}};
    for (RigHeadroom& each : rig.beside) {
      each.system = name;
      for (Headroom& h : each.headroom) h.channel = name;
    }
    for (Headroom& h : rig.headroom) h.channel = name;
    for (Coverage& c : rig.coverage) c.code = name;
    for (SweepSeries& s : rig.sweeps) {
      s.sweep = s.channel = s.mapping = name;
      s.control_deg = {0, 1, 2};
      s.metric = {{name, {1, 2, 3}}};
      s.metric_unit = {{name, name}};
      s.frame = {name, name, name};
      s.pose_deg = {{name, {0, 1, 2}}};
    }
  }
  for (Finding& f : r.findings) {
    f.code = f.character = f.rig = f.mapping = f.sweep = f.pose = f.joint = f.unit = name;
    f.detail = f.reproduce = f.image.camera = f.image.metric = f.image.note = name;
    f.geometry = {{name, 1.0}};
    f.pictures = {name, name, name, name, name, name, name};
    f.between = {name, name};
    f.part = name;
    f.cures = {{name, name}};
    f.artist = {{name, name}};
  }
  for (CalibrationRow& c : r.calibration)
    c.detector = c.code = c.body = c.unit = c.threshold_unit = name;
  for (CanaryResult& c : r.canaries) c.rig = c.code = c.joint = c.detail = name;
  for (Comparison& c : r.comparisons) {
    c.a = c.b = c.character = c.mapping = name;
    for (MetricComparison& m : c.metrics) m.metric = m.code = m.unit = name;
    for (auto* poses : {&c.worst_of_a, &c.worst_of_b})
      for (ComparedPose& p : *poses) {
        p.sweep = p.pose = p.code = p.unit = p.a_path = p.b_path = name;
        p.a_command = p.b_command = name;
      }
    for (SweepComparison& s : c.sweeps) s.sweep = name;
  }
  for (PicturePair& p : r.pairs) p = {name, name, name, name, name, name, name, p.finding};
  for (MediaItem& m : r.media) m.title = m.path = name;
  r.nights.assign(r.nights.size(), name);
  r.trends.resize(2);
  for (Trend& t : r.trends) {
    t.character = t.rig = t.mapping = t.metric = t.unit = name;
    for (TrendStep& s : t.steps) s.version = s.last_before = s.recovered = name;
  }
  for (MeshView& m : r.meshes) {
    m.title = m.heat = m.unit = m.view = name;
    m.pose_path = m.triangles_path = name;
  }
  for (CheckLegend& c : r.checks) c.code = c.name = c.measures = c.unit = c.reason = name;
  number_findings(r);
  return r;
}

Report sample_report_of(int count) {
  Report r = sample_report();
  const std::vector<Finding> kinds = r.findings;
  while (static_cast<int>(r.findings.size()) < count) {
    const int i = static_cast<int>(r.findings.size());
    Finding f = kinds[static_cast<std::size_t>(i) % kinds.size()];
    f.character = "human_" + std::to_string(i % 40);
    f.vertex = i;
    if (std::isfinite(f.value)) f.value *= 1 - 0.5 * i / count;
    r.findings.push_back(f);
  }
  number_findings(r);
  return r;
}

std::vector<std::string> hostile_names() {
  std::ifstream file(source_folder() / "tests/web/hostile_names.json");
  const auto document = nlohmann::json::parse(file);
  std::vector<std::string> names;
  for (const auto& name : document) names.push_back(name.get<std::string>());
  for (const char* bytes :
       {"\xff\xfe", "\xc0\xbc", "\xed\xa0\x80", "a\x80z", "\xf5\x80\x80\x80", "\xe2\x82"})
    names.emplace_back(bytes);
  names.emplace_back("nul\0byte", 8);
  return names;
}

Report sample_report_hostile(std::size_t from, std::size_t count) {
  const std::vector<std::string> names = hostile_names();
  Report all;
  for (std::size_t i = from; i < std::min(names.size(), from + count); ++i) {
    Report one = sample_report_named(names[i]);
    if (i == from) {
      all = one;
      continue;
    }
    // One of each kind of thing holds every field; more would only make the page longer.
    one.rigs.resize(1);
    one.findings.resize(2);
    one.canaries.resize(1);
    one.pairs.resize(1);
    one.pairs[0].finding = 1;
    one.media.resize(1);
    one.meshes.resize(1);
    one.meshes[0].finding = 0;
    one.checks.resize(1);
    const int findings_before = static_cast<int>(all.findings.size());
    for (PicturePair& p : one.pairs)
      if (p.finding >= 0) p.finding += findings_before;
    const auto append = [](auto& to, const auto& from) {
      to.insert(to.end(), from.begin(), from.end());
    };
    append(all.reasons, one.reasons);
    append(all.characters, one.characters);
    append(all.rigs, one.rigs);
    append(all.findings, one.findings);
    append(all.canaries, one.canaries);
    append(all.detectors, one.detectors);
    append(all.calibration, one.calibration);
    append(all.pairs, one.pairs);
    append(all.media, one.media);
    for (MeshView& m : one.meshes) m.finding += findings_before;
    append(all.meshes, one.meshes);
    append(all.trends, one.trends);
    append(all.checks, one.checks);
    append(all.next, one.next);
    all.provenance.insert(one.provenance.begin(), one.provenance.end());
  }
  return all;
}

}  // namespace backbend::validate
