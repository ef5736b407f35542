#pragma once
#include <vector>

#include "skin/anatomy/anatomy.h"

namespace backbend::skin {

/// Of each vertex whether another figure's joint moves it most.
std::vector<bool> vertices_of_other_figures(const Character& character, const Anatomy& anatomy);

}  // namespace backbend::skin
