#pragma once
#include <string>

#include "validate/model/report.h"

namespace backbend::validate {

/// The report as JUnit XML (the dialect Jenkins, GitLab and junitparser read), XML 1.0, UTF-8.
///
/// One suite per character, rig and mapping with a case per planned check, one suite `canaries`,
/// and one suite `run` whose single case is the verdict. What fails here is what the exit code
/// stands for, and nothing else: `<failure>` for a proposed rig over a limit, `<error>` for what
/// was not measured or for a run that ended for another reason, `<skipped>` for what is shown and
/// does not decide (reference rigs, canaries' own findings, beyond the envelope, waived, not
/// applicable).
std::string junit_xml(const Report& report);

}  // namespace backbend::validate
