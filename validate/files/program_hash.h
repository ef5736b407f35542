#pragma once
#include <string>

namespace backbend::validate {

/// What this very program is: the content of its file and of those that it starts or loads from
/// libexec/backbend, as one hash. Read once a process. Throws ReadError where its file cannot be
/// read; what is missing in libexec counts as empty.
const std::string& program_hash();

}  // namespace backbend::validate
