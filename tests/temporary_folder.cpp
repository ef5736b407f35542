#include "tests/temporary_folder.h"

#include <stdlib.h>

#include <stdexcept>
#include <string>

namespace backbend {

TemporaryFolder::TemporaryFolder() {
  const std::filesystem::path place =
      std::filesystem::canonical(std::filesystem::temp_directory_path());
  std::string pattern = (place / "backbend test XXXXXX").string();
  if (!::mkdtemp(pattern.data())) throw std::runtime_error("no temporary folder");
  path_ = pattern;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

}  // namespace backbend
