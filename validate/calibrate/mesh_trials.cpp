#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "validate/calibrate/body_poses.h"
#include "validate/calibrate/calibrate.h"
#include "validate/calibrate/faults.h"

namespace backbend::validate {
namespace {

enum MeshStream : std::uint64_t { kMeshThreshold = 11, kMeshClean = 12, kMeshFault = 2000 };

std::vector<double> values_of(const std::vector<Reading>& readings) {
  std::vector<double> out;
  for (const Reading& r : readings) out.push_back(r.value);
  return out;
}

/// What every detector reads on clean poses: [detector][pose].
std::vector<std::vector<double>> read_clean(const CalibrationPlan& plan, const BodyPoses& poses,
                                            const std::vector<MeshDetector>& detectors,
                                            std::uint64_t stream, const CalibrationWatch& watch) {
  std::vector<std::vector<double>> out(detectors.size(), std::vector<double>(plan.clean_poses));
  oneapi::tbb::parallel_for(std::size_t{0}, plan.clean_poses, [&](std::size_t i) {
    Draw draw(plan.seed + stream, i);
    const Case c = poses.draw_case(draw);
    const BodyMeasures reference = poses.measure_other(c, poses.posed_by_other(c));
    for (std::size_t d = 0; d < detectors.size(); ++d)
      out[d][i] = detectors[d].read(c.clean, reference).value;
    watch.step();
  });
  return out;
}

std::vector<FaultTrial> try_faults(const CalibrationPlan& plan, const BodyPoses& poses,
                                   const MeshDetector& detector, double threshold,
                                   const CalibrationWatch& watch) {
  // Within one and a half bones: a fault between two joints shows at either.
  const double near = 1.5 / poses.body().bones();
  std::vector<FaultTrial> trials;
  for (std::size_t k = 0; k < detector.sizes.size(); ++k) {
    const double size = detector.sizes[k];
    std::vector<Reading> readings(plan.fault_poses);
    oneapi::tbb::parallel_for(std::size_t{0}, readings.size(), [&](std::size_t i) {
      Draw draw(plan.seed + kMeshFault + k, i);
      Case c = poses.draw_case(draw);
      const BodyMeasures reference = poses.measure_other(c, poses.posed_by_other(c));
      double place = -1.0;
      if (detector.inject_chain) place = detector.inject_chain(c, draw, size);
      skin::PosedMesh mesh = poses.posed(c).mesh;
      if (detector.inject_mesh) place = detector.inject_mesh(mesh, draw, size);
      readings[i] = detector.read(poses.measure(c, mesh), reference);
      readings[i].placed = place < 0.0 || std::abs(readings[i].place - place) <= near;
      watch.step();
    });
    FaultTrial trial{size, values_of(readings), 0};
    for (const Reading& r : readings) trial.placed += r.value > threshold && r.placed;
    trials.push_back(std::move(trial));
  }
  return trials;
}

Reading largest_of(const std::vector<double>& profile, const BodyPoses& poses) {
  Reading out;
  for (std::size_t r = 0; r < profile.size(); ++r)
    if (!std::isnan(profile[r]) && !(profile[r] <= out.value))
      out = {profile[r], poses.slice_fraction(static_cast<int>(r)), false};
  return out;
}

MeshDetector kink_detector(const BodyPoses& poses) {
  MeshDetector d;
  d.code = "BB011";
  d.unit = "deg";
  d.target = poses.body().bones() >= 20 ? 1.0 : 2.0;
  d.floor = 0.25;
  d.sizes = {0.5, 1.0, 2.0, 4.0, 8.0};
  d.inject_chain = [&poses](Case& c, Draw& draw, double size) {
    const double at = poses.fault_place(draw).from;
    const std::vector<double>& fraction = poses.rig().arc_fraction();
    const std::size_t below =
        static_cast<std::size_t>(std::ranges::upper_bound(fraction, at) - fraction.begin() - 1);
    const glm::dvec3 along = glm::normalize(c.chain.position[below + 1] - c.chain.position[below]);
    const glm::dvec3 axis = glm::normalize(glm::cross(along, draw.direction()));
    inject_kink(c.chain, fraction, at, axis * radians_from(size));
    return at;
  };
  return d;
}

MeshDetector absolute_kink(const BodyPoses& poses) {
  MeshDetector d = kink_detector(poses);
  d.name = "mesh kink";
  d.read = [&poses](const BodyMeasures& pose, const BodyMeasures&) {
    const SliceMeasures& s = pose.slices;
    return Reading{s.kink_worst_deg, poses.slice_fraction(s.kink_slice), false};
  };
  return d;
}

MeshDetector paired_kink_detector(const BodyPoses& poses) {
  MeshDetector d = kink_detector(poses);
  d.name = "mesh kink, paired";
  d.read = [&poses](const BodyMeasures& pose, const BodyMeasures& reference) {
    return largest_of(paired_kink(pose.slices, reference.slices, poses.body().metrics().window()),
                      poses);
  };
  return d;
}

MeshDetector paired_twist_detector(const BodyPoses& poses) {
  MeshDetector d;
  d.name = "mesh twist jump, paired";
  d.code = "BB036";
  d.unit = "deg";
  d.target = 5.0;
  d.floor = 0.25;
  d.sizes = {1.0, 2.0, 5.0, 10.0, 20.0};
  d.read = [&poses](const BodyMeasures& pose, const BodyMeasures& reference) {
    return largest_of(
        paired_twist_jump(pose.slices, reference.slices, poses.body().metrics().window()), poses);
  };
  d.inject_chain = [&poses](Case& c, Draw& draw, double size) {
    const FaultPlace at = poses.fault_place(draw);
    inject_roll(c.chain, poses.rig().rest(), poses.rig().arc_fraction(), at.from, at.to,
                radians_from(draw.coin() ? size : -size));
    return at.joint;
  };
  return d;
}

/// Slices between a quarter and three quarters of the torso that have a ring.
std::vector<std::size_t> middle_slices(const SpineSlices& slices) {
  std::vector<std::size_t> out;
  for (std::size_t r = slices.slice.size() / 4; r < slices.slice.size() * 3 / 4; ++r)
    if (!slices.slice[r].ring.empty()) out.push_back(r);
  return out;
}

MeshDetector slice_loss_detector(const BodyPoses& poses) {
  MeshDetector d;
  d.name = "slice loss, paired";
  d.code = "BB030";
  d.unit = "%";
  d.target = 5.0;
  d.floor = 0.5;
  d.sizes = {1.0, 2.0, 5.0, 10.0};
  d.read = [&poses](const BodyMeasures& pose, const BodyMeasures& reference) {
    std::vector<double> loss;
    for (std::size_t r = 0; r < pose.slices.area_ratio.size(); ++r)
      loss.push_back(100.0 *
                     std::max(0.0, reference.slices.area_ratio[r] - pose.slices.area_ratio[r]));
    return largest_of(loss, poses);
  };
  d.inject_mesh = [&poses](skin::PosedMesh& mesh, Draw& draw, double size) {
    const SpineSlices& slices = poses.body().metrics().slices();
    const std::vector<std::size_t> middle = middle_slices(slices);
    const std::size_t slice = middle[draw.index(middle.size())];
    inject_slice_loss(mesh.position, pose_slices(slices, mesh.position), slice, 0.01 * size,
                      0.5 * slices.spine_length / poses.body().bones());
    return slices.slice[slice].s;
  };
  return d;
}

MeshDetector arm_detector(const BodyPoses& poses) {
  MeshDetector d;
  d.name = "arm drift on the mesh";
  d.code = "BB022";
  d.unit = "% of height";
  d.target = 0.1;
  d.floor = 0.005;
  d.sizes = {0.02, 0.05, 0.1, 0.5};
  d.read = [](const BodyMeasures& pose, const BodyMeasures&) {
    return Reading{100.0 * pose.arm_drift, -1.0, true};
  };
  d.inject_chain = [&poses](Case& c, Draw& draw, double size) {
    inject_arm_drift(c.chain, glm::dvec3(0.0),
                     draw.direction() * (0.01 * size * poses.body().metrics().height()));
    return -1.0;
  };
  return d;
}

}  // namespace

std::vector<MeshDetector> detectors_for(const BodyPoses& poses) {
  std::vector<MeshDetector> out;
  const SpineSlices& slices = poses.body().metrics().slices();
  if (slices.measured() == slices.slice.size()) {
    if (poses.body().bones() >= 20) out.push_back(absolute_kink(poses));
    out.push_back(paired_kink_detector(poses));
    out.push_back(paired_twist_detector(poses));
  }
  if (!middle_slices(slices).empty()) out.push_back(slice_loss_detector(poses));
  if (poses.body().driver().arms_follow_chest()) out.push_back(arm_detector(poses));
  return out;
}

std::vector<Sensitivity> try_mesh_detectors(const CalibrationPlan& plan,
                                            const CalibrationBody& body,
                                            const CalibrationWatch& watch) {
  const BodyPoses poses(body);
  const std::vector<MeshDetector> detectors = detectors_for(poses);
  std::size_t faults = 0;
  for (const MeshDetector& detector : detectors) faults += detector.sizes.size();
  watch.begin("mesh of " + body.name(), 2 * plan.clean_poses + faults * plan.fault_poses);
  const auto set = read_clean(plan, poses, detectors, kMeshThreshold, watch);
  const auto test = read_clean(plan, poses, detectors, kMeshClean, watch);
  std::vector<Sensitivity> out;
  for (std::size_t d = 0; d < detectors.size(); ++d) {
    const MeshDetector& detector = detectors[d];
    const double threshold = threshold_from(set[d], detector.floor);
    out.push_back(judge_detector(detector.name, detector.code, body.name(), detector.unit,
                                 detector.target, threshold, test[d],
                                 try_faults(plan, poses, detector, threshold, watch)));
  }
  return out;
}

}  // namespace backbend::validate
