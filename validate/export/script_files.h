#pragma once
#include <string_view>

namespace backbend::validate::scripts {

/// The Python files of validate/export, compiled into the program by embed.cmake byte for byte.
std::string_view blender_even();
std::string_view maya_even();

}  // namespace backbend::validate::scripts
