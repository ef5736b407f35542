#pragma once
#include <stdexcept>

namespace backbend::validate {

/// What is being made is out of date, for its inputs have changed; thrown from poll_interrupt().
struct Superseded : std::runtime_error {
  Superseded() : std::runtime_error("an input has changed") {}
};

/// From then on poll_interrupt() throws Superseded, in every thread, until this is taken back.
void set_superseded(bool superseded);

/// Whether poll_interrupt() would throw.
bool stop_pending();

}  // namespace backbend::validate
