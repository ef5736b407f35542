#include "solver/rig/live_rig.h"

#include <algorithm>

namespace backbend::solver {
namespace {

bool same_frames(const std::vector<RestFrame>& a, const std::vector<RestFrame>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const RestFrame& f, const RestFrame& g) {
                      return f.name == g.name && f.rig_from_joint == g.rig_from_joint;
                    });
}

bool same_chain(const RestChain& a, const RestChain& b) {
  return a.joint == b.joint && a.left == b.left && a.curve == b.curve &&
         same_frames(a.frame, b.frame) && a.path.point == b.path.point && a.path.up == b.path.up;
}

bool same_names(const SpineSystem& a, const SpineSystem& b) {
  const auto same = [](const Channel& c, const Channel& d) { return c.name == d.name; };
  return a.joint_names() == b.joint_names() &&
         std::equal(a.channels().begin(), a.channels().end(), b.channels().begin(),
                    b.channels().end(), same);
}

}  // namespace

LiveRig::LiveRig(SystemSpec spec, RestChain chain, Drawing drawing)
    : spec_(std::move(spec)),
      chain_(std::move(chain)),
      drawing_(drawing),
      system_(build_system(spec_, chain_)) {}

bool LiveRig::redraw(const RestChain& chain) {
  if (drawing_ == Drawing::frozen || same_chain(chain, chain_)) return false;
  std::unique_ptr<SpineSystem> built = build_system(spec_, chain);
  if (!same_names(*built, *system_)) {
    throw RigError(spec_.system + ": on the new chain the rig has " +
                   std::to_string(built->joint_names().size()) + " joints, not " +
                   std::to_string(system_->joint_names().size()) +
                   ", or other names; keys and weights would lose their owner");
  }
  system_ = std::move(built);
  chain_ = chain;
  return true;
}

}  // namespace backbend::solver
