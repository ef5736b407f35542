#pragma once
#include <map>
#include <string>

namespace backbend::render {

/// What the libraries that this process has loaded say of their versions: `embree`, `openimageio`.
std::map<std::string, std::string> library_versions();

}  // namespace backbend::render
