#pragma once
#include <cstddef>

namespace backbend::skin {

/// A vertex number as an index: meshes count in int, as -1 is used for none.
inline std::size_t z(int i) { return static_cast<std::size_t>(i); }

}  // namespace backbend::skin
