#pragma once
#include <filesystem>

namespace backbend {

/// The folder of the source tree under test.
std::filesystem::path source_folder();

/// Where the real characters are: BACKBEND_CHARACTERS, else beside the source tree.
std::filesystem::path characters_folder();

}  // namespace backbend
