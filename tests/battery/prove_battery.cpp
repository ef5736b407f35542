// Random poses of the plain solver against certificates of `backbend prove -o FILE`: whether any
// pose of a certified box turns a joint faster than the certificate says.
//
//   prove_battery [options]
//
// --certificate FILE  one of any number
// --poses N           of each certificate, pairs that differ in one channel [1000000]
// --seed S            [1]
//
// Each pair lies in one certified box, 1e-6 to 1e-2 radians apart. Exit code 1 where one turns a
// joint by more than the gain that was proved allows, 2 for a certificate that cannot be read.
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <mutex>
#include <random>

#include "solver/math/rotation.h"
#include "solver/rig/crowd.h"
#include "tests/battery/battery_options.h"
#include "validate/prove/certificate.h"

namespace backbend::battery {
namespace {

using namespace validate;

/// The box of the tree that holds a pose, and whether it is certified.
bool certified_box(const Certificate& proof, const std::array<double, kProofAxes>& pose,
                   SubBox& box) {
  const ProofTree& tree = proof.tree;
  box = whole_of(proof.question.box);
  std::size_t at = 0;
  while (tree.node[at].state == BoxState::split) {
    const ProofNode& node = tree.node[at];
    const auto half = halves(box, node.axis);
    const auto axis = static_cast<std::size_t>(node.axis);
    const std::size_t side = pose[axis] < half[0].high[axis] ? 0 : 1;
    box = half[side];
    at = node.first + side;
  }
  return tree.node[at].state == BoxState::certified;
}

struct Outcome {
  std::uint64_t pairs = 0;
  double nearest = 0.0;  // the largest gain over the proved one
  std::string broken;    // a pose that turns faster
};

class Tries {
 public:
  static constexpr std::size_t kBlock = 512;  // pairs

  explicit Tries(const Certificate& proof)
      : proof_(proof),
        system_(solver::build_system(proof.question.rig, proof.question.chain)),
        controls_(proof.question.box, *system_, proof.question.mapping) {}

  Outcome block(std::uint64_t seed, std::uint64_t number) const {
    std::seed_seq words{seed, seed >> 32, number, number >> 32};
    std::mt19937_64 random(words);
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    const ProofBox& whole = proof_.question.box;
    struct Pair {
      std::array<double, kProofAxes> pose;
      std::size_t axis;
      double apart;  // radians
    };
    std::vector<Pair> pair;
    const std::size_t channels = system_->channels().size();
    std::vector<double> value(channels * 2 * kBlock);
    while (pair.size() < kBlock) {
      Pair next{};
      for (std::size_t j = 0; j < whole.axis.size(); ++j)
        next.pose[j] = whole.axis[j].low + uniform(random) * whole.axis[j].width();
      do next.axis = random() % whole.axis.size();
      while (!whole.axis[next.axis].varies());
      SubBox box;
      if (!certified_box(proof_, next.pose, box)) continue;
      next.apart = std::pow(10.0, -6.0 + 4.0 * uniform(random));
      std::array<double, kProofAxes> other = next.pose;
      const double degrees = solver::degrees(next.apart);
      const bool up = other[next.axis] + degrees <= box.high[next.axis];
      other[next.axis] += up ? degrees : -degrees;
      if (other[next.axis] < box.low[next.axis]) continue;
      const std::vector<double> first = controls_.at(next.pose), second = controls_.at(other);
      for (std::size_t c = 0; c < channels; ++c) {
        value[c * 2 * kBlock + 2 * pair.size()] = first[c];
        value[c * 2 * kBlock + 2 * pair.size() + 1] = second[c];
      }
      pair.push_back(next);
    }
    solver::CrowdPose posed;
    solver::solve_crowd(*system_, {value, 2 * kBlock}, posed);
    Outcome out;
    out.pairs = kBlock;
    for (std::size_t i = 0; i < kBlock; ++i) {
      double most = 0.0;
      for (std::size_t joint = 0; joint < posed.joint_count(); ++joint) {
        double less = 0.0, more = 0.0;
        for (std::size_t part = 0; part < 4; ++part) {
          const auto turn = posed.turn(joint, part);
          const double a = turn[2 * i], b = turn[2 * i + 1];
          less += (a - b) * (a - b);
          more += (a + b) * (a + b);
        }
        most = std::max(most, 4.0 * std::asin(0.5 * std::sqrt(std::min(less, more))));
      }
      // A proof does not cover the solver's rounding, 1e-12.
      const double gain = std::max(0.0, most - 1e-11) / pair[i].apart;
      const double ratio = gain / proof_.tree.gain_bound;
      out.nearest = std::max(out.nearest, ratio);
      if (ratio > 1.0 + 1e-6 && out.broken.empty()) {
        char text[64];
        std::snprintf(text, sizeof text, ": gain %.9g along ", gain);
        out.broken = pose_text(whole, pair[i].pose) + text + whole.axis[pair[i].axis].channel;
      }
    }
    return out;
  }

 private:
  const Certificate& proof_;
  std::unique_ptr<solver::SpineSystem> system_;
  PoseOfBox controls_;
};

int run(int argc, char** argv) {
  std::vector<std::string> files;
  std::uint64_t poses = 1000000;
  const BatteryOptions options = read_battery_options(
      "prove_battery", argc, argv, [&](const std::string& word, const std::string& value) {
        if (word == "--certificate") {
          files.push_back(value);
        } else if (word == "--poses") {
          poses = number_of(value);
        } else {
          return false;
        }
        return true;
      });
  if (files.empty()) options.usage("no --certificate");
  std::uint64_t all = 0;
  bool broken = false;
  for (const std::string& file : files) {
    const Certificate proof = read_certificate(file);
    const auto& axes = proof.question.box.axis;
    if (proof.question.box.of_controls ||
        std::none_of(axes.begin(), axes.end(), [](const ProofAxis& a) { return a.varies(); }))
      options.usage(file + ": its box is not of body channels, or one pose");
    if (shares_of(proof.tree, proof.question.box).certified <= 0.0)
      options.usage(file + ": nothing is certified");
    const Tries tries(proof);
    const std::uint64_t blocks = (poses + Tries::kBlock - 1) / Tries::kBlock;
    Outcome sum;
    std::mutex adding;
    const auto start = std::chrono::steady_clock::now();
    oneapi::tbb::parallel_for(std::uint64_t(0), blocks, [&](std::uint64_t i) {
      const Outcome own = tries.block(options.seed, i);
      const std::lock_guard lock(adding);
      sum.pairs += own.pairs;
      sum.nearest = std::max(sum.nearest, own.nearest);
      sum.broken = std::max(sum.broken, own.broken);  // the same for any order of blocks
    });
    const double seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    std::printf("%s: %llu pairs, at most %.4f of the proved gain %.4f, %.0f s%s%s\n", file.c_str(),
                static_cast<unsigned long long>(sum.pairs), sum.nearest, proof.tree.gain_bound,
                seconds, sum.broken.empty() ? "" : "; BROKEN at ", sum.broken.c_str());
    std::fflush(stdout);
    all += sum.pairs;
    broken = broken || !sum.broken.empty();
  }
  std::printf("%llu pairs in all, %s\n", static_cast<unsigned long long>(all),
              broken ? "a certified box is refuted" : "no certified box is refuted");
  return broken ? 1 : 0;
}

}  // namespace
}  // namespace backbend::battery

int main(int argc, char** argv) {
  try {
    return backbend::battery::run(argc, argv);
  } catch (const std::exception& error) {  // a certificate that cannot be read
    std::fprintf(stderr, "prove_battery: %s\n", error.what());
    return 2;
  }
}
