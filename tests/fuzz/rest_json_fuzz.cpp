#include "solver/rig/solve_file.h"
#include "tests/fuzz/target.h"

namespace backbend::fuzz {
namespace {

constexpr std::string_view kNeck =
    "[rig]\nsystem = \"neck\"\n[chain]\nrest = \"rest.json\"\n[pose]\nbase_z = 40\ntop_y = 10\n";

bool run(Input input) {
  const std::filesystem::path folder = as_file(input, "rest.json").parent_path();
  try {
    solver::solve_to_json(solver::parse_solve_file(kNeck, "neck.toml", folder));
    return true;
  } catch (const solver::RigError& error) {
    return refused(error);
  }
}

std::vector<Bytes> seeds() { return {bytes_of(source_text("tests/accept/mSaurus_neck.json"))}; }

const Registration registration{
    {"rest_json",
     run,
     seeds,
     {"\"vertebrae\"", "\"name\"", "\"row1_x_axis\"", "\"row2_y_axis\"", "\"row3_z_axis\"",
      "\"row4_position\"", "1e308", "-1e999", "null"},
     8192}};

}  // namespace
}  // namespace backbend::fuzz
