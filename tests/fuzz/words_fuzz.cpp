// What is typed at a prompt: poses, ranges, sweeps, shares, rigs with options. One word each, told
// apart by the first byte.
#include <stdexcept>

#include "solver/rig/solve_file.h"
#include "tests/fuzz/target.h"
#include "validate/camera/frame_choice.h"
#include "validate/files/ledger.h"
#include "validate/sweeps/suite.h"

namespace backbend::fuzz {
namespace {

solver::RestChain straight() {
  solver::RestChain chain;
  for (int j = 0; j < 5; ++j) chain.joint.emplace_back(0.0, 0.1 * j, 0.0);
  return chain;
}

void use(char kind, const std::string& word) {
  static const auto even = solver::build_system({"even", {}}, straight());
  if (kind == 'p') {
    even->solve(even->controls_for(validate::parse_pose(word).radians(), solver::Mapping::chest));
  } else if (kind == 'r') {
    require(!solver::parse_range(word, "time").empty(), "a range holds a value");
  } else if (kind == 's') {
    const solver::ControlSweep sweep = solver::parse_sweep(*even, word);
    std::vector<double> control(even->channels().size());
    require(sweep.channel < control.size(), "a sweep of a channel that is there");
    control[sweep.channel] = sweep.value.back();
    even->solve(control);
  } else if (kind == 'n') {
    const validate::Shard shard = validate::parse_shard(word);
    require(shard.index >= 1 && shard.index <= shard.count, "a share of those there are");
  } else if (kind == 'f') {
    const auto frames = validate::chosen_frames(word, {}, 50);
    require(!frames.empty() && frames.back() < 50, "frames that the sequence has");
  } else if (!std::string_view(word).ends_with(".toml")) {  // that would be a file of this machine
    const validate::RigPlan plan = validate::read_rig(word);
    const auto system = solver::build_system(plan.spec, straight());
    const validate::RigPlan again = validate::read_rig(validate::rig_text(plan.spec));
    require(solver::build_system(again.spec, straight())->options() == system->options(),
            "a rig's text makes the same rig");
  }
}

bool run(Input input) {
  if (input.empty()) return false;
  try {
    use(static_cast<char>(input[0]), std::string(text_of(input.subspan(1))));
    return true;
  } catch (const solver::RigError& error) {
    return refused(error);
  } catch (const validate::SuiteError& error) {
    return refused(error);
  } catch (const std::invalid_argument& error) {  // parse_shard's, chosen_frames'
    return refused(error);
  }
}

std::vector<Bytes> seeds() {
  std::vector<Bytes> out;
  for (const std::string_view word :
       {"pextension=90,side=-10.5", "r0:-150:-5", "stop.rz=0:-150:-5", "n3/8", "f1001-1010x2,1020",
        "ccurve", "ccurve:length=rest,bones=12", "ceven:weights=[[0,0.8],[0.2,1]],reach=0.5"})
    out.push_back(bytes_of(word));
  return out;
}

const Registration registration{
    {"words",
     run,
     seeds,
     {"extension=", "flexion=",  "side=",  "twist=", "top.rz=", "middle.rx=", "curve:", "isner:",
      "even:",      "stretchy:", "snake",  "neck",   "bones=",  "length=",    "true",   "inf",
      "nan",        "1e308",     "1e-320", "auto",   "[[",      "]]",         "\""},
     256}};

}  // namespace
}  // namespace backbend::fuzz
