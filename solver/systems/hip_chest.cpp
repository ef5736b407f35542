#include "solver/systems/hip_chest.h"

#include <algorithm>
#include <glm/geometric.hpp>

#include "solver/math/rotation.h"
#include "solver/systems/system_base.h"

namespace backbend::solver {
namespace {

enum HipChestChannel { kHip = 0, kChest = 3, kHipMove = 6, kChestMove = 9 };

}  // namespace

HipChest::HipChest(const RestChain& chain, const std::string& system, std::array<double, 2> depth)
    : bones_(chain, system), depth_(depth) {
  const glm::dvec3 hip = chain.joint.front(), chest = chain.joint.back();
  length_ = glm::length(chest - hip);
  if (!(length_ > 1e-6 * polyline_arcs(chain.joint).back())) {
    throw RigError(system + ": the chain's ends coincide: hip and chest need a distance");
  }
  axes_ = rest_axes(chest - hip, chain.left);
  frame_ = solver::rest_frame(chest - hip, chain.left);
  rest_cv_ = {hip, hip + depth[0] * (chest - hip), chest - depth[1] * (chest - hip), chest};
}

HipChest::Ends HipChest::ends(std::span<const double> c) const {
  Ends e;
  e.hip_turn = euler_turn(axes_, from_euler_xyz(c[kHip], c[kHip + 1], c[kHip + 2]));
  e.chest_turn = euler_turn(axes_, from_euler_xyz(c[kChest], c[kChest + 1], c[kChest + 2]));
  e.hip = e.hip_turn * frame_;
  e.chest = e.chest_turn * frame_;
  e.hip_move = {c[kHipMove], c[kHipMove + 1], c[kHipMove + 2]};
  e.chest_move = {c[kChestMove], c[kChestMove + 1], c[kChestMove + 2]};
  e.cv[0] = rest_cv_[0] + e.hip_move;
  e.cv[3] = rest_cv_[3] + e.chest_move;
  e.cv[1] = e.cv[0] + (depth_[0] * length_) * (e.hip_turn * axes_[0]);
  e.cv[2] = e.cv[3] - (depth_[1] * length_) * (e.chest_turn * axes_[0]);
  e.twist = c[kChest] - c[kHip];
  return e;
}

HipChest::BoxEnds HipChest::ends(std::span<const BoxReal> c) const {
  const auto moved = [&](std::size_t i) { return BoxVector(c[i], c[i + 1], c[i + 2]); };
  const BoxVector along(axes_[0]);
  BoxEnds e;
  e.hip_turn = turn(c, kHip);
  e.chest_turn = turn(c, kChest);
  e.cv[0] = BoxVector(rest_cv_[0]) + moved(kHipMove);
  e.cv[3] = BoxVector(rest_cv_[3]) + moved(kChestMove);
  // A handle lies on its control's own X, which the control's RX leaves where it is.
  const auto handle = [&](std::size_t i) {
    return euler_turn(axes_, from_euler_xyz(BoxReal(0.0), c[i + 1], c[i + 2])) * along;
  };
  e.cv[1] = e.cv[0] + BoxReal(depth_[0] * length_) * handle(kHip);
  e.cv[2] = e.cv[3] - BoxReal(depth_[1] * length_) * handle(kChest);
  return e;
}

void HipChest::set_body(const BodyBox& body, Mapping mapping, std::span<BoxReal> control) const {
  bones_.set_chest(body, mapping, control.subspan(kChest, 3), control.subspan(kChestMove, 3));
}

void HipChest::set_body(const BodyPose& body, Mapping mapping, std::span<double> control) const {
  const std::vector<double> top = fk_controls_for(body, Mapping::chest);
  std::copy(top.end() - 3, top.end(), control.begin() + kChest);
  control[kHip + 2] = body.hip;
  // All zero gives the rest to the last bit, so an empty body pose moves nothing.
  glm::dvec3 move = (body.stretch - 1.0) * (rest_cv_[3] - rest_cv_[0]);
  if (mapping == Mapping::spread)
    move += bones_.pose(fk_controls_for(body, mapping)).joint[3] - bones_.rest.joint[3];
  for (int i = 0; i < 3; ++i) control[kChestMove + i] = move[i];
}

}  // namespace backbend::solver
