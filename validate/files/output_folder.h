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

  /// Makes the folder and tries that it can be written: long jobs fail early. Throws WriteError.
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

/// A name that is safe in every file system, from a name that anybody may have given. Two names may
/// give one.
std::string file_word(std::string_view name);

/// Removes what writers that were killed have left in a folder that nobody else writes now: files
/// that never got their name. With `deep` below it, too. Failing is no error.
void remove_leftovers(const std::filesystem::path& folder, bool deep = true);

/// All bytes of a regular file of at most `most_bytes`. Never waits on a pipe or device. Throws
/// ReadError.
std::vector<std::uint8_t> read_bytes(const std::filesystem::path& path,
                                     std::uintmax_t most_bytes = std::uintmax_t{1} << 32);
std::string read_text(const std::filesystem::path& path,
                      std::uintmax_t most_bytes = std::uintmax_t{1} << 28);

/// Points `link` at `target` (a name beside it) in one step. Failing is no error: some file systems
/// have no links.
void point_link(const std::filesystem::path& link, const std::filesystem::path& target);

}  // namespace backbend::validate
