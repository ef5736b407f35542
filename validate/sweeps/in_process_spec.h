#pragma once
#include <string_view>

namespace backbend::validate {

/// The program, as ExternalSpec has it, of a rig that this process evaluates itself: one written in
/// Python. Its file is the rig's name with a number.
inline constexpr std::string_view kInProcess = "python";
/// What stands between such a rig's name and its number, which nobody is shown.
inline constexpr char kInProcessNumber = '#';

}  // namespace backbend::validate
