#include "validate/evidence/evidence.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <mutex>
#include <numeric>
#include <optional>
#include <set>
#include <span>
#include <unordered_map>

#include "render/image/exr.h"
#include "render/image/png.h"
#include "render/review/sheet.h"
#include "validate/evidence/artist.h"
#include "validate/evidence/finding_view.h"
#include "validate/evidence/heat_picture.h"
#include "validate/evidence/review.h"
#include "validate/evidence/video.h"
#include "validate/files/hash.h"
#include "validate/judge/judge.h"
#include "validate/model/digest.h"
#include "validate/sweeps/external_spec.h"
#include "validate/tasks/side_by_side.h"
#include "validate/text/escape.h"

namespace backbend::validate {
namespace {

/// How many findings of one rig get pictures of their own, and how many of its flips beside them.
constexpr std::size_t kPicturedProposed = 6, kPicturedOthers = 3;
/// A long spine's close-up holds no more than this part of the whole scene.
constexpr double kMostOfScene = 0.35;
/// What has no one place is shown with all that the spine carries, so much of the spine's length
/// around its middle.
constexpr double kWholeTorso = 1.3;
/// Tiles of a picture get no more samples at this noise: backdrop and what is lit evenly end at
/// half.
constexpr double kNoise = 0.02;
/// Meshes travel inside the page: so many of each rig.
constexpr int kMeshesOfRig = 2;
/// How long a review clip holds the worst angle: two seconds.
constexpr std::size_t kHeldFrames = 48;

std::string rig_word(const RigRecord& rig) {
  return file_word(rig.plan.name) + "_" + std::string(mapping_name(rig.mapping));
}

/// What a picture shows: two of one key are the same to the last bit.
std::string picture_key(const PosedCharacter& body, const render::Camera& camera,
                        const render::Settings& settings) {
  const auto hash = [](const std::vector<glm::vec3>& values) {
    return content_hash(std::span(reinterpret_cast<const std::uint8_t*>(values.data()),
                                  values.size() * sizeof(glm::vec3)));
  };
  std::string key = hash(body.mesh.position) + hash(body.mesh.normal);
  for (const glm::dvec3& v : {camera.eye, camera.target, camera.up}) {
    for (int axis = 0; axis < 3; ++axis) key += " " + number_text(v[axis], 17);
  }
  return key + " " + number_text(camera.focal_mm, 17) + " " + std::to_string(settings.width) + "x" +
         std::to_string(settings.height) + " " + std::to_string(settings.samples) + " " +
         std::to_string(settings.all_layers);
}

/// Pictures that this run has taken, by their keys: where two rigs agree, at rest or all along, the
/// second is a copy of the first.
class TakenPictures {
 public:
  /// The files of the picture, in the order in which they were given.
  std::optional<std::vector<std::string>> find(const std::string& key) {
    const std::lock_guard lock(mutex_);
    const auto found = files_.find(key);
    if (found == files_.end()) return std::nullopt;
    return found->second;
  }
  void keep(const std::string& key, const std::vector<std::string>& files) {
    const std::lock_guard lock(mutex_);
    files_.emplace(key, files);
  }

 private:
  std::mutex mutex_;
  std::unordered_map<std::string, std::vector<std::string>> files_;
};

/// What rendering pictures of one character needs, from any thread.
struct FrameRenderer {
  const Stage& stage;
  const OutputFolder& folder;
  PhotographerPool& cameras;
  render::Settings settings;
  Ledger& ledger;
  Progress& progress;
  TakenPictures& taken;

  PosedCharacter posed(const RigRecord& rig, const PoseDegrees& pose) const {
    return stage.pose(*rig.system, controls_at(*rig.system, pose, rig.mapping));
  }

  /// One picture under its final name: taken here, or by whoever had it to take; `item` numbers
  /// the pictures, the same in every shard. Where the ledger does not have it and another shard
  /// takes it, an empty one; a shard gets an empty one, too, of what is there already. `others` are
  /// further files that `take` writes. `key()`, asked only where it is to be taken: picture_key(),
  /// or nothing where no other picture is the same.
  template <class Key, class Take>
  render::Picture picture(std::size_t item, const std::string& file,
                          const std::vector<std::string>& others, const Key& key,
                          const Take& take) const {
    poll_interrupt();
    const bool own = ledger.makes(item);
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
    std::vector<std::string> files = others;
    files.push_back(file);
    const std::string shows = key();
    render::Picture picture;
    if (const auto same = taken.find(shows)) {
      std::vector<std::uint8_t> bytes;
      for (std::size_t i = 0; i < files.size(); ++i) {
        bytes = read_bytes(folder.path() / (*same)[i]);
        folder.write(files[i], bytes);
      }
      picture = render::decode_png(bytes);
    } else {
      picture = take();
      folder.write(file, render::encode_png(picture));
      if (!shows.empty()) taken.keep(shows, files);
    }
    ledger.keep(unit, {}, files);
    progress.step();
    return picture;
  }
  template <class Take>
  render::Picture picture(std::size_t item, const std::string& file, const Take& take) const {
    return picture(
        item, file, {}, [] { return std::string(); }, take);
  }

  /// A still as `name`.png and, with every layer, as `name`.exr beside it.
  render::Picture still(std::size_t item, const PosedCharacter& body, const render::Camera& camera,
                        const std::string& name) const {
    render::Settings full = settings;
    full.all_layers = true;
    const auto key = [&] { return picture_key(body, camera, full); };
    return picture(item, name + ".png", {name + ".exr"}, key, [&] {
      const render::Frame frame = [&] {
        const PhotographerPool::Loan photographer(cameras);
        photographer->pose(body);
        return photographer->shoot(camera, full);
      }();
      folder.write(name + ".exr", render::encode_exr(frame));
      return render::picture_from(frame);
    });
  }

  /// From the side that shows the pose, near the place where it is known.
  render::Camera camera(const FindingView& view, const PosedCharacter& body,
                        const std::optional<glm::dvec3>& place) const {
    const double aspect = static_cast<double>(settings.width) / settings.height;
    const double scene = glm::distance(cameras.box().low, cameras.box().high);
    const double radius = std::min((place ? kCloseUp : kWholeTorso) * stage.anatomy().spine_length,
                                   kMostOfScene * scene);
    const glm::dvec3 middle = body.spine.position[body.spine.joint_count() / 2];
    const render::Facing facing = view.facing(cameras.facing());
    const glm::dvec3 target = place.value_or(middle);
    // A pose that is not finite has no centre.
    if (!std::isfinite(glm::dot(target, target)))
      return render::view_camera(view.camera, cameras.box(), facing, aspect);
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

  void heat(std::size_t item, const PosedCharacter& body, const VertexHeat& values,
            const render::Camera& camera, const std::optional<glm::dvec3>& mark,
            const std::string& file) const {
    picture(item, file, [&] {
      return heat_picture(*PhotographerPool::Loan(cameras), settings, body, values, camera, mark);
    });
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

/// Whether a finding is a jump between two poses, so that both sides of it are shown.
bool has_two_sides(const Finding& finding) {
  return find_check(finding.code)->pictures == Witness::jump;
}

/// The pictures of one finding, as pieces of work of their own: each poses the body anew, so that
/// none is kept for another.
class ShownFinding {
 public:
  /// Says in the finding and the report where its pictures will be; the first is number `item`.
  ShownFinding(const FrameRenderer& renderer, const std::vector<RigRecord>& records,
               const RigRecord& rig, const BodyMetrics& body, const PlaceNames& places,
               Finding& finding, std::string place, bool in_page, std::size_t item, Report& report)
      : renderer_(renderer),
        rig_(rig),
        body_(body),
        places_(places),
        finding_(finding),
        place_(std::move(place)),
        in_page_(in_page),
        item_(item),
        two_sides_(has_two_sides(finding)),
        is_flip_(finding.code == "BB001"),
        other_(two_sides_ ? &rig : counterpart(records, rig)),
        pose_(sweep_of(rig, finding)->sweep.pose_at(finding.control_deg)),
        view_(view_of(pose_, finding)) {
    finding.pictures.view = view_.name;
    finding.pictures.before = first_name() + ".png";
    if (two_sides_) {
      finding.pictures.after = second_name() + ".png";
    } else if (other_ != nullptr) {
      finding.pictures.other_rig = other_->plan.name;
      finding.pictures.other = second_name() + ".png";
    }
    finding.pictures.heat = place_ + "/heat.png";
    if (!two_sides_) return;
    PicturePair pair;
    pair.title =
        finding.rig + " (" + finding.mapping + "): " +
        (is_flip_ ? "flip of " + number_text(finding.value, 1) + " deg"
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

  /// How many pictures there are.
  std::size_t count() const { return other_ != nullptr ? 3 : 2; }

  static void add(const std::shared_ptr<ShownFinding>& pictures, SideBySide& work) {
    const SideBySide::Group stills = work.group(), heat = work.group();
    work.add(stills, [pictures] {
      pictures->left_ = pictures->still(0, pictures->shown_first(), pictures->first_name());
    });
    if (pictures->other_ != nullptr)
      work.add(stills, [pictures] {
        pictures->right_ = pictures->still(1, pictures->shown_second(), pictures->second_name());
      });
    work.add(heat, [pictures] { pictures->heat(); });
    work.after(stills, [pictures] { pictures->pair(); });
  }
  /// What the page shows of the finding in space, when all is done.
  const std::vector<MeshView>& meshes() const { return made_.meshes; }

 private:
  std::string first_name() const { return place_ + "/" + (two_sides_ ? "before" : rig_word(rig_)); }
  std::string second_name() const {
    return place_ + "/" + (two_sides_ ? "after" : rig_word(*other_));
  }
  PosedCharacter at_side(const char* side) const {
    return renderer_.posed(rig_,
                           sweep_of(rig_, finding_)->sweep.pose_at(finding_.geometry.at(side)));
  }
  PosedCharacter shown_first() const {
    return two_sides_ ? at_side("before_deg") : renderer_.posed(rig_, pose_);
  }
  PosedCharacter shown_second() const {
    return two_sides_ ? at_side("after_deg") : renderer_.posed(*other_, pose_);
  }
  /// The body that cameras look at and the finding's place is on.
  PosedCharacter main() const { return two_sides_ ? shown_second() : shown_first(); }
  std::optional<glm::dvec3> mark(const PosedCharacter& body) const {
    return places_.point(body.mesh.position, body.world_from_node, finding_);
  }
  render::Camera camera(const PosedCharacter& body) const {
    // A flip turns the whole body above it, so the picture shows all of it.
    return renderer_.camera(view_, body, is_flip_ ? std::nullopt : mark(body));
  }

  render::Picture still(std::size_t number, const PosedCharacter& body,
                        const std::string& name) const {
    return renderer_.still(item_ + number, body, camera(main()), name);
  }

  void pair() const {
    if (two_sides_) {
      const Sweep& sweep = sweep_of(rig_, finding_)->sweep;
      const std::string at = sweep.channel + " " + number_text(finding_.control_deg, 3);
      renderer_.pair(place_ + "/pair.png", left_, finding_.rig + ", just before " + at, right_,
                     "just after");
    } else if (other_ != nullptr) {
      renderer_.pair(place_ + "/pair.png", left_, rig_.plan.name + ", " + pose_.text(), right_,
                     other_->plan.name);
    }
  }

  VertexHeat heat_values(const PosedCharacter& here) const {
    const double height = renderer_.stage.anatomy().height;
    if (two_sides_)
      return distance_heat(here, shown_first(), height,
                           is_flip_ ? "moved in the flip" : "moved in the jump");
    const std::vector<double> control = controls_at(*rig_.system, pose_, rig_.mapping);
    VertexHeat values = metric_heat(
        renderer_.stage, body_,
        {*rig_.system, control, here, glm::radians(pose_.twist), pose_.stretch != 0.0}, finding_);
    if (!values.value.empty()) return values;
    return other_ != nullptr
               ? distance_heat(here, shown_second(), height, "distance to " + other_->plan.name)
               : distance_heat(here, renderer_.posed(rig_, PoseDegrees{}), height,
                               "moved from rest");
  }

  void heat() {
    const PosedCharacter here = main();
    const auto at = mark(here);
    const VertexHeat values = heat_values(here);
    finding_.pictures.heat_of = values.label;
    renderer_.heat(item_ + count() - 1, here, values, camera(here), at, finding_.pictures.heat);
    renderer_.hand_out(finding_, here, values, view_, at, place_, in_page_, made_);
  }

  const FrameRenderer& renderer_;
  const RigRecord& rig_;
  const BodyMetrics& body_;
  const PlaceNames& places_;
  Finding& finding_;
  std::string place_;
  bool in_page_;
  std::size_t item_;
  bool two_sides_;  // a jump between two poses, shown on both sides
  bool is_flip_;
  const RigRecord* other_;  // that the pose is shown under beside the finding's own; null: none
  PoseDegrees pose_;
  FindingView view_;
  render::Picture left_, right_;
  Report made_;
};

/// Which findings get pictures: the flips, and the worst others, one of each code.
std::vector<std::size_t> pictured(const RigRecord& rig, const std::vector<Finding>& findings) {
  const std::size_t most = rig.plan.role == Role::proposed ? kPicturedProposed : kPicturedOthers;
  // In the order in which the page names the worst.
  std::vector<std::size_t> order(findings.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, std::ranges::greater{}, [&](std::size_t i) {
    return std::pair(findings[i].verdict == Verdict::fail, times_over(findings[i]));
  });
  std::vector<std::size_t> chosen;
  std::set<std::string> codes;
  std::size_t flips = 0;
  for (const std::size_t i : order) {
    if (findings[i].code == "BB001") {
      if (flips++ < most) chosen.push_back(i);
    } else if (codes.size() < most && codes.insert(findings[i].code).second) {
      chosen.push_back(i);
    }
  }
  return chosen;
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

std::string frame_name(const FrameRenderer& renderer, const RigRecord& rig, std::size_t pose) {
  return "review/" + file_word(renderer.stage.character().name) + "_" + rig_word(rig) + "/" +
         file_word(rig.sweeps.front().sweep.name) + "." +
         std::to_string(kFirstFrame + static_cast<int>(pose)) + ".png";
}

/// Frames of the leading sweep of every rig of one mapping, as files and in memory, when `group` is
/// done. The first is picture `item`; counts up.
std::shared_ptr<SweepFrames> shoot_sweep(const FrameRenderer& renderer,
                                         const std::vector<RigRecord>& records,
                                         solver::Mapping mapping, SideBySide& work,
                                         SideBySide::Group group, std::size_t& item,
                                         Report& report) {
  const auto frames = std::make_shared<SweepFrames>();
  for (const RigRecord& rig : records) {
    if (rig.mapping != mapping) continue;
    frames->picture.emplace_back(rig.sweeps.front().poses.size());
    frames->rig.push_back(&rig);
    std::vector<std::string> names;
    for (std::size_t i = 0; i < frames->picture.back().size(); ++i)
      names.push_back(frame_name(renderer, rig, i));
    // The records are the last of the report's rigs.
    (report.rigs.end() - (records.data() + records.size() - &rig))->sweeps.front().frame = names;
  }
  for (std::size_t r = 0; r < frames->rig.size(); ++r) {
    for (std::size_t i = 0; i < frames->picture[r].size(); ++i, ++item) {
      work.add(group, [&renderer, frames, r, i, item] {
        const RigRecord& rig = *frames->rig[r];
        const render::Settings small = scrubber_frame(renderer.settings);
        const render::Camera camera =
            render::view_camera("profile", renderer.cameras.box(), renderer.cameras.facing(),
                                static_cast<double>(small.width) / small.height);
        PosedCharacter body;
        const auto key = [&] {
          body = renderer.stage.pose(*rig.system, rig.sweeps.front().poses[i].control);
          return picture_key(body, camera, small);
        };
        frames->picture[r][i] = renderer.picture(item, frame_name(renderer, rig, i), {}, key, [&] {
          const PhotographerPool::Loan photographer(renderer.cameras);
          photographer->pose(body);
          return render::picture_from(photographer->shoot(camera, small));
        });
      });
    }
  }
  return frames;
}

void write_sheet(const FrameRenderer& renderer, const SweepFrames& frames, int columns,
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

void write_sweep_video(const FrameRenderer& renderer, const SweepFrames& frames,
                       const std::string& name, Report& report) {
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
void write_review(const FrameRenderer& renderer, const SweepFrames& frames,
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
        if (each.at.sweep != 0) continue;
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

/// The proposed rig at its worst, from all around. The first view is picture `item`; counts up.
void shoot_turntable(const FrameRenderer& renderer, const std::vector<RigRecord>& records,
                     const std::vector<std::vector<Finding>>& findings, int views,
                     const std::string& prefix, SideBySide& work, std::size_t& item,
                     Report& report) {
  constexpr std::size_t kViewsOfPiece = 3;  // posing a body costs little beside them
  const auto proposed = std::ranges::find(records, Role::proposed,
                                          [](const RigRecord& each) { return each.plan.role; });
  if (proposed == records.end()) return;
  const RigRecord& rig = *proposed;
  const std::vector<Finding>& found = findings[static_cast<std::size_t>(&rig - &records[0])];
  const Sweep& leading = rig.sweeps.front().sweep;
  const PoseDegrees pose =
      found.empty() ? leading.pose_at(leading.to_deg)
                    : sweep_of(rig, found.front())->sweep.pose_at(found.front().control_deg);
  const double aspect = static_cast<double>(renderer.settings.width) / renderer.settings.height;
  struct Turn {
    std::vector<render::Camera> camera;
    std::vector<render::Picture> picture;
  };
  const auto turn = std::make_shared<Turn>();
  turn->camera =
      render::turntable(views, renderer.cameras.box(), renderer.cameras.facing(), aspect);
  turn->picture.resize(turn->camera.size());
  const std::string name = prefix + "turntable_" + rig_word(rig);
  const SideBySide::Group group = work.group();
  for (std::size_t first = 0; first < turn->camera.size(); first += kViewsOfPiece) {
    const std::size_t end = std::min(first + kViewsOfPiece, turn->camera.size());
    work.add(group, [&renderer, &rig, turn, name, pose, first, end, item] {
      const PosedCharacter body = renderer.posed(rig, pose);
      std::optional<PhotographerPool::Loan> photographer;
      for (std::size_t i = first; i < end; ++i) {
        const auto shoot = [&] {
          if (!photographer) {
            photographer.emplace(renderer.cameras);
            (*photographer)->pose(body);
          }
          render::Settings settings = renderer.settings;
          settings.mattes = false;
          return render::picture_from((*photographer)->shoot(turn->camera[i], settings));
        };
        // Its frames are kept only until the video is made.
        if (renderer.ledger.is_on()) {
          turn->picture[i] = renderer.picture(
              item + i, std::string(kPartsFolder) + "/" + name + "/" + std::to_string(i) + ".png",
              shoot);
        } else {
          poll_interrupt();
          turn->picture[i] = shoot();
          renderer.progress.step();
        }
      }
    });
  }
  item += turn->camera.size();
  work.after(group, [&renderer, &rig, &report, turn, name, pose] {
    if (!renderer.ledger.assembles() ||
        std::ranges::any_of(turn->picture, [](const auto& each) { return each.rgba.empty(); }))
      return;
    write_video(renderer.folder, name + ".mp4", turn->picture.size(), kFramesPerSecond,
                [&](std::size_t i) { return turn->picture[i]; });
    report.media.push_back({"turntable", rig.plan.name + " at " + pose.text(), name + ".mp4"});
  });
}

}  // namespace

render::Bounds framing_of(const Stage& stage, const std::vector<RigRecord>& records) {
  render::Bounds box = stage.bounds(stage.rest());
  for (const RigRecord& record : records) {
    for (const SweepRecord& sweep : record.sweeps) {
      for (const PoseRecord& pose : sweep.poses) box.add(pose.bounds);
    }
  }
  return box;
}

void make_evidence(PhotographerPool& cameras, const BodyMetrics& body, const PlaceNames& places,
                   const PicturePlan& plan, const std::vector<RigRecord>& records,
                   std::vector<std::vector<Finding>>& findings, const OutputFolder& folder,
                   Ledger& ledger, Progress& progress, Report& report) {
  if (records.empty()) return;
  folder.prepare();
  const Stage& stage = cameras.stage();
  render::Settings settings;
  settings.width = plan.width;
  settings.height = plan.height;
  settings.samples = plan.samples;
  settings.noise = kNoise;
  TakenPictures taken;
  const FrameRenderer renderer{stage, folder, cameras, settings, ledger, progress, taken};
  const std::string character = file_word(stage.character().name);

  std::size_t item = 0;  // pictures so far, the same in every shard
  std::vector<std::shared_ptr<ShownFinding>> shown;
  for (std::size_t r = 0; r < records.size(); ++r) {
    int number = 0;
    for (const std::size_t i : pictured(records[r], findings[r])) {
      Finding& finding = findings[r][i];
      std::string place = "findings/" + character + "_" + rig_word(records[r]) + "_" +
                          file_word(finding.sweep) + "_" + finding.code + "_" +
                          std::to_string(++number);
      shown.push_back(std::make_shared<ShownFinding>(renderer, records, records[r], body, places,
                                                     finding, std::move(place),
                                                     number <= kMeshesOfRig, item, report));
      item += shown.back()->count();
    }
  }
  // What videos are made of goes first, so that encoders work while stills are taken. Each adds to
  // a report of its own: their order is not that in which they are done.
  SideBySide work;
  std::vector<Report> made(7);
  if (plan.sheet_columns > 0) {
    std::size_t of_mapping = 0;
    for (const solver::Mapping mapping : {solver::Mapping::chest, solver::Mapping::spread}) {
      const SideBySide::Group group = work.group();
      const auto sweep = shoot_sweep(renderer, records, mapping, work, group, item, report);
      const std::string stem = "media/" + character + "_" + std::string(mapping_name(mapping));
      const auto after = [&](const auto& write) {
        Report& part = made[of_mapping++];
        work.after(group, [&renderer, sweep, write, &part] {
          if (renderer.ledger.assembles() && sweep->complete()) write(*sweep, part);
        });
      };
      after([&renderer, &plan, stem](const SweepFrames& frames, Report& part) {
        write_sheet(renderer, frames, plan.sheet_columns, stem + "_sheet.png", part);
      });
      after([&renderer, stem](const SweepFrames& frames, Report& part) {
        write_sweep_video(renderer, frames, stem + "_sweep.mp4", part);
      });
      after([&renderer, &records, &findings, mapping, character](const SweepFrames& frames,
                                                                 Report& part) {
        write_review(renderer, frames, records, findings,
                     "review/" + character + "_" + std::string(mapping_name(mapping)), part);
      });
    }
  }
  if (plan.turntable_views > 0)
    shoot_turntable(renderer, records, findings, plan.turntable_views, "media/" + character + "_",
                    work, item, made.back());
  for (const auto& pictures : shown) ShownFinding::add(pictures, work);
  progress.start("frames", item);
  // A studio's own rig may remember what it was asked before: one piece after another, then.
  work.run(std::ranges::any_of(records,
                               [](const RigRecord& each) { return is_external(each.plan.spec); })
               ? 1
               : SIZE_MAX);
  for (const Report& part : made)
    report.media.insert(report.media.end(), part.media.begin(), part.media.end());
  for (const auto& pictures : shown)
    report.meshes.insert(report.meshes.end(), pictures->meshes().begin(), pictures->meshes().end());
}

}  // namespace backbend::validate
