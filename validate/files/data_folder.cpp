#include "validate/files/data_folder.h"

#include "render/image/own_file.h"
#include "validate/files/output_folder.h"

namespace backbend::validate {

std::filesystem::path data_folder() {
  namespace fs = std::filesystem;
  std::error_code error;
  const fs::path program = render::own_file();
  // <prefix>/bin/backbend, or <sources>/build/<preset>/cli/backbend (tests:
  // build/<preset>/tests/x); of Python <prefix>/lib/python3/dist-packages/backbend/x.so.
  fs::path folder = program.parent_path();
  for (int level = 0; level < 5 && !folder.empty(); ++level, folder = folder.parent_path()) {
    for (const fs::path& candidate : {folder / "share" / "backbend", folder}) {
      if (fs::is_regular_file(candidate / "scenes" / "nightly.toml", error)) return candidate;
    }
    if (folder == folder.root_path()) break;
  }
  throw ReadError("cannot find the scenes that belong to " + program.string() +
                  ": expected ../share/backbend/scenes beside it or the source folder above it");
}

}  // namespace backbend::validate
