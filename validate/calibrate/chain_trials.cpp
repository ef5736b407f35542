#include <oneapi/tbb/parallel_for.h>

#include <cmath>

#include "validate/calibrate/calibrate.h"
#include "validate/calibrate/faults.h"
#include "validate/metrics/chain/rig_probe.h"

namespace backbend::validate {
namespace {

enum ChainStream : std::uint64_t { kChainThreshold = 1, kChainClean = 2, kChainFault = 1000 };

/// A rest chain of length 1: straight, or bent gently as spines are.
solver::RestChain random_chain(Draw& draw) {
  solver::RestChain chain;
  const bool straight = draw.coin();
  const double sway = straight ? 0.0 : draw.uniform(-0.02, 0.02);
  const double sway_twice = straight ? 0.0 : draw.uniform(-0.01, 0.01);
  for (int i = 0; i <= 3; ++i) {
    const double s = i / 3.0;
    chain.joint.push_back(
        {0.0, s, sway * std::sin(kPi * s) + sway_twice * std::sin(2.0 * kPi * s)});
  }
  return chain;
}

/// A clean pose of `even` with everything it is measured against.
struct CleanChain {
  std::unique_ptr<solver::SpineSystem> rig;
  std::vector<glm::dvec3> curve, rest_curve;
  solver::SpinePose pose;

  CleanChain(int bones, std::uint64_t seed, std::uint64_t stream) {
    Draw draw(seed, stream);
    rig = build_system({"even", {{"bones", static_cast<double>(bones)}}}, random_chain(draw));
    const auto mapping = draw.coin() ? solver::Mapping::chest : solver::Mapping::spread;
    const std::vector<double> control = rig->controls_for(random_pose(draw), mapping);
    std::vector<double> rest;
    for (const solver::Channel& channel : rig->channels()) rest.push_back(channel.rest);
    curve = rig->intended_curve(control, kCurvePoints);
    rest_curve = rig->intended_curve(rest, kCurvePoints);
    pose = rig->solve(control);
  }
  ChainMeasures measure() const { return measure_chain({pose, rig->rest(), curve, rest_curve}); }
};

struct ChainReading {
  double value = std::numeric_limits<double>::quiet_NaN();
  bool placed = false;
};

/// Runs one reading per pose, in parallel, each from its own stream.
template <typename Read>
std::vector<ChainReading> read_all(std::size_t count, Read read) {
  std::vector<ChainReading> out(count);
  oneapi::tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) { out[i] = read(i); });
  return out;
}

std::vector<double> values_of(const std::vector<ChainReading>& readings) {
  std::vector<double> out;
  for (const ChainReading& r : readings) out.push_back(r.value);
  return out;
}

FaultTrial trial_of(double size, const std::vector<ChainReading>& readings, double threshold) {
  FaultTrial trial{size, values_of(readings), 0};
  for (const ChainReading& r : readings) trial.placed += r.value > threshold && r.placed;
  return trial;
}

/// One detector on chains: what it reads, and how a fault of a size gets into the pose.
struct ChainDetector {
  std::string name, code, unit;
  double target, floor;
  std::vector<double> sizes;
  std::function<double(const ChainMeasures&)> read;
  std::function<int(const ChainMeasures&)> place;  // joint; -1: none
  /// Injects and returns the joint it went into, -1 for none.
  std::function<int(CleanChain&, Draw&, double size)> inject;
};

/// Clean poses, measured once for all detectors.
std::vector<ChainMeasures> measure_clean(const CalibrationPlan& plan, int bones,
                                         std::uint64_t stream, const CalibrationWatch& watch) {
  std::vector<ChainMeasures> out(plan.clean_poses);
  oneapi::tbb::parallel_for(std::size_t{0}, out.size(), [&](std::size_t i) {
    out[i] = CleanChain(bones, plan.seed + stream, i).measure();
    watch.step();
  });
  return out;
}

std::vector<double> read_clean(const std::vector<ChainMeasures>& poses,
                               const ChainDetector& detector) {
  std::vector<double> out;
  for (const ChainMeasures& m : poses) out.push_back(detector.read(m));
  return out;
}

std::vector<FaultTrial> try_faults(const CalibrationPlan& plan, int bones,
                                   const ChainDetector& detector, double threshold,
                                   const CalibrationWatch& watch) {
  std::vector<FaultTrial> trials;
  for (std::size_t k = 0; k < detector.sizes.size(); ++k) {
    const auto readings = read_all(plan.fault_poses, [&](std::size_t i) {
      CleanChain chain(bones, plan.seed + kChainFault + k, i);
      Draw draw(plan.seed + kChainFault + k, ~static_cast<std::uint64_t>(i));
      const int joint = detector.inject(chain, draw, detector.sizes[k]);
      const ChainMeasures measured = chain.measure();
      watch.step();
      return ChainReading{detector.read(measured),
                          joint < 0 || std::abs(detector.place(measured) - joint) <= 1};
    });
    trials.push_back(trial_of(detector.sizes[k], readings, threshold));
  }
  return trials;
}

/// An inner joint that has two neighbours to either side.
int inner_joint(const CleanChain& chain, Draw& draw) {
  const std::size_t joints = chain.pose.position.size();
  return static_cast<int>(2 + draw.index(joints > 5 ? joints - 5 : 1));
}

}  // namespace

std::vector<Sensitivity> try_chain_detectors(const CalibrationPlan& plan, int bones,
                                             const CalibrationWatch& watch) {
  const ChainDetector kink{
      "chain kink",
      "BB010",
      "deg",
      bones >= 20 ? 1.0 : 2.0,
      0.1,
      {0.25, 0.5, 1.0, 2.0, 4.0},
      [](const ChainMeasures& m) { return m.kink_deg; },
      [](const ChainMeasures& m) { return m.kink_joint; },
      [](CleanChain& chain, Draw& draw, double size) {
        const int joint = inner_joint(chain, draw);
        const std::vector<double>& fraction = chain.rig->arc_fraction();
        // A kink turns about an axis across the chain; one along it would be a twist.
        const glm::dvec3 along =
            glm::normalize(chain.pose.position[joint + 1] - chain.pose.position[joint]);
        const glm::dvec3 axis = glm::normalize(glm::cross(along, draw.direction()));
        inject_kink(chain.pose, fraction, fraction[joint], axis * radians_from(size));
        return joint;
      }};
  const ChainDetector roll{"chain twist jump",
                           "BB014",
                           "deg",
                           bones >= 7 ? 1.0 : 2.0,
                           0.4,
                           {0.25, 0.5, 1.0, 2.0, 4.0},
                           [](const ChainMeasures& m) { return m.twist_jump_deg; },
                           [](const ChainMeasures& m) { return m.twist_jump_joint; },
                           [](CleanChain& chain, Draw& draw, double size) {
                             const int joint = inner_joint(chain, draw);
                             const std::vector<double>& fraction = chain.rig->arc_fraction();
                             inject_roll(chain.pose, chain.rig->rest(), fraction, fraction[joint],
                                         fraction[joint + 1],
                                         radians_from(draw.coin() ? size : -size));
                             return joint;
                           }};
  const ChainDetector drift_turn{
      "arm drift, rotation",
      "BB020",
      "deg",
      0.2,
      0.01,
      {0.02, 0.05, 0.1, 0.2, 0.5},
      [](const ChainMeasures& m) { return m.arms.rotation_deg; },
      [](const ChainMeasures&) { return -1; },
      [](CleanChain& chain, Draw& draw, double size) {
        inject_arm_drift(chain.pose, draw.direction() * radians_from(size), glm::dvec3(0.0));
        return -1;
      }};
  const ChainDetector drift_shift{
      "arm drift, translation",
      "BB021",
      "% of spine",
      0.3,  // 0.1 % of the height of a human, whose spine is a third of it
      0.01,
      {0.02, 0.05, 0.1, 0.3, 1.0},
      [](const ChainMeasures& m) { return 100.0 * m.arms.shift; },
      [](const ChainMeasures&) { return -1; },
      [](CleanChain& chain, Draw& draw, double size) {
        inject_arm_drift(
            chain.pose, glm::dvec3(0.0),
            draw.direction() * (0.01 * size * chain_length(chain.rig->rest().position)));
        return -1;
      }};
  std::vector<const ChainDetector*> detectors{&kink, &drift_turn, &drift_shift};
  if (static_cast<std::size_t>(bones) + 1 >= kLeastTwistJumpJoints)
    detectors.insert(detectors.begin() + 1, &roll);
  std::size_t faults = 0;
  for (const ChainDetector* detector : detectors) faults += detector->sizes.size();
  watch.begin("chain of " + std::to_string(bones) + " bones",
              2 * plan.clean_poses + faults * plan.fault_poses);
  const std::vector<ChainMeasures> set = measure_clean(plan, bones, kChainThreshold, watch);
  const std::vector<ChainMeasures> test = measure_clean(plan, bones, kChainClean, watch);
  std::vector<Sensitivity> out;
  for (const ChainDetector* detector : detectors) {
    const double threshold = threshold_from(read_clean(set, *detector), detector->floor);
    out.push_back(judge_detector(detector->name, detector->code, std::to_string(bones) + " bones",
                                 detector->unit, detector->target, threshold,
                                 read_clean(test, *detector),
                                 try_faults(plan, bones, *detector, threshold, watch)));
  }
  return out;
}

Sensitivity try_flip_detector(const CalibrationPlan& plan, const CalibrationWatch& watch) {
  constexpr int kBones = 10, kIntervals = 60;
  const std::vector<double> sizes{1.2, 2.0, 5.0, 20.0, 180.0};
  const std::size_t sweeps = plan.clean_poses;  // each of hundreds of poses
  watch.begin("flips", sweeps + sizes.size() * plan.fault_poses);
  const auto read = [&](std::uint64_t seed, std::size_t i, double size) {
    Draw draw(seed, i);
    const auto rig =
        build_system({"even", {{"bones", static_cast<double>(kBones)}}}, random_chain(draw));
    const solver::BodyPose to = random_pose(draw);
    const double swept =
        degrees(to.extension + to.flexion + std::abs(to.side) + std::abs(to.twist));
    FlipRig clean = probe(*rig, straight_path(*rig, {}, to, solver::Mapping::chest));
    const std::size_t joint = draw.index(kBones);
    const double t = draw.uniform(0.02, 0.98);
    const glm::dvec3 turn = draw.direction() * radians_from(size);
    const FlipReport report = find_flips(size > 0.0 ? inject_flip(clean, joint, t, turn) : clean,
                                         flip_settings(*rig, kIntervals, swept));
    double largest = 0.0;
    bool placed = false;
    for (const Jump& jump : report.jumps) {
      largest = std::max(largest, jump.size_deg());
      placed = placed || (std::abs(jump.t - t) < 1e-5 && jump.joints[0].joint == joint &&
                          std::abs(jump.size_deg() - size) < 1e-3 * size);
    }
    watch.step();
    return ChainReading{report.certified ? largest : std::numeric_limits<double>::quiet_NaN(),
                        placed};
  };
  const std::vector<double> clean = values_of(
      read_all(sweeps, [&](std::size_t i) { return read(plan.seed + kChainClean, i, 0.0); }));
  std::vector<FaultTrial> trials;
  for (std::size_t k = 0; k < sizes.size(); ++k)
    trials.push_back(trial_of(
        sizes[k],
        read_all(plan.fault_poses,
                 [&](std::size_t i) { return read(plan.seed + kChainFault + k, i, sizes[k]); }),
        0.0));
  // Its threshold is not set by clean poses: the certificate knows no noise.
  return judge_detector("flip", "BB001", std::to_string(kBones) + " bones", "deg", 1.2, 0.0, clean,
                        trials);
}

}  // namespace backbend::validate
