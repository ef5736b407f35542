#pragma once
#include <cstdint>

#include "validate/prove/certificate.h"

namespace backbend::validate {

/// What a check of a certificate went through.
struct CertificateCheck {
  std::uint64_t certified = 0, refuted = 0, open = 0;  // boxes
  double gain_bound = 0.0;  // the checker's own, over the certified boxes
};

/// Checks a certificate anew: that its boxes fill the whole, that every certified box turns no
/// joint faster than claimed, by an evaluation of its own (claim_checker.h), and that every refuted
/// box holds its pose and the plain solver breaks the claim there. Throws ProofError naming the
/// first thing that does not hold, a system that has no checker, and a certificate that is not
/// finished; Interrupted.
CertificateCheck check_certificate(const Certificate& certificate, const std::string& name,
                                   Progress& progress);

}  // namespace backbend::validate
