#pragma once
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

namespace backbend::validate {

/// A file that a client may not name. what() is what the client is told.
struct AccessError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The folders that a client may name files in. Links are followed before a path is judged. It
/// guards what a client names, not what a file of the studio names in turn: the commands have rules
/// of their own for that.
class FileAccess {
 public:
  /// Throws AccessError where one is no folder. The first one is what relative paths start from.
  explicit FileAccess(const std::vector<std::filesystem::path>& roots);

  const std::filesystem::path& first() const { return roots_.front(); }

  /// Throws AccessError where `file` lies outside, whether it is there or not.
  void require_inside(const std::string& file) const;
  /// The same, and where something is there already: outputs replace nothing.
  void require_new(const std::string& file) const;

 private:
  std::vector<std::filesystem::path> roots_;  // absolute, without links
};

}  // namespace backbend::validate
