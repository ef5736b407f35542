#include "validate/measure/known_jumps.h"

#include <gtest/gtest.h>

#include <glm/gtc/quaternion.hpp>
#include <numeric>

#include "tests/validate/spoiled_rig.h"
#include "validate/calibrate/calibration_body.h"
#include "validate/measure/records.h"

namespace backbend::validate {
namespace {

RigRecord rig_of(const Stage& stage, const std::string& text, solver::Mapping mapping) {
  RigRecord rig;
  rig.plan = read_rig(text);
  rig.mapping = mapping;
  rig.system = stage.build(rig.plan.spec);
  return rig;
}

/// Whatever was asked before, an answer is that of a search made now: of other options, mappings,
/// paths and joints at rest, too.
TEST(KnownJumps, AreThoseOfThisRigOnThisPathOfThisChain) {
  const auto eight = tube_body(8), twelve = tube_body(12);
  const Sweep paths[] = {channel_sweep("extension", 0, 120, 10),
                         channel_sweep("extension", 0, 90, 10), channel_sweep("side", 0, 120, 10)};
  KnownJumps known;
  for (int time = 0; time < 3; ++time) {
    for (const CalibrationBody* body : {eight.get(), twelve.get()}) {
      for (const char* text : {"isner", "isner:length=stretchy", "curve"}) {
        for (const solver::Mapping mapping : {solver::Mapping::chest, solver::Mapping::spread}) {
          const RigRecord rig = rig_of(body->stage(), text, mapping);
          for (const Sweep& path : paths)
            EXPECT_EQ(pack_flips(known.flips(body->stage(), rig, path)),
                      pack_flips(search_flips(rig, path)))
                << text << " " << path.channel << " " << path.to_deg << ", time " << time;
        }
      }
    }
    known.forget_unused();
  }
}

TEST(KnownJumps, AreNotLookedForAgainUntilNobodyAskedForThemInARun) {
  const auto body = tube_body(8);
  const Stage& stage = body->stage();
  const RigPlan plan = read_rig("even");
  // Told apart by what a search finds: the one jumps, the other does not.
  const Spoiled jumps(
      stage.build(plan.spec), [](std::span<const double> c, solver::SpinePose& pose) {
        if (std::accumulate(c.begin(), c.end(), 0.0) > 0.2)
          pose.turn[3] = pose.turn[3] * glm::angleAxis(1.5, glm::dvec3(0.0, 1.0, 0.0));
      });
  const auto smooth = stage.build(plan.spec);
  const Envelope box = *find_envelope("human");
  KnownJumps known;
  Progress progress(Progress::Style::none);
  const auto found = [&](const solver::SpineSystem& system) {
    return known.compound(stage, plan, system, solver::Mapping::chest, box, progress)
        .summary.with_jumps;
  };
  const int of_jumps = found(jumps);
  ASSERT_GT(of_jumps, 0);
  EXPECT_EQ(found(*smooth), of_jumps);
  known.forget_unused();
  EXPECT_EQ(found(*smooth), of_jumps);  // it was asked for in the run before
  known.forget_unused();
  known.forget_unused();  // a run without it
  EXPECT_EQ(found(*smooth), 0);
}

}  // namespace
}  // namespace backbend::validate
