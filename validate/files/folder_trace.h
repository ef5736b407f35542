#pragma once
#include <filesystem>
#include <vector>

#include "validate/files/ledger.h"

namespace backbend::validate {

/// On destruction, removes the directories that it found missing and that are still empty: a job
/// that is refused leaves no trace. What another run has locked is that run's, which may not have
/// written to it yet.
class FolderTrace {
 public:
  explicit FolderTrace(const std::filesystem::path& folder) {
    namespace fs = std::filesystem;
    std::error_code none;
    for (fs::path p = fs::absolute(folder, none).lexically_normal();
         !p.empty() && !fs::exists(p, none); p = p.parent_path())
      missing_.push_back(p);
  }
  ~FolderTrace() {
    std::error_code none;
    try {
      for (const std::filesystem::path& p : missing_) {
        const FolderLock lock(p, FolderLock::Kind::exclusive);
        std::filesystem::remove(p, none);  // only where it is empty
      }
    } catch (const BusyError&) {
    }
  }
  /// Removes nothing: another made the folder.
  void keep() { missing_.clear(); }
  FolderTrace(const FolderTrace&) = delete;
  FolderTrace& operator=(const FolderTrace&) = delete;

 private:
  std::vector<std::filesystem::path> missing_;  // the deepest first
};

}  // namespace backbend::validate
