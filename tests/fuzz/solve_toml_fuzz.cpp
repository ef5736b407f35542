#include <nlohmann/json.hpp>

#include "solver/rig/solve_file.h"
#include "tests/fuzz/target.h"

namespace backbend::fuzz {
namespace {

bool run(Input input) {
  // The neck of the accepted cases, for files that name it.
  static const std::filesystem::path folder =
      as_file(bytes_of(source_text("tests/accept/mSaurus_neck.json")), "mSaurus_neck.json")
          .parent_path();
  try {
    const solver::SolveFile file = solver::parse_solve_file(text_of(input), "input.toml", folder);
    require(file.control.size() == file.system->channels().size(), "a value for every channel");
    const solver::SpinePose pose = file.system->solve(file.control);
    require(pose.joint_count() == file.system->joint_names().size(), "a name for every joint");
    solver::solve_to_json(file);
    solver::solve_to_text(file);
    if (!file.key.empty()) file.system->solve(file.control_at(file.key.front().time + 0.5));
    return true;
  } catch (const solver::RigError& error) {
    return refused(error);
  }
}

/// One accepted case of every system, and one with keys.
std::vector<Bytes> seeds() {
  std::vector<Bytes> out;
  std::string last;
  const nlohmann::json cases = nlohmann::json::parse(source_text("tests/accept/solver_cases.json"));
  for (const auto& each : cases.at("cases")) {
    const auto name = each.at("name").get<std::string>();
    const std::string system = name.substr(0, name.find('/'));
    if (system == last) continue;
    last = system;
    out.push_back(bytes_of(each.at("toml").get<std::string>()));
  }
  out.push_back(bytes_of(
      "[rig]\nsystem = \"even\"\nbones = 4\nreach = 0.5\n[chain]\njoints = [[0,0,0],[0,1,0],[0,2,"
      "0]]\n[pose]\ntop = [0, 0, -40]\n[[key]]\ntime = 0\npose = {top.rz = 5}\n[[key]]\ntime = 2\n"
      "pose = {top = [1, 2, 3]}\n"));
  out.push_back(bytes_of(
      "[rig]\nsystem = \"curve\"\ndrawing = \"live\"\n[chain]\njoints = [[0,0,0],[0,1,0],[0,2,0]]\n"
      "[redrawn]\njoints = [[0,0,0],[0,1,0.1],[0,3,0]]\n[[control]]\nname = \"bend\"\nrest = [1, "
      "2]\n"
      "[[element]]\nname = \"e\"\ninputs = [\"bend\"]\nweights = [[0.5, 1]]\ndrives = "
      "[\"top.rz\"]\n"
      "[pose]\nbend = [3, 4]\n"));
  return out;
}

const Registration registration{{"solve_toml",
                                 run,
                                 seeds,
                                 {"[rig]",
                                  "system",
                                  "[chain]",
                                  "joints",
                                  "left",
                                  "curve",
                                  "rest",
                                  "[path]",
                                  "points",
                                  "up",
                                  "[pose]",
                                  "[[key]]",
                                  "time",
                                  "pose",
                                  "bones",
                                  "basis",
                                  "follow",
                                  "length",
                                  "roll",
                                  "arms",
                                  "bspline",
                                  "interpolate",
                                  "linear",
                                  "chase",
                                  "on_curve",
                                  "nulls",
                                  "null_sum",
                                  "arc",
                                  "close",
                                  "three_bone",
                                  "isner",
                                  "even",
                                  "stretchy",
                                  "neck",
                                  "snake",
                                  "spline_ik",
                                  "matrix_blend",
                                  "vertebrae",
                                  "placement",
                                  "depth",
                                  "aim",
                                  "slerp",
                                  "stretchiness",
                                  "lead",
                                  "compression",
                                  "slide",
                                  "carve",
                                  "max_ratio",
                                  "weights",
                                  "twist",
                                  "reach",
                                  "limits",
                                  "gains",
                                  "blend",
                                  "controls",
                                  "lower",
                                  "middle",
                                  "top",
                                  "hip",
                                  "chest",
                                  "hip_move",
                                  "chest_move",
                                  "inf",
                                  "nan",
                                  "1e308",
                                  "-0.0",
                                  "9223372036854775807"}}};

}  // namespace
}  // namespace backbend::fuzz
