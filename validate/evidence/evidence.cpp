#include "validate/evidence/evidence.h"

#include <algorithm>
#include <cmath>

#include "render/exr.h"
#include "render/png.h"
#include "render/sheet.h"
#include "validate/evidence/artist.h"
#include "validate/evidence/finding_view.h"
#include "validate/evidence/heat_picture.h"
#include "validate/evidence/review.h"
#include "validate/evidence/video.h"
#include "validate/files/hash.h"
#include "validate/report/escape.h"

namespace backbend::validate {
namespace {

/// How many findings of one rig get pictures of their own, beside its flips.
constexpr std::size_t kPicturedProposed = 6, kPicturedOthers = 3;
constexpr std::size_t kPicturedFlips = 6;
/// A long spine's close-up holds no more than this part of the whole scene.
constexpr double kMostOfScene = 0.35;
/// What has no one place is shown with all that the spine carries, so much of the spine's length
/// around its middle.
constexpr double kWholeTorso = 1.3;
/// Meshes travel inside the page: so many of each rig.
constexpr int kMeshesOfRig = 2;
/// How long a review clip holds the worst angle: two seconds.
constexpr std::size_t kHeldFrames = 48;

std::string rig_word(const RigRecord& rig) {
  return file_word(rig.plan.name) + "_" + std::string(mapping_name(rig.mapping));
}

/// What rendering pictures of one character needs.
struct FrameRenderer {
  const Stage& stage;
  const OutputFolder& folder;
  Photographer photographer;
  render::Settings settings;
  Ledger& ledger;
  Progress& progress;
  std::size_t item = 0;  // pictures so far, the same in every shard

  PosedCharacter posed(const RigRecord& rig, const PoseDegrees& pose) const {
    return stage.pose(*rig.system, controls_at(*rig.system, pose, rig.mapping));
  }

  /// One picture under its final name: taken here, or by whoever had it to take. Where the ledger
  /// does not have it and another shard takes it, an empty one; a shard gets an empty one, too, of
  /// what is there already. `others` are further files that `take` writes.
  template <class Take>
  render::Picture picture(const std::string& file, const std::vector<std::string>& others,
                          const Take& take) {
    poll_interrupt();
    const bool own = ledger.makes(item++);
    const skin::Character& character = stage.character();
    const std::string unit = "picture " + file + " of " +
                             hash_text(character.content_hash_high, character.content_hash_low);
    if (ledger.find(unit)) {
      progress.step();
      if (!ledger.assembles()) return {};
      return render::decode_png(read_bytes(folder.path() / file));
    }
    if (!own) {
      if (ledger.assembles()) ledger.miss(unit);
      return {};
    }
    render::Picture taken = take();
    folder.write(file, render::encode_png(taken));
    std::vector<std::string> files = others;
    files.push_back(file);
    ledger.keep(unit, {}, files);
    progress.step();
    return taken;
  }

  /// A still as PNG and, with every layer, as EXR beside it; kept in `shot` too.
  std::string still(const PosedCharacter& body, const render::Camera& camera,
                    const std::string& name, render::Picture& shot) {
    shot = picture(name + ".png", {name + ".exr"}, [&] {
      photographer.pose(body);
      render::Settings full = settings;
      full.all_layers = true;
      const render::Frame frame = photographer.shoot(camera, full);
      folder.write(name + ".exr", render::encode_exr(frame));
      return render::picture_from(frame);
    });
    return name + ".png";
  }

  /// From the side that shows the pose, near the place where it is known.
  render::Camera camera(const FindingView& view, const PosedCharacter& body,
                        const std::optional<glm::dvec3>& place) const {
    const double aspect = static_cast<double>(settings.width) / settings.height;
    const double scene = glm::distance(photographer.box().low, photographer.box().high);
    const double radius = std::min((place ? kCloseUp : kWholeTorso) * stage.anatomy().spine_length,
                                   kMostOfScene * scene);
    const glm::dvec3 middle = body.spine.position[body.spine.joint_count() / 2];
    const render::Facing facing = view.facing(photographer.facing());
    const glm::dvec3 target = place.value_or(middle);
    // A pose that is not finite has no centre.
    if (!std::isfinite(glm::dot(target, target)))
      return render::view_camera(view.camera, photographer.box(), facing, aspect);
    return render::close_up(view.camera, target, radius, facing, aspect);
  }

  /// The files of one finding: the posed mesh, coloured by `heat`, for any viewer
  /// (and for the page where `in_page`, with the place marked), and the command that shows it
  /// again.
  void hand_out(const Finding& finding, const PosedCharacter& body, const VertexHeat& heat,
                const FindingView& view, const std::optional<glm::dvec3>& mark,
                const std::string& place, bool in_page, Report& report) const {
    if (!ledger.assembles()) return;  // made of what is measured, in no time
    write_posed_glb(folder, place, stage.character(), body, heat);
    if (!finding.reproduce.empty()) {
      folder.write(place + "/repro.sh", "#!/bin/sh\n# " + visible(finding.code) + " " +
                                            visible(finding.rig) + ", " + visible(finding.pose) +
                                            ": " + visible(finding.detail) + "\nexec " +
                                            finding.reproduce + "\n");
    }
    for (const auto& [program, line] : finding.artist) {
      folder.write(place + "/set_pose_" + program + ".py",
                   artist_script(line, finding.code + ", " + finding.pose +
                                           ": your rig, from its rest, in the same pose"));
    }
    if (in_page)
      add_page_mesh(folder, place, finding.rig + " (" + finding.mapping + "), " + finding.pose,
                    stage.character(), body, heat, view.name, mark, -1, report);
  }

  std::string heat(const PosedCharacter& body, const VertexHeat& values,
                   const render::Camera& camera, const std::optional<glm::dvec3>& mark,
                   const std::string& name) {
    picture(name + ".png", {},
            [&] { return heat_picture(photographer, settings, body, values, camera, mark); });
    return name + ".png";
  }

  /// Two pictures as one, where both are here.
  void pair(const std::string& file, const render::Picture& left, const std::string& left_label,
            const render::Picture& right, const std::string& right_label) const {
    if (left.rgba.empty() || right.rgba.empty()) return;
    folder.write(file,
                 render::encode_png(render::side_by_side(left, left_label, right, right_label)));
  }
};

/// The rig that a finding's pose is shown under for comparison: the first other one of its mapping.
const RigRecord* counterpart(const std::vector<RigRecord>& records, const RigRecord& rig) {
  for (const RigRecord& other : records) {
    if (&other != &rig && other.mapping == rig.mapping && other.plan.role != rig.plan.role)
      return &other;
  }
  for (const RigRecord& other : records) {
    if (&other != &rig && other.mapping == rig.mapping) return &other;
  }
  return nullptr;
}

const Sweep& sweep_of(const RigRecord& rig, const Finding& finding) {
  const auto found =
      std::find_if(rig.sweeps.begin(), rig.sweeps.end(),
                   [&](const SweepRecord& sweep) { return sweep.sweep.name == finding.sweep; });
  return found->sweep;
}

/// Whether a finding is a jump between two poses, so that both sides of it are shown.
bool has_two_sides(const Finding& finding) {
  return finding.code == "BB001" || finding.code == "BB037";
}

void picture_flip(FrameRenderer& renderer, const RigRecord& rig, const PlaceNames& places,
                  Finding& finding, const std::string& place, bool in_page, Report& report) {
  const Sweep& sweep = sweep_of(rig, finding);
  const PosedCharacter before =
      renderer.posed(rig, sweep.pose_at(finding.geometry.at("before_deg")));
  const PosedCharacter after = renderer.posed(rig, sweep.pose_at(finding.geometry.at("after_deg")));
  const FindingView view = view_of(sweep.pose_at(finding.control_deg), finding);
  const auto mark = places.point(after.mesh.position, after.world_from_node, finding);
  // A flip turns the whole body above it, so the picture shows all of it.
  const bool flip = finding.code == "BB001";
  const render::Camera camera = renderer.camera(view, after, flip ? std::nullopt : mark);
  render::Picture left, right;
  finding.pictures.view = view.name;
  finding.pictures.before = renderer.still(before, camera, place + "/before", left);
  finding.pictures.after = renderer.still(after, camera, place + "/after", right);
  const std::string at = sweep.channel + " " + number_text(finding.control_deg, 3);
  renderer.pair(place + "/pair.png", left, finding.rig + ", just before " + at, right,
                "just after");
  const VertexHeat heat = distance_heat(after, before, renderer.stage.anatomy().height,
                                        flip ? "moved in the flip" : "moved in the jump");
  finding.pictures.heat_of = heat.label;
  finding.pictures.heat = renderer.heat(after, heat, camera, mark, place + "/heat");
  renderer.hand_out(finding, after, heat, view, mark, place, in_page, report);
  PicturePair pair;
  pair.title =
      finding.rig + " (" + finding.mapping + "): " +
      (flip ? "flip of " + number_text(finding.value, 1) + " deg"
            : "surface jump of " + number_text(finding.geometry.at("size_mm"), 1) + " mm") +
      " at " + finding.pose;
  pair.caption = finding.detail;
  pair.a_path = finding.pictures.before;
  pair.a_label = "just before";
  pair.b_path = finding.pictures.after;
  pair.b_label = "just after";
  pair.heat_path = finding.pictures.heat;
  report.pairs.push_back(pair);
}

void picture_finding(FrameRenderer& renderer, const std::vector<RigRecord>& records,
                     const RigRecord& rig, const BodyMetrics& body, const PlaceNames& places,
                     Finding& finding, const std::string& place, bool in_page, Report& report) {
  const PoseDegrees pose = sweep_of(rig, finding).pose_at(finding.control_deg);
  const PosedCharacter here = renderer.posed(rig, pose);
  const FindingView view = view_of(pose, finding);
  const auto mark = places.point(here.mesh.position, here.world_from_node, finding);
  const render::Camera camera = renderer.camera(view, here, mark);
  render::Picture left, right;
  finding.pictures.view = view.name;
  finding.pictures.before = renderer.still(here, camera, place + "/" + rig_word(rig), left);
  const std::vector<double> control = controls_at(*rig.system, pose, rig.mapping);
  const double height = renderer.stage.anatomy().height;
  VertexHeat heat = metric_heat(
      renderer.stage, body,
      {*rig.system, control, here, glm::radians(pose.twist), pose.stretch != 0.0}, finding);
  if (const RigRecord* other = counterpart(records, rig)) {
    const PosedCharacter there = renderer.posed(*other, pose);
    finding.pictures.other_rig = other->plan.name;
    finding.pictures.other = renderer.still(there, camera, place + "/" + rig_word(*other), right);
    renderer.pair(place + "/pair.png", left, rig.plan.name + ", " + pose.text(), right,
                  other->plan.name);
    if (heat.value.empty())
      heat = distance_heat(here, there, height, "distance to " + other->plan.name);
  }
  if (heat.value.empty())
    heat = distance_heat(here, renderer.posed(rig, PoseDegrees{}), height, "moved from rest");
  finding.pictures.heat_of = heat.label;
  finding.pictures.heat = renderer.heat(here, heat, camera, mark, place + "/heat");
  renderer.hand_out(finding, here, heat, view, mark, place, in_page, report);
}

/// Which findings get pictures: the flips, and the worst others, one of each code.
std::vector<std::size_t> pictured(const RigRecord& rig, const std::vector<Finding>& findings) {
  const std::size_t most = rig.plan.role == Role::proposed ? kPicturedProposed : kPicturedOthers;
  std::vector<std::size_t> chosen;
  std::vector<std::string> codes;
  std::size_t flips = 0;
  for (std::size_t i = 0; i < findings.size(); ++i) {
    if (findings[i].code == "BB001") {
      if (flips++ < kPicturedFlips) chosen.push_back(i);
    } else if (codes.size() < most &&
               std::find(codes.begin(), codes.end(), findings[i].code) == codes.end()) {
      codes.push_back(findings[i].code);
      chosen.push_back(i);
    }
  }
  return chosen;
}

std::size_t still_count(const std::vector<RigRecord>& records,
                        const std::vector<std::vector<Finding>>& findings) {
  std::size_t count = 0;
  for (std::size_t r = 0; r < records.size(); ++r)
    count += 3 * pictured(records[r], findings[r]).size();
  return count;
}

/// The worst numbers of one pose, for the strip under its picture.
std::string worst_text(const PoseRecord& pose) {
  return "kink " + number_text(pose.at(MetricId::chain_kink).value, 1) + "  arm drift " +
         number_text(pose.at(MetricId::arm_drift).value, 1) + " deg";
}

struct SweepFrames {
  std::vector<std::vector<render::Picture>> picture;  // [record][pose], of one mapping
  std::vector<const RigRecord*> rig;

  /// Whether every frame is here: a shard, and a merge that lacks some, has gaps.
  bool complete() const {
    return !rig.empty() && std::all_of(picture.begin(), picture.end(), [](const auto& frames) {
      return std::none_of(frames.begin(), frames.end(),
                          [](const render::Picture& frame) { return frame.rgba.empty(); });
    });
  }
};

RigResult* result_for(Report& report, const std::string& character, const RigRecord& rig) {
  for (RigResult& result : report.rigs) {
    if (result.character == character && result.rig == rig.plan.name &&
        result.mapping == mapping_name(rig.mapping))
      return &result;
  }
  return nullptr;
}

/// Frames of the leading sweep of every rig of one mapping, as files and in memory.
SweepFrames shoot_sweep(FrameRenderer& renderer, const std::vector<RigRecord>& records,
                        solver::Mapping mapping, Report& report) {
  SweepFrames frames;
  const render::Settings settings = scrubber_frame(renderer.settings);
  for (const RigRecord& rig : records) {
    if (rig.mapping != mapping) continue;
    const SweepRecord& sweep = rig.sweeps.front();
    std::vector<render::Picture> pictures;
    std::vector<std::string> names;
    for (std::size_t i = 0; i < sweep.poses.size(); ++i) {
      names.push_back("review/" + file_word(renderer.stage.character().name) + "_" + rig_word(rig) +
                      "/" + file_word(sweep.sweep.name) + "." +
                      std::to_string(kFirstFrame + static_cast<int>(i)) + ".png");
      pictures.push_back(renderer.picture(names.back(), {}, [&] {
        const PosedCharacter body = renderer.stage.pose(*rig.system, sweep.poses[i].control);
        renderer.photographer.pose(body);
        return render::picture_from(renderer.photographer.shoot("profile", settings));
      }));
    }
    if (RigResult* result = result_for(report, renderer.stage.character().name, rig))
      result->sweeps.front().frame = names;
    frames.picture.push_back(std::move(pictures));
    frames.rig.push_back(&rig);
  }
  return frames;
}

void write_sheet(FrameRenderer& renderer, const SweepFrames& frames, int columns,
                 const std::string& name, Report& report) {
  std::vector<render::SheetCell> cells;
  for (std::size_t r = 0; r < frames.rig.size(); ++r) {
    const SweepRecord& sweep = frames.rig[r]->sweeps.front();
    const std::size_t last = sweep.poses.size() - 1;
    for (int c = 0; c < columns; ++c) {
      const std::size_t pose =
          columns == 1 ? last
                       : last * static_cast<std::size_t>(c) / static_cast<std::size_t>(columns - 1);
      cells.push_back({frames.picture[r][pose],
                       frames.rig[r]->plan.name + "  " +
                           number_text(sweep.poses[pose].control_deg, 1) + " deg  " +
                           worst_text(sweep.poses[pose]),
                       false});
    }
  }
  const std::string title = renderer.stage.character().name + ": " +
                            frames.rig.front()->sweeps.front().sweep.name + ", mapping " +
                            std::string(mapping_name(frames.rig.front()->mapping));
  renderer.folder.write(name, render::encode_png(render::contact_sheet(cells, columns, title)));
  report.media.push_back({"contact_sheet", title, name});
}

/// One pose under every rig of a mapping, side by side; `note`, where it says something, stands
/// under rig `noted` in place of its kink.
render::Picture row_of(const SweepFrames& frames, std::size_t pose, std::size_t noted = 0,
                       const std::string& note = "") {
  const render::Picture& first = frames.picture.front()[pose];
  render::Picture row(first.width * static_cast<int>(frames.rig.size()), first.height,
                      {0, 0, 0, 255});
  for (std::size_t r = 0; r < frames.rig.size(); ++r) {
    render::Picture picture = frames.picture[r][pose];
    const PoseRecord& record = frames.rig[r]->sweeps.front().poses[pose];
    const std::string worst = "kink " + number_text(record.at(MetricId::chain_kink).value, 1);
    render::burn_in(picture, frames.rig[r]->plan.name, number_text(record.control_deg, 1) + " deg",
                    r == noted && !note.empty() ? note : worst);
    render::blit(row, picture, first.width * static_cast<int>(r), 0);
  }
  return row;
}

void write_sweep_video(FrameRenderer& renderer, const SweepFrames& frames, const std::string& name,
                       Report& report) {
  write_video(renderer.folder, name, frames.picture.front().size(), kFramesPerSecond,
              [&](std::size_t i) { return row_of(frames, i); });
  report.media.push_back({"video",
                          "all rigs over " + frames.rig.front()->sweeps.front().sweep.name +
                              ", mapping " + std::string(mapping_name(frames.rig.front()->mapping)),
                          name});
}

/// For hand-off: the sweep under every rig of the mapping, standing still at the worst angle, and
/// which angle each frame shows. The worst: of a proposed rig if it has any, else of the first
/// other; where nothing was found the clip stands still at the sweep's end.
void write_review(FrameRenderer& renderer, const SweepFrames& frames,
                  const std::vector<RigRecord>& records,
                  const std::vector<std::vector<Finding>>& findings, const std::string& stem,
                  Report& report) {
  const Sweep& sweep = frames.rig.front()->sweeps.front().sweep;
  const Finding* worst = nullptr;
  std::size_t noted = 0;
  for (const bool proposed : {true, false}) {
    for (std::size_t r = 0; r < frames.rig.size() && worst == nullptr; ++r) {
      if ((frames.rig[r]->plan.role == Role::proposed) != proposed) continue;
      for (const Finding& each : findings[static_cast<std::size_t>(frames.rig[r] - &records[0])]) {
        if (each.sweep != sweep.name) continue;
        worst = &each;  // they come worst first
        noted = r;
        break;
      }
    }
  }
  std::vector<double> angles;
  for (const PoseRecord& pose : frames.rig.front()->sweeps.front().poses)
    angles.push_back(pose.control_deg);
  const std::size_t at =
      worst == nullptr ? angles.size() - 1 : nearest_pose(angles, worst->control_deg);
  const std::vector<ReviewFrame> order = held_at(angles.size(), at, kHeldFrames);
  const std::string note =
      worst == nullptr ? "" : worst->code + " " + number_text(worst->value, 2) + " " + worst->unit;
  const std::string name = stem + "_" + file_word(sweep.name);
  write_video(renderer.folder, name + ".mp4", order.size(), kFramesPerSecond, [&](std::size_t i) {
    return row_of(frames, order[i].pose, noted, order[i].held ? note : "");
  });
  renderer.folder.write(name + ".csv", review_csv(order, angles));
  const std::string held =
      worst == nullptr ? "nothing found" : worst->code + " of " + frames.rig[noted]->plan.name;
  report.media.push_back({"review",
                          sweep.name + ", mapping " +
                              std::string(mapping_name(frames.rig.front()->mapping)) +
                              ", held at " + number_text(angles[at], 1) + " (" + held + ")",
                          name + ".mp4"});
}

/// The proposed rig at its worst, from all around.
void write_turntable(FrameRenderer& renderer, const std::vector<RigRecord>& records,
                     const std::vector<std::vector<Finding>>& findings, int views,
                     const std::string& prefix, Report& report) {
  for (std::size_t r = 0; r < records.size(); ++r) {
    if (records[r].plan.role != Role::proposed) continue;
    const Sweep& leading = records[r].sweeps.front().sweep;
    const PoseDegrees pose =
        findings[r].empty()
            ? leading.pose_at(leading.to_deg)
            : sweep_of(records[r], findings[r].front()).pose_at(findings[r].front().control_deg);
    const PosedCharacter body = renderer.posed(records[r], pose);
    renderer.photographer.pose(body);
    const double aspect = static_cast<double>(renderer.settings.width) / renderer.settings.height;
    const auto cameras = render::turntable(views, renderer.photographer.box(),
                                           renderer.photographer.facing(), aspect);
    const std::string name = prefix + "turntable_" + rig_word(records[r]);
    const auto shoot = [&](std::size_t i) {
      return render::picture_from(renderer.photographer.shoot(cameras[i], renderer.settings));
    };
    // Its frames are kept only until the video is made.
    const auto frame = [&](std::size_t i) {
      if (!renderer.ledger.is_on()) {
        renderer.progress.step();
        return shoot(i);
      }
      return renderer.picture(
          std::string(kPartsFolder) + "/" + name + "/" + std::to_string(i) + ".png", {},
          [&] { return shoot(i); });
    };
    bool complete = renderer.ledger.assembles();
    if (renderer.ledger.mode() == Ledger::Mode::shard ||
        renderer.ledger.mode() == Ledger::Mode::merge) {
      for (std::size_t i = 0; i < cameras.size(); ++i)
        complete = !frame(i).rgba.empty() && complete;
    }
    if (!complete) return;
    write_video(renderer.folder, name + ".mp4", cameras.size(), kFramesPerSecond, frame);
    report.media.push_back(
        {"turntable", records[r].plan.name + " at " + pose.text(), name + ".mp4"});
    return;
  }
}

}  // namespace

render::Bounds framing_of(const Stage& stage, const std::vector<RigRecord>& records) {
  render::Bounds box = render::bounds_of(stage.rest().position);
  for (const RigRecord& record : records) {
    for (const SweepRecord& sweep : record.sweeps) {
      for (const PoseRecord& pose : sweep.poses) box.add(pose.bounds);
    }
  }
  return box;
}

void make_evidence(const Stage& stage, const BodyMetrics& body, const PlaceNames& places,
                   const render::Bounds& box, const PicturePlan& plan,
                   const std::vector<RigRecord>& records,
                   std::vector<std::vector<Finding>>& findings, const OutputFolder& folder,
                   Ledger& ledger, Progress& progress, Report& report) {
  if (records.empty()) return;
  folder.prepare();
  render::Settings settings;
  settings.width = plan.width;
  settings.height = plan.height;
  settings.samples = plan.samples;
  FrameRenderer renderer{stage, folder, Photographer(stage, box), settings, ledger, progress};
  const std::string character = file_word(stage.character().name);

  std::size_t frames =
      still_count(records, findings) + static_cast<std::size_t>(plan.turntable_views);
  if (plan.sheet_columns > 0) {
    for (const RigRecord& record : records) frames += record.sweeps.front().poses.size();
  }
  progress.start("frames", frames);
  for (std::size_t r = 0; r < records.size(); ++r) {
    int number = 0;
    for (const std::size_t i : pictured(records[r], findings[r])) {
      Finding& finding = findings[r][i];
      const std::string place = "findings/" + character + "_" + rig_word(records[r]) + "_" +
                                file_word(finding.sweep) + "_" + finding.code + "_" +
                                std::to_string(++number);
      const bool in_page = number <= kMeshesOfRig;
      if (has_two_sides(finding)) {
        picture_flip(renderer, records[r], places, finding, place, in_page, report);
      } else {
        picture_finding(renderer, records, records[r], body, places, finding, place, in_page,
                        report);
      }
    }
  }
  if (plan.sheet_columns > 0) {
    for (const solver::Mapping mapping : {solver::Mapping::chest, solver::Mapping::spread}) {
      const SweepFrames sweep = shoot_sweep(renderer, records, mapping, report);
      if (!renderer.ledger.assembles() || !sweep.complete()) continue;
      const std::string stem = "media/" + character + "_" + std::string(mapping_name(mapping));
      write_sheet(renderer, sweep, plan.sheet_columns, stem + "_sheet.png", report);
      write_sweep_video(renderer, sweep, stem + "_sweep.mp4", report);
      write_review(renderer, sweep, records, findings,
                   "review/" + character + "_" + std::string(mapping_name(mapping)), report);
    }
  }
  if (plan.turntable_views > 0) {
    write_turntable(renderer, records, findings, plan.turntable_views, "media/" + character + "_",
                    report);
  }
}

}  // namespace backbend::validate
