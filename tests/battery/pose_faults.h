#pragma once
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "solver/rig/spine_system.h"
#include "validate/calibrate/draw.h"
#include "validate/hunt/control_box.h"

namespace backbend::battery {

/// A fault that a rig shows only in some compound poses of a box: how strong it is at a point, 0..1
/// per axis.
struct PoseFault {
  std::string kind;  // `corner flip`, `ridge`, `bump`
  std::string code;  // of the check that it fails
  double share = 0;  // of the box's volume, in which it is meant to fail
  std::function<double(std::span<const double>)> strength;  // 1 at its top; of a flip 1 or 0
  double level = 1.0;             // the strength at which it is meant to pass the limit
  std::vector<double> top, edge;  // points: where it is strongest, and one where it has that level
  std::vector<double> low, high;  // what holds the whole region
  double half_width = 0.0;        // of an axis: how far from its top half of it is left; flips: 0
  double amount = 0.0;            // what is put in at its top: radians
  std::size_t joint = 0;
  glm::dvec3 axis{0.0};
};

/// Cuts off one corner of the box, with any slant; a joint turns there by 25 to 180 degrees and
/// stays so (BB001).
PoseFault draw_corner_flip(std::size_t axes, double share, std::size_t joints,
                           validate::Draw& draw);
/// A kink (BB010), a roll (BB014) or a turn of the arms (BB020) that falls off like a bell to all
/// sides of a place, or of a line of 20 to 60 % of an axis. Half of it is left `half_width` away;
/// it passes the limit by as much as its share of the volume asks for.
PoseFault draw_bump(double share, double half_width, std::size_t joints, validate::Draw& draw);
PoseFault draw_ridge(double share, double half_width, std::size_t joints, validate::Draw& draw);

/// `sound` (even, under the mapping `chest`) with the fault put into what it solves.
std::unique_ptr<solver::SpineSystem> with_fault(std::unique_ptr<solver::SpineSystem> sound,
                                                const validate::ControlBox& box,
                                                const PoseFault& fault);

}  // namespace backbend::battery
