#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "validate/calibrate/calibration_body.h"
#include "validate/calibrate/draw.h"

namespace backbend::validate {

/// One clean pose of a body, and everything that a fault is put into.
struct Case {
  solver::BodyPose pose;
  std::vector<double> control;
  solver::SpinePose chain;
  BodyMeasures clean;
};

/// A stretch of the spine that holds one of the body's own inner joints and no other: what turns
/// there turns that joint. Arc fractions.
struct FaultPlace {
  double from = 0.0, to = 0.0;  // half way to the joint below and to the one above
  double joint = 0.0;
};

/// Poses of one body by two clean rigs: the same construction on different numbers of bones, so
/// that what tells the two apart is what healthy rigs may differ by.
class BodyPoses {
 public:
  explicit BodyPoses(const CalibrationBody& body);

  /// The next pose of a stream that the body is thin enough for, as measured.
  Case draw_case(Draw& draw) const;
  PosedCharacter posed(const Case& c) const { return body_.stage().pose(*rig_, c.chain); }
  BodyMeasures measure(const Case& c, const skin::PosedMesh& mesh) const;
  /// The same pose by the other rig.
  PosedCharacter posed_by_other(const Case& c) const;
  BodyMeasures measure_other(const Case& c, const PosedCharacter& other) const;
  /// Around one of the body's inner joints, away from both ends, where slices can see it.
  FaultPlace fault_place(Draw& draw) const;
  const solver::SpineSystem& rig() const { return *rig_; }
  const CalibrationBody& body() const { return body_; }
  double slice_fraction(int slice) const {
    return slice < 0 ? -1.0 : body_.metrics().slices().slice[static_cast<std::size_t>(slice)].s;
  }

 private:
  std::unique_ptr<solver::SpineSystem> build(int bones) const;

  const CalibrationBody& body_;
  std::unique_ptr<solver::SpineSystem> rig_, other_;
  RigAtRest rig_rest_, other_rest_;
};

/// What a detector read, and where (arc fraction; below 0: it names no place).
struct Reading {
  double value = std::numeric_limits<double>::quiet_NaN();
  double place = -1.0;
  bool placed = false;
};

/// A detector, and the fault that it is for.
struct MeshDetector {
  std::string name, code, unit;
  double target = 0.0, floor = 0.0;
  std::vector<double> sizes;
  /// From a pose as measured, and the same pose by the other rig.
  std::function<Reading(const BodyMeasures& pose, const BodyMeasures& reference)> read;
  /// Puts a fault into the chain before it is skinned, or into the mesh after; returns its place.
  std::function<double(Case&, Draw&, double size)> inject_chain;
  std::function<double(skin::PosedMesh&, Draw&, double size)> inject_mesh;
};

/// The detectors that mean something on a body. Kinks alone, without another rig to compare with,
/// are promised for fine spines only; where few slices have rings there is nothing to look at.
std::vector<MeshDetector> detectors_for(const BodyPoses& poses);

}  // namespace backbend::validate
