#pragma once
#include <vector>

#include "skin/character/character.h"

namespace tinygltf {
class Model;
}

namespace backbend::skin {

/// The file's materials with a default one behind them. Pictures are numbered as in the file; a
/// reference that leads nowhere is -1.
std::vector<Material> read_materials(const tinygltf::Model& model, std::size_t image_count);

}  // namespace backbend::skin
