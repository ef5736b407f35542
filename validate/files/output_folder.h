#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace backbend::validate {

/// A file that could not be written whole. what() is the whole line the user sees.
struct WriteError : std::runtime_error {
  WriteError(const std::string& message, int error_number)
      : std::runtime_error(message), error_number(error_number) {}
  /// Full disks and failing media may pass: a farm should retry (exit 75). The rest is exit 73.
  bool temporary() const;
  int error_number;
};

/// A file that could not be read. what() is the whole line the user sees.
struct ReadError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A folder that files appear in whole or not at all.
///
/// Each file is written beside its place under a name of its own, flushed to the medium, read back
/// and compared, and only then given its name: a full disk that a writer fails to report is caught
/// here. Links planted at an output's name are replaced, never followed; links in the place of
/// folders below this one are refused, and so is another folder that has been put in this one's
/// place since this process first wrote to it. The folder itself may be named through links.
class OutputFolder {
 public:
  /// Names the folder; nothing is made before prepare() or the first write.
  explicit OutputFolder(std::filesystem::path path);

  /// Makes the folder and tests that it is writable: long jobs fail early. Throws WriteError.
  void prepare() const;

  /// Writes one file at `relative`, which has no `..` in it (folders are made as needed). Throws
  /// WriteError.
  void write(const std::filesystem::path& relative, std::span<const std::uint8_t> bytes) const;
  void write(const std::filesystem::path& relative, std::string_view text) const;

  /// A file that another program writes, under a name that no other process uses. It is gone where
  /// it was not committed.
  class Temporary {
   public:
    ~Temporary();
    Temporary(const Temporary&) = delete;
    Temporary& operator=(const Temporary&) = delete;
    /// For the other program, while this lives: the file in its folder, wherever that may be moved.
    std::filesystem::path path() const;
    /// Flushes the file and gives it its name. Throws WriteError.
    void commit();

   private:
    friend class OutputFolder;
    struct Place;
    explicit Temporary(std::unique_ptr<Place> place);
    std::unique_ptr<Place> place_;
  };
  Temporary temporary_for(const std::filesystem::path& relative) const;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// Whether a name stays below the folder that it is relative to.
bool is_inside(const std::string& name);

/// A name that is safe in every file system, from any name. Two names may map to the same one.
std::string file_word(std::string_view name);

/// Removes the temporary files of killed writers from a folder that no other process writes. With
/// `deep`, below it as well. Failures are ignored.
void remove_leftovers(const std::filesystem::path& folder, bool deep = true);

/// All bytes of a regular file of at most `most_bytes`. Never waits on a pipe or device. Throws
/// ReadError, also for a Git LFS pointer.
std::vector<std::uint8_t> read_bytes(const std::filesystem::path& path,
                                     std::uintmax_t most_bytes = std::uintmax_t{1} << 32);
std::string read_text(const std::filesystem::path& path,
                      std::uintmax_t most_bytes = std::uintmax_t{1} << 28);

/// Points `link` at `target` (a name beside it) in one step. Failures are ignored: some file
/// systems have no links.
void point_link(const std::filesystem::path& link, const std::filesystem::path& target);

}  // namespace backbend::validate
