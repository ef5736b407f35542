#include "validate/selftest/selftest.h"

#include <cmath>
#include <limits>

#include "validate/selftest/properties.h"

namespace backbend::validate {

double Property::margin() const {
  if (!(worst > 0.0)) return std::isnan(worst) ? 0.0 : std::numeric_limits<double>::infinity();
  return bound / worst;
}

std::vector<Property> selftest(const SelftestRequest& request, Progress& progress) {
  const Stage stage(load_character(request.character), request.hints);
  const std::size_t cases = request.full ? 5000 : 500;
  std::vector<Property> all;
  const auto take = [&](std::vector<Property> some) {
    all.insert(all.end(), some.begin(), some.end());
    progress.step();
  };
  progress.start("properties", request.rigs.size() + 2);
  for (const RigPlan& rig : request.rigs) {
    poll_interrupt();
    take(solver_properties(stage, rig, cases));
  }
  // Skin and pictures do not care which rig moved the body.
  poll_interrupt();
  take(skin_properties(stage, request.rigs.front(), request.full ? 40 : 4));
  poll_interrupt();
  take(render_properties(stage, request.rigs.front()));
  progress.finish();
  return all;
}

}  // namespace backbend::validate
