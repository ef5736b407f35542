#include "cli/trouble.h"

#include <CLI/CLI.hpp>
#include <csignal>
#include <exception>

#include "render/trace/scene.h"
#include "skin/character/character.h"
#include "solver/rig/spine_system.h"
#include "validate/calibrate/calibrate.h"
#include "validate/files/ledger.h"
#include "validate/files/output_folder.h"
#include "validate/history/baseline.h"
#include "validate/history/history.h"
#include "validate/model/report_json.h"
#include "validate/prove/proof_box.h"
#include "validate/sweeps/suite.h"
#include "validate/tasks/progress.h"

namespace backbend::cli {

using namespace backbend::validate;

Trouble trouble_of_exception() {
  try {
    throw;
  } catch (const Interrupted& stop) {
    return {stop.what(), stop.signal_number == SIGTERM ? kExitTerminated : kExitInterrupted};
  } catch (const WriteError& error) {
    return {error.what(), error.temporary() ? kExitTemporary : kExitCannotWrite};
  } catch (const CLI::Error& error) {
    return {error.what(), kExitUsage};
  } catch (const ReadError& error) {
    return {error.what(), kExitBadInput};
  } catch (const solver::RigError& error) {
    return {error.what(), kExitBadInput};
  } catch (const skin::CharacterError& error) {
    return {error.what(), kExitBadInput};
  } catch (const render::RenderError& error) {
    return {error.what(), kExitBadInput};
  } catch (const ReportError& error) {
    return {error.what(), kExitBadInput};
  } catch (const HistoryError& error) {
    return {error.what(), kExitBadInput};
  } catch (const CalibrationError& error) {
    return {error.what(), kExitBadInput};
  } catch (const BaselineError& error) {
    return {error.what(), kExitBadInput};
  } catch (const NoBaseline& error) {
    return {error.what(), kExitNoBaseline};
  } catch (const ProofError& error) {
    return {error.what(), kExitBadInput};
  } catch (const SuiteError& error) {
    return {error.what(), kExitBadInput};
  } catch (const MixedPartsError& error) {
    return {error.what(), kExitBadInput};
  } catch (const IncompleteError& error) {
    return {error.what(), kExitIncomplete};
  } catch (const BusyError& error) {
    return {error.what(), kExitTemporary};
  } catch (const std::bad_alloc&) {
    return {"out of memory", kExitTemporary};
  } catch (const std::exception& error) {
    return {std::string("internal error: ") + error.what(), kExitInternal};
  }
}

}  // namespace backbend::cli
