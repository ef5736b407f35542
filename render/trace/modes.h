#pragma once
#include <map>
#include <string>

#include "render/trace/scene.h"

namespace backbend::render {

/// How a picture is shaded, by the names that users type: `clay`, `heat`.
const std::map<std::string, Mode>& modes();

}  // namespace backbend::render
