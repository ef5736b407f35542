#pragma once
#include <filesystem>

namespace backbend::validate {

/// Throws WriteError where a file that exists must not be replaced: it is marked read-only, as a
/// version control server leaves what is not checked out, or a folder. Before any work is done.
void require_replaceable(const std::filesystem::path& file);

}  // namespace backbend::validate
