#pragma once
#include <functional>
#include <string>

#include "validate/prove/proof_box.h"

namespace backbend::validate::testing {

/// What a call refuses with a ProofError; empty: it does not.
inline std::string refusal(const std::function<void()>& call) {
  try {
    call();
  } catch (const ProofError& error) {
    return error.what();
  }
  return "";
}

}  // namespace backbend::validate::testing
