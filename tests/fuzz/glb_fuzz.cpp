#include "tests/fuzz/gltf_use.h"

namespace backbend::fuzz {
namespace {

bool run(Input input) { return use_gltf({input.begin(), input.end()}); }

const Registration registration{{"glb", run, glb_seeds, gltf_words(), 16384}};

}  // namespace
}  // namespace backbend::fuzz
