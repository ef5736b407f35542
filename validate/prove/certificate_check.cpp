#include "validate/prove/certificate_check.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "validate/prove/claim_checker.h"
#include "validate/prove/refute.h"

namespace backbend::validate {
namespace {

/// The plain solver's figure at a refuted pose may differ from the certificate's by rounding.
constexpr double kSameFigure = 1e-3;
/// A box that the checker cannot bound at once is cut: its evaluation is wider than the search's.
constexpr int kDeepest = 12;

double bound_of(const ClaimChecker& checker, const SubBox& box, double asked, int depth) {
  const double bound = checker.gain_over(box);
  if (bound <= asked || depth == kDeepest) return bound;
  const int axis = widest_axis(box, 0.0, checker.idle());
  if (axis < 0) return bound;
  double most = 0.0;
  for (const SubBox& half : halves(box, axis)) {
    most = std::max(most, bound_of(checker, half, asked, depth + 1));
    if (!(most <= asked)) return most;
  }
  return most;
}

std::string part_text(const ProofBox& whole, const SubBox& part) {
  std::string text;
  for (std::size_t j = 0; j < whole.axis.size(); ++j) {
    text += (text.empty() ? "" : ", ") + whole.axis[j].channel + " " + number_text(part.low[j], 4) +
            ".." + number_text(part.high[j], 4);
  }
  return text;
}

}  // namespace

CertificateCheck check_certificate(const Certificate& certificate, const std::string& name,
                                   Progress& progress) {
  const ProofQuestion& q = certificate.question;
  const auto refuse = [&](const std::string& why) { throw ProofError(name + ": " + why); };
  if (!certificate.tree.is_complete()) {
    refuse("the search was interrupted; finish it with --resume");
  }
  const auto system = solver::build_system(q.rig, q.chain);
  if (q.box.of_controls) {
    for (const ProofAxis& a : q.box.axis) {
      const auto& channels = system->channels();
      if (std::none_of(channels.begin(), channels.end(),
                       [&](const solver::Channel& c) { return c.name == a.channel; })) {
        refuse("the rig has no control '" + a.channel + "'");
      }
    }
  } else if (q.box.axis.size() != 3 || q.box.axis[0].channel != "extension" ||
             q.box.axis[1].channel != "side" || q.box.axis[2].channel != "twist") {
    refuse("the box is not of extension, side and twist");
  }
  const auto checker = claim_checker(q, *system);
  const Refuter plain(q, *system);

  // The tree was read as one whose boxes fill the whole; what is left are the leaves' claims.
  struct Leaf {
    SubBox box;
    ProofNode node;
  };
  std::vector<Leaf> leaf;
  each_leaf(certificate.tree, q.box, [&](const SubBox& box, const ProofNode& node) {
    leaf.push_back({box, node});
  });
  CertificateCheck check;
  const double asked = std::min(q.gain, certificate.tree.gain_bound * (1.0 + 1e-12));
  std::vector<double> bound(leaf.size(), 0.0);
  progress.start("boxes", leaf.size());
  constexpr std::size_t kChunk = 128;
  for (std::size_t first = 0; first < leaf.size(); first += kChunk) {
    const std::size_t last = std::min(first + kChunk, leaf.size());
    oneapi::tbb::parallel_for(first, last, [&](std::size_t i) {
      poll_interrupt();  // a box may take seconds
      const Leaf& own = leaf[i];
      const BoxState state = own.node.state;
      if (state == BoxState::certified) bound[i] = bound_of(*checker, own.box, asked, 0);
      if (state == BoxState::refuted || state == BoxState::steep) {
        bound[i] = plain.measure(certificate.tree.refutation[own.node.refutation]);
      }
    });
    for (std::size_t i = first; i < last; ++i) {
      const Leaf& own = leaf[i];
      const std::string where = part_text(q.box, own.box);
      switch (own.node.state) {
        case BoxState::certified:
          ++check.certified;
          check.gain_bound = std::max(check.gain_bound, bound[i]);
          if (!(bound[i] <= asked)) {
            refuse("claims a gain of at most " + number_text(asked) + " over " + where +
                   "; the check finds " + number_text(bound[i], 6));
          }
          break;
        case BoxState::refuted:
        case BoxState::steep: {
          ++check.refuted;
          const Refutation& r = certificate.tree.refutation[own.node.refutation];
          for (std::size_t j = 0; j < q.box.axis.size(); ++j) {
            if (!(own.box.low[j] <= r.pose[j] && r.pose[j] <= own.box.high[j])) {
              refuse("the refuted pose " + pose_text(q.box, r.pose) + " is not in its box " +
                     where);
            }
          }
          const double least = r.check == "BB001" ? 1.0 : q.gain;
          const bool same = std::abs(bound[i] - r.value) <= kSameFigure * r.value;
          if (!(bound[i] >= least) || !same) {
            refuse("claims " + r.check + " " + number_text(r.value) + " at " +
                   pose_text(q.box, r.pose) + "; the plain solver gives " + number_text(bound[i]));
          }
          break;
        }
        default:
          ++check.open;
      }
    }
    progress.step(last - first);
  }
  progress.finish();
  return check;
}

}  // namespace backbend::validate
