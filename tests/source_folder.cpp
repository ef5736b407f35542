#include "tests/source_folder.h"

#include <cstdlib>

namespace backbend {

std::filesystem::path source_folder() { return BACKBEND_SOURCE_DIR; }

std::filesystem::path characters_folder() {
  const char* given = std::getenv("BACKBEND_CHARACTERS");
  return given != nullptr ? std::filesystem::path(given)
                          : source_folder() / ".." / "shared" / "characters";
}

}  // namespace backbend
