#pragma once

namespace backbend::validate {

/// Asks all work to stop without a signal, in a process whose signals are another's: it ends with
/// Interrupted (progress.h), in every thread, until the note is taken back with 0.
void note_interrupt(int signal_number);

}  // namespace backbend::validate
