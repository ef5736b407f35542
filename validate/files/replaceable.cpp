#include "validate/files/replaceable.h"

#include <cerrno>

#include "validate/files/output_folder.h"

namespace backbend::validate {

void require_replaceable(const std::filesystem::path& file) {
  namespace fs = std::filesystem;
  std::error_code none;
  const fs::file_status status = fs::status(file, none);
  if (!fs::exists(status)) return;
  if (fs::is_directory(status))
    throw WriteError(file.string() + ": cannot be written: it is a folder", EISDIR);
  // The marks, not what this process may do: an administrator may write everything.
  constexpr fs::perms kWrite =
      fs::perms::owner_write | fs::perms::group_write | fs::perms::others_write;
  if ((status.permissions() & kWrite) == fs::perms::none)
    throw WriteError(file.string() +
                         ": cannot be written: it is read-only; check it out, or "
                         "write to another file",
                     EACCES);
}

}  // namespace backbend::validate
