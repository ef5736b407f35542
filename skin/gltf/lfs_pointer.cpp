#include "skin/gltf/lfs_pointer.h"

#include <string>

namespace backbend::skin {
bool is_lfs_pointer(std::span<const std::uint8_t> bytes) {
  if (bytes.size() >= kMostLfsPointerBytes) return false;
  const std::string text(bytes.begin(), bytes.end());
  return text.starts_with("version http") && text.find("\noid ") != std::string::npos &&
         text.find("\nsize ") != std::string::npos;
}

}  // namespace backbend::skin
