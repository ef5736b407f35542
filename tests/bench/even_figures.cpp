// `even` beside the other systems: the figures of docs/even.md, as its table.
//
//   even_figures [random poses, 1000000 by default]
//
// Every system is built with ten bones on a straight spine of length 6 and posed by the same body
// poses (extension and flexion to 150 degrees, side to 90, twist to 180) under both mappings: a
// grid of 15 degrees, then random ones. Neck and snake are left out: no chest rides on them.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <glm/geometric.hpp>
#include <random>

#include "solver/math/rotation.h"
#include "solver/rig/chain_measures.h"
#include "solver/rig/spine_system.h"

namespace backbend::solver {
namespace {

using Options = std::map<std::string, OptionValue>;

struct Rig {
  const char* title;
  const char* system;
  Options options;
};

const Rig kRigs[] = {{"even", "even", {}},
                     {"even, reach 1", "even", {{"reach", 1.0}}},
                     {"three_bone", "three_bone", {}},
                     {"curve", "curve", {}},
                     {"isner", "isner", {{"vertebrae", 10.0}}},
                     {"stretchy", "stretchy", {{"bones", 10.0}}},
                     {"spline_ik", "spline_ik", {{"bones", 10.0}}},
                     {"matrix_blend", "matrix_blend", {{"bones", 10.0}}}};

constexpr double kLength = 6.0;

struct Figures {
  double gain = 0.0;          // most that a frame turns per turn of one channel
  long jumps = 0, steps = 0;  // steps with a gain above 10; of all
  double joint = 0.0;         // largest angle between two bones, radians
  double over_mean = 0.0;     // sum of the poses' max / mean
  double twist = 0.0, end = 0.0, drift = 0.0, tip = 0.0;  // largest
  double drift_sum = 0.0, tip_sum = 0.0;
  long poses = 0;
};

class Meter {
 public:
  Meter(const Rig& rig, Mapping mapping)
      : mapping_(mapping),
        system_(build_system({rig.system, rig.options}, kChain)),
        plain_(build_system({"three_bone", {}}, kChain)) {}

  /// `bend` > 0 bends forward. `channel` 0..2: which one is moved on for the gain; others: none.
  void add(double bend, double side, double twist, int channel) {
    system_->solve_into(controls(bend, side, twist), Detail::joints, pose_);
    const ChainBend chain = measure_chain(pose_.position);
    figures.joint = std::max(figures.joint, chain.max_turn);
    figures.over_mean += chain.mean_turn > 1e-9 ? chain.max_turn / chain.mean_turn : 1.0;
    const glm::dquat miss = glm::conjugate(pose_.chest.turn) * pose_.turn.back();
    const double off = std::abs(wrap(swing_twist(miss, kAxisY).twist_angle));
    figures.twist = std::max(figures.twist, off);
    figures.end = std::max(figures.end, angle_between(pose_.chest.turn, pose_.turn.back()));
    const double drift = angle_between(pose_.chest.turn, pose_.arms.turn);
    figures.drift = std::max(figures.drift, drift);
    figures.drift_sum += drift;
    plain_->solve_into(plain_->controls_for(body(bend, side, twist), mapping_), Detail::joints,
                       asked_);
    const double tip = glm::length(pose_.position.back() - asked_.position.back()) / kLength;
    figures.tip = std::max(figures.tip, tip);
    figures.tip_sum += tip;
    ++figures.poses;
    if (channel < 0 || channel > 2) return;
    constexpr double kStep = 1e-5;
    system_->solve_into(
        controls(bend + (channel == 0 ? kStep : 0.0), side + (channel == 1 ? kStep : 0.0),
                 twist + (channel == 2 ? kStep : 0.0)),
        Detail::joints, next_);
    double gain = 0.0;
    for (std::size_t j = 0; j < pose_.joint_count(); ++j) {
      gain = std::max(gain, angle_between(pose_.turn[j], next_.turn[j]) / kStep);
    }
    figures.gain = std::max(figures.gain, gain);
    figures.jumps += gain > 10.0;
    ++figures.steps;
  }

  Figures figures;

 private:
  static BodyPose body(double bend, double side, double twist) {
    return {.extension = 0.0, .flexion = bend, .side = side, .twist = twist};
  }
  std::vector<double> controls(double bend, double side, double twist) const {
    return system_->controls_for(body(bend, side, twist), mapping_);
  }

  inline static const RestChain kChain{.joint = {{0, 0, 0}, {0, 2, 0}, {0, 4, 0}, {0, 6, 0}}};
  Mapping mapping_;
  std::unique_ptr<SpineSystem> system_, plain_;
  SpinePose pose_, next_, asked_;
};

void print(const char* title, const Figures& f) {
  const double n = double(f.poses);
  // A jump's gain says only how short the step was.
  char gain[32];
  std::snprintf(gain, sizeof gain, f.jumps ? "jumps" : "%.4f", f.gain);
  std::printf("| %s | %s | %.3g %% | %.1f | %.2f | %.3g | %.3g | %.1f / %.1f | %.3g / %.3g |\n",
              title, gain, 100.0 * double(f.jumps) / double(f.steps), degrees(f.joint),
              f.over_mean / n, degrees(f.twist), degrees(f.end), 100.0 * f.tip,
              100.0 * f.tip_sum / n, degrees(f.drift), degrees(f.drift_sum / n));
}

void table(Mapping mapping, long poses) {
  std::printf(
      "| `%s` | gain | steps above 10 | joint, worst | max/mean, mean | twist error | end "
      "error | tip off, worst / mean | arm drift, worst / mean |\n"
      "|---|---|---|---|---|---|---|---|---|\n",
      mapping == Mapping::chest ? "chest" : "spread");
  for (const Rig& rig : kRigs) {
    Meter meter(rig, mapping);
    for (int bend = -150; bend <= 150; bend += 15) {
      for (int side = -90; side <= 90; side += 15) {
        for (int twist = -180; twist <= 180; twist += 15) {
          meter.add(radians(bend), radians(side), radians(twist), int(meter.figures.poses % 3));
        }
      }
    }
    std::mt19937 rng(1);
    const auto within = [&](double most) {
      return radians(most * (double(rng()) / 2147483648.0 - 1.0));
    };
    // A gain takes a second solve: measured on every fourth pose.
    for (long i = 0; i < poses; ++i) {
      const double bend = within(150.0), side = within(90.0), twist = within(180.0);
      meter.add(bend, side, twist, i % 4 == 0 ? int(i / 4 % 3) : -1);
    }
    print(rig.title, meter.figures);
    std::fflush(stdout);
  }
  std::printf("\n");
}

}  // namespace
}  // namespace backbend::solver

int main(int argc, char** argv) {
  using namespace backbend::solver;
  const long poses = argc > 1 ? std::strtol(argv[1], nullptr, 10) : 1'000'000;
  if (poses < 0 || argc > 2) {
    std::fprintf(stderr, "usage: even_figures [random poses]\n");
    return 2;
  }
  table(Mapping::chest, poses);
  table(Mapping::spread, poses);
}
