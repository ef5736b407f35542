#include "tests/skin/shared_characters.h"
#include "tests/source_folder.h"

namespace backbend::skin {

std::filesystem::path shared_character(const std::string& file) {
  return characters_folder() / file;
}

}  // namespace backbend::skin
