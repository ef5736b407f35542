#include "tests/fuzz/target.h"
#include "validate/sweeps/suite.h"

namespace backbend::fuzz {
namespace {

/// Every rig is built on a straight spine and posed at the end of a sweep, each of another one.
bool run(Input input) {
  try {
    const validate::Suite suite = validate::read_suite(as_file(input, "suite.toml"));
    require(!suite.rigs.empty() && !suite.sweeps.empty(), "a suite has rigs and sweeps");
    solver::RestChain chain;
    for (int j = 0; j < 5; ++j) chain.joint.emplace_back(0.0, 0.1 * j, 0.0);
    validate::limits_for(suite.rules, "hero");
    std::size_t next = 0;
    for (const validate::RigPlan& rig : suite.rigs) {
      validate::rig_text(rig.spec);
      try {
        const auto system = solver::build_system(rig.spec, chain);
        const validate::Sweep& sweep = suite.sweeps[next++ % suite.sweeps.size()];
        require(sweep.pose_count() >= 1, "a sweep has poses");
        const auto last = sweep.pose_at(sweep.control_at(sweep.pose_count() - 1));
        system->solve(system->controls_for(last.radians(), solver::Mapping::spread));
      } catch (const solver::RigError& error) {
        refused(error);
      }
    }
    return true;
  } catch (const validate::SuiteError& error) {
    return refused(error);
  }
}

std::vector<Bytes> seeds() {
  return {bytes_of(source_text("scenes/nightly.toml")),
          bytes_of("[suite]\nname = \"s\"\ntitle = \"T\"\nenvelope = \"human\"\ncharacters = "
                   "[\"hero.glb\"]\nmappings = [\"chest\"]\n[[rig]]\nsolver = {system = "
                   "\"curve\", bones = 12}\n[[sweep]]\nchannel = \"extension\"\nto = 90\nstep = "
                   "10\n[[limit]]\ncode = \"BB020\"\nvalue = 1.5\nlayer = \"show\"\nowner = "
                   "\"rigging\"\nreason = \"hands\"\n[[waiver]]\ncode = \"BB030\"\ncharacter = "
                   "\"hero\"\nowner = \"ann\"\nreason = \"belt\"\nexpires = "
                   "\"2026-12-15\"\n[pictures]\nsamples = 4\n")};
}

const Registration registration{
    {"suite_toml",
     run,
     seeds,
     {"[suite]",       "name",        "title",         "envelope",   "human",
      "sweep",         "characters",  "mappings",      "chest",      "spread",
      "[[rig]]",       "solver",      "system",        "role",       "proposed",
      "reference",     "canary",      "duty",          "twin",       "code",
      "BB001",         "control_deg", "tolerance_deg", "[[sweep]]",  "channel",
      "from",          "to",          "step",          "with",       "path",
      "[[limit]]",     "value",       "layer",         "studio",     "show",
      "owner",         "reason",      "[[waiver]]",    "expires",    "from_deg",
      "to_deg",        "worst",       "joint",         "[pictures]", "turntable_views",
      "sheet_columns", "samples",     "width",         "height",     "three_bone",
      "isner",         "even",        "curve",         "stretchy",   "neck",
      "snake",         "spline_ik",   "matrix_blend",  "inf",        "nan",
      "1e308",         "2026-02-30"}}};

}  // namespace
}  // namespace backbend::fuzz
