#include "tests/source_folder.h"

namespace backbend {

std::filesystem::path source_folder() { return BACKBEND_SOURCE_DIR; }

}  // namespace backbend
