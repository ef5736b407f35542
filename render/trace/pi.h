#pragma once
#include <numbers>

namespace backbend::render {

inline constexpr float kPi = std::numbers::pi_v<float>;

}  // namespace backbend::render
