#include "validate/serve/file_access.h"

#include <algorithm>

#include "validate/text/escape.h"

namespace backbend::validate {
namespace {

namespace fs = std::filesystem;

bool lies_in(const fs::path& file, const fs::path& folder) {
  return std::mismatch(folder.begin(), folder.end(), file.begin(), file.end()).first ==
         folder.end();
}

}  // namespace

FileAccess::FileAccess(const std::vector<fs::path>& roots) {
  for (const fs::path& root : roots) {
    std::error_code error;
    fs::path real = fs::canonical(root, error);
    if (error || !fs::is_directory(real, error))
      throw AccessError("'" + root.string() + "': no such folder");
    roots_.push_back(std::move(real));
  }
}

void FileAccess::require_inside(const std::string& file) const {
  std::error_code error;
  // A NUL would end the name early for the system, and so name another file than the one judged.
  const bool is_whole = !file.empty() && file.find('\0') == std::string::npos;
  const fs::path real = is_whole ? fs::weakly_canonical(first() / file, error) : fs::path();
  if (is_whole && !error &&
      std::ranges::any_of(roots_, [&](const fs::path& root) { return lies_in(real, root); }))
    return;
  throw AccessError("'" + visible(file) +
                    "' is outside the folders that this server reads (backbend serve --root DIR)");
}

void FileAccess::require_new(const std::string& file) const {
  require_inside(file);
  std::error_code error;
  if (fs::symlink_status(first() / file, error).type() != fs::file_type::not_found)
    throw AccessError("'" + visible(file) + "' is there already; name another output");
}

}  // namespace backbend::validate
