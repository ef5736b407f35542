#include <cstdlib>

#include "tests/skin/shared_characters.h"
#include "tests/source_folder.h"

namespace backbend::skin {

std::filesystem::path shared_character(const std::string& file) {
  const char* given = std::getenv("BACKBEND_CHARACTERS");
  const std::filesystem::path folder =
      given ? std::filesystem::path(given) : source_folder() / ".." / "shared" / "characters";
  return folder / file;
}

}  // namespace backbend::skin
