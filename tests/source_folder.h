#pragma once
#include <filesystem>

namespace backbend {

/// The folder of the source tree under test.
std::filesystem::path source_folder();

}  // namespace backbend
