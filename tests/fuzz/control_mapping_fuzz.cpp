#include "tests/fuzz/target.h"
#include "validate/live/control_mapping.h"

namespace backbend::fuzz {
namespace {

bool run(Input input) {
  try {
    const validate::ControlMapping mapping =
        validate::parse_mapping(std::string(text_of(input)), "hero.map.json");
    for (const char* channel : {"extension", "flexion", "side", "twist"})
      for (const validate::ControlTarget& target : mapping.targets(channel))
        require(!target.channel.empty() && target.per_degree != 0.0, "a target moves something");
    return true;
  } catch (const solver::RigError& error) {
    return refused(error);
  }
}

std::vector<Bytes> seeds() {
  return {
      bytes_of("{\"armature\": \"rig\", \"channels\": {\"extension\": [{\"control\": "
               "\"chest\", \"channel\": \"rx\", \"per_degree\": -0.5}], \"twist\": "
               "[{\"channel\": \"twist\"}]}}")};
}

const Registration registration{
    {"control_mapping",
     run,
     seeds,
     {"\"channels\"", "\"extension\"", "\"flexion\"", "\"side\"", "\"twist\"", "\"control\"",
      "\"channel\"", "\"per_degree\"", "1e308", "-1e999", "null"}}};

}  // namespace
}  // namespace backbend::fuzz
