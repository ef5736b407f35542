#pragma once
#include <filesystem>

namespace backbend::validate {

/// The folder with `scenes/` that belongs to this program: beside the sources it was built from,
/// or <prefix>/share/backbend once installed. Throws ReadError where neither is found.
std::filesystem::path data_folder();

}  // namespace backbend::validate
