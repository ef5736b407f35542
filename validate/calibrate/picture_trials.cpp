#include <algorithm>
#include <cmath>
#include <optional>
#include <span>

#include "validate/calibrate/body_poses.h"
#include "validate/calibrate/calibrate.h"
#include "validate/calibrate/faults.h"
#include "validate/camera/photographer_pool.h"
#include "validate/evidence/image_readings.h"
#include "validate/measure/arm_pose.h"
#include "validate/metrics/chain/rig_probe.h"
#include "validate/tasks/side_by_side.h"

namespace backbend::validate {
namespace {

enum PictureStream : std::uint64_t {
  kPictureThreshold = 21,
  kPictureClean = 22,
  kPictureFault = 4000
};

constexpr int kCoarseBones = 12;
constexpr std::size_t kSweepPoses = 21;  // of the sweeps in which flips are looked for

/// Holds every pose that a body is drawn in.
render::Bounds wide_box(const BodyPoses& poses) {
  const Stage& stage = poses.body().stage();
  render::Bounds box = stage.bounds(stage.rest());
  const double bend = radians_from(90.0), side = radians_from(45.0);
  for (const solver::BodyPose& pose :
       {solver::BodyPose{bend, 0, 0, 0}, solver::BodyPose{0, bend, 0, 0},
        solver::BodyPose{0, 0, side, 0}, solver::BodyPose{0, 0, -side, 0}}) {
    const std::vector<double> control = poses.rig().controls_for(pose, solver::Mapping::chest);
    box.add(stage.bounds(stage.pose(poses.rig(), control).mesh));
  }
  return box;
}

/// What pictures and geometry read of one case, neither knowing of the other.
struct Pair {
  double picture = std::numeric_limits<double>::quiet_NaN();
  double geometry = std::numeric_limits<double>::quiet_NaN();
};

/// A detector that looks at pictures, beside the one that measures the same fault.
struct PictureDetector {
  std::string name, code{}, unit{}, reading_unit;
  double target = 0.0;  // the smallest fault that pictures have to show
  double floor = 0.0;   // a smaller reading is not visible
  double geometry_threshold = 0.0;
  std::vector<double> sizes;
  std::function<Pair(std::uint64_t seed, std::size_t i, double size)> read{};  // size 0: clean
};

std::vector<double> pictures_of(std::span<const Pair> pairs) {
  std::vector<double> out;
  for (const Pair& pair : pairs) out.push_back(pair.picture);
  return out;
}

Agreement agreement_of(std::span<const Pair> pairs, double threshold, double geometry) {
  Agreement out;
  for (const Pair& pair : pairs) out.count(pair.geometry > geometry, pair.picture > threshold);
  return out;
}

/// One detector, and how many poses it is tried on.
struct Trial {
  PictureDetector detector;
  std::size_t clean = 0, faults = 0;  // faults: of each size

  std::size_t cases() const { return 2 * clean + detector.sizes.size() * faults; }
  /// The cases in their order: clean ones that set the threshold, clean ones that it is tried on,
  /// then faults by size.
  Pair read(const CalibrationPlan& plan, std::size_t i) const {
    if (i < clean) return detector.read(plan.seed + kPictureThreshold, i, 0.0);
    if (i < 2 * clean) return detector.read(plan.seed + kPictureClean, i - clean, 0.0);
    const std::size_t fault = i - 2 * clean, k = fault / faults;
    return detector.read(plan.seed + kPictureFault + k, fault % faults, detector.sizes[k]);
  }
};

Sensitivity judge(const Trial& trial, std::span<const Pair> pairs, const std::string& body) {
  const PictureDetector& detector = trial.detector;
  const auto set = pairs.subspan(0, trial.clean), test = pairs.subspan(trial.clean, trial.clean);
  const double threshold = threshold_from(pictures_of(set), detector.floor);
  std::vector<FaultTrial> trials;
  std::vector<Agreement> agreement;
  for (std::size_t k = 0; k < detector.sizes.size(); ++k) {
    const auto faulted = pairs.subspan(2 * trial.clean + k * trial.faults, trial.faults);
    trials.push_back({detector.sizes[k], pictures_of(faulted), 0});
    agreement.push_back(agreement_of(faulted, threshold, detector.geometry_threshold));
  }
  Sensitivity out = judge_detector(detector.name, detector.code, body, detector.unit,
                                   detector.target, threshold, pictures_of(test), trials);
  out.threshold_unit = detector.reading_unit;
  out.clean_agreement = agreement_of(test, threshold, detector.geometry_threshold);
  for (std::size_t k = 0; k < agreement.size(); ++k) out.hits[k].agreement = agreement[k];
  return out;
}

/// One body before the cameras.
class PictureTrials {
 public:
  PictureTrials(const BodyPoses& poses, const std::vector<Sensitivity>& measured)
      : poses_(poses),
        mesh_(detectors_for(poses)),
        measured_(measured),
        cameras_(poses.body().stage(), wide_box(poses)) {}

  /// Sweeps of one pop each, as a rig's own controls would make it.
  PictureDetector flips() {
    PictureDetector d{.name = "picture of a flip",
                      .code = "BB001",
                      .unit = "deg",
                      .reading_unit = "sigma",
                      .target = 60.0,
                      .floor = kPopScore,
                      .sizes = {5.0, 10.0, 20.0, 60.0}};
    d.read = [this](std::uint64_t seed, std::size_t i, double size) {
      Draw draw(seed, i);
      return read_sweep(poses_.draw_case(draw).pose, draw, size);
    };
    return d;
  }
  /// The detectors whose fault geometry measures on this body, pose by pose.
  std::vector<PictureDetector> of_poses() {
    std::vector<PictureDetector> out;
    add(out, "mesh kink, paired",
        {.name = "picture of a kink",
         .reading_unit = "deg",
         .target = 32.0,
         .floor = kVisibleTiltDeg,
         .sizes = {4.0, 8.0, 16.0, 32.0}},
        [this](const PosedCharacter& posed, const Case& c) {
          return tilt_jump(views(posed), views(poses_.posed_by_other(c)));
        });
    add(out, "arm drift on the mesh",
        {.name = "picture of arm drift",
         .reading_unit = "px",
         .target = 1.0,
         .floor = kVisibleArmPx,
         .sizes = {0.2, 0.5, 1.0, 2.0}},
        [this](const PosedCharacter& posed, const Case&) {
          const auto carried_by = [&](const solver::RigidMotion& motion) {
            return views(pose_with_arms(poses_.body().stage(), poses_.rig(), posed.spine, motion));
          };
          return arm_shift(carried_by(posed.spine.arms), carried_by(posed.spine.chest));
        });
    // On finer spines the fault is lower than a row of pixels.
    if (poses_.body().bones() <= kCoarseBones)
      add(out, "slice loss, paired",
          {.name = "picture of slice loss",
           .reading_unit = "%",
           .target = 40.0,
           .floor = kVisibleNarrowing,
           .sizes = {5.0, 10.0, 20.0, 40.0}},
          [this](const PosedCharacter& posed, const Case& c) {
            return narrowing(views(posed), views(poses_.posed_by_other(c)));
          });
    return out;
  }

 private:
  using Look = std::function<ImageReading(const PosedCharacter&, const Case&)>;

  PoseViews views(const PosedCharacter& posed) {
    return take_views(*PhotographerPool::Loan(cameras_), posed);
  }

  /// Nothing is added where the body gives geometry nothing to measure.
  void add(std::vector<PictureDetector>& out, const std::string& name, PictureDetector detector,
           Look look) {
    const auto fault = std::ranges::find(mesh_, name, &MeshDetector::name);
    const auto row = std::ranges::find(measured_, name, &Sensitivity::detector);
    if (fault == mesh_.end() || row == measured_.end()) return;
    detector.code = fault->code;
    detector.unit = fault->unit;
    detector.geometry_threshold = row->threshold;
    detector.read = [this, &fault = *fault, look = std::move(look)](std::uint64_t seed,
                                                                    std::size_t i, double size) {
      Draw draw(seed, i);
      Case c = poses_.draw_case(draw);
      const Case clean = c;
      if (size > 0.0 && fault.inject_chain) fault.inject_chain(c, draw, size);
      PosedCharacter posed = poses_.posed(c);
      if (size > 0.0 && fault.inject_mesh) fault.inject_mesh(posed.mesh, draw, size);
      const BodyMeasures other = poses_.measure_other(clean, poses_.posed_by_other(clean));
      const ImageReading seen = look(posed, clean);
      // Nothing of it in any camera: nothing was seen to differ.
      return Pair{std::isnan(seen.value) ? 0.0 : seen.value,
                  fault.read(poses_.measure(c, posed.mesh), other).value};
    };
    out.push_back(std::move(detector));
  }

  /// A sweep to `to` and, from somewhere on, one bone's length of it rolled by `size` degrees.
  Pair read_sweep(const solver::BodyPose& to, Draw& draw, double size) {
    const solver::SpineSystem& rig = poses_.rig();
    const double start = draw.uniform(0.1, 0.9);
    const FaultPlace at = poses_.fault_place(draw);
    const double roll = radians_from(draw.coin() ? size : -size);
    const ControlPath path = straight_path(rig, {}, to, solver::Mapping::chest);
    const auto solve = [&](double t) {
      solver::SpinePose pose = rig.solve(path(t));
      if (size > 0.0 && t >= start)
        inject_roll(pose, rig.rest(), rig.arc_fraction(), at.from, at.to, roll);
      return pose;
    };
    const auto posed = [&](std::size_t p) {
      return poses_.body().stage().pose(rig, solve(static_cast<double>(p) / (kSweepPoses - 1)));
    };
    // The first two poses have no motion to change.
    std::vector<double> change{0.0, 0.0};
    PosedCharacter first = posed(0), before = posed(1);
    const PhotographerPool::Loan camera(cameras_);
    PoseViews then = take_views(*camera, before, &first);
    for (std::size_t p = 2; p < kSweepPoses; ++p) {
      PosedCharacter now = posed(p);
      PoseViews seen = take_views(*camera, now, &before);
      const double value = motion_change(then, seen).value;
      change.push_back(std::isnan(value) ? 0.0 : value);
      before = std::move(now);
      then = std::move(seen);
    }
    const FlipRig turns = [&](double t, FlipSample& sample) {
      const solver::SpinePose pose = solve(t);
      sample.turn = pose.turn;
      sample.position = pose.position;
    };
    const double swept =
        degrees(to.extension + to.flexion + std::abs(to.side) + std::abs(to.twist));
    const FlipReport flips =
        find_flips(turns, flip_settings(rig, static_cast<int>(kSweepPoses) - 1, swept));
    Pair pair{std::ranges::max(pop_scores(change)), flips.certified ? 0.0 : std::nan("")};
    for (const Jump& jump : flips.jumps) pair.geometry = std::max(pair.geometry, jump.size_deg());
    return pair;
  }

  const BodyPoses& poses_;
  const std::vector<MeshDetector> mesh_;
  const std::vector<Sensitivity>& measured_;
  PhotographerPool cameras_;
};

}  // namespace

std::vector<Sensitivity> try_pictures(const CalibrationPlan& plan, const CalibrationBody& body,
                                      const std::vector<Sensitivity>& measured,
                                      const CalibrationWatch& watch) {
  const BodyPoses poses(body);
  PictureTrials trials(poses, measured);
  // A pose before six cameras costs what ten measured poses do, and a sweep what twenty of those.
  const auto share = [](std::size_t count, std::size_t of) {
    return std::max<std::size_t>(count / of, 1);
  };
  const std::size_t clean = share(plan.clean_poses, 4), faults = share(plan.fault_poses, 4);
  const std::size_t sweeps = share(plan.clean_poses, 20), flips = share(plan.fault_poses, 10);
  std::vector<Trial> tried{{trials.flips(), sweeps, flips}};
  for (PictureDetector& detector : trials.of_poses())
    tried.push_back({std::move(detector), clean, faults});
  // All cases of all detectors go side by side: they depend on nothing but their numbers.
  std::vector<std::pair<const Trial*, std::size_t>> cases;
  for (const Trial& trial : tried)
    for (std::size_t i = 0; i < trial.cases(); ++i) cases.emplace_back(&trial, i);
  watch.begin("pictures of " + body.name(), cases.size());
  std::vector<Pair> pairs(cases.size());
  for_each_side_by_side(cases.size(), [&](std::size_t i) {
    pairs[i] = cases[i].first->read(plan, cases[i].second);
    watch.step();
  });
  std::vector<Sensitivity> out;
  std::size_t first = 0;
  for (const Trial& trial : tried) {
    out.push_back(judge(trial, std::span(pairs).subspan(first, trial.cases()), body.name()));
    first += trial.cases();
  }
  return out;
}

}  // namespace backbend::validate
