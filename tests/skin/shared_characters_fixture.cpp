#include <cstdlib>

#include "tests/skin/shared_characters.h"

namespace backbend::skin {

std::filesystem::path shared_character(const std::string& file) {
  const char* given = std::getenv("BACKBEND_CHARACTERS");
  const std::filesystem::path folder =
      given ? std::filesystem::path(given)
            : std::filesystem::path(BACKBEND_SOURCE_DIR) / ".." / "shared" / "characters";
  return folder / file;
}

}  // namespace backbend::skin
