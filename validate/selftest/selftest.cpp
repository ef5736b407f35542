#include "validate/selftest/selftest.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "validate/judge/confirmed.h"
#include "validate/selftest/properties.h"
#include "validate/sweeps/external_spec.h"

namespace backbend::validate {

double Property::margin() const {
  if (!(worst > 0.0)) return std::isnan(worst) ? 0.0 : std::numeric_limits<double>::infinity();
  return bound / worst;
}

std::vector<Property> selftest(const SelftestRequest& request, Progress& progress) {
  const ConfirmedCharacter confirmed = load_confirmed(request.character, request.hints);
  const auto controls =
      confirmed.sidecar ? confirmed.sidecar->controls : std::vector<skin::SidecarControl>();
  const Stage stage(confirmed.character, confirmed.hints, DrivenChain::spine, controls);
  const Stage again(confirmed.character, confirmed.hints, DrivenChain::spine, controls);
  const std::size_t cases = request.full ? 5000 : 500;
  std::vector<Property> all;
  const auto take = [&](std::vector<Property> some) {
    all.insert(all.end(), some.begin(), some.end());
    progress.step();
  };
  progress.start("properties", request.rigs.size() + 2);
  for (const RigPlan& rig : request.rigs) {
    poll_interrupt();
    take(solver_properties(stage, again, rig, cases));
  }
  // Skin and pictures do not care which rig moved the body; one of ours never stops answering.
  const auto ours =
      std::ranges::find_if(request.rigs, [](const RigPlan& rig) { return !is_external(rig.spec); });
  const RigPlan rig = ours != request.rigs.end() ? *ours : read_rig("even");
  poll_interrupt();
  take(skin_properties(stage, rig, request.full ? 40 : 4));
  poll_interrupt();
  take(render_properties(stage, rig));
  progress.finish();
  return all;
}

}  // namespace backbend::validate
