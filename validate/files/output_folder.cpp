#include "validate/files/output_folder.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <random>
#include <system_error>

namespace backbend::validate {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& path, const std::string& doing, int error_number) {
  throw WriteError(
      path.string() + ": " + doing + ": " + std::generic_category().message(error_number),
      error_number);
}

/// A descriptor that closes itself; close() reports what the medium only says at the end.
class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  ~Descriptor() {
    if (number_ >= 0) ::close(number_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int number() const { return number_; }
  int close() {
    const int result = ::close(number_);
    number_ = -1;
    return result;
  }

 private:
  int number_;
};

int open_retrying(const fs::path& path, int flags, mode_t mode = 0) {
  int number = -1;
  do {
    number = ::open(path.c_str(), flags | O_CLOEXEC, mode);
  } while (number < 0 && errno == EINTR);
  return number;
}

void write_all(const Descriptor& file, const fs::path& path, std::span<const std::uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(file.number(), bytes.data(), bytes.size());
    if (written < 0) {
      if (errno == EINTR) continue;
      fail(path, "cannot write", errno);
    }
    if (written == 0) fail(path, "cannot write", ENOSPC);
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
}

void flush(const Descriptor& file, const fs::path& path) {
  while (::fsync(file.number()) != 0) {
    if (errno == EINTR) continue;
    if (errno == EINVAL || errno == EROFS)
      return;  // the medium cannot be flushed (a pipe, a device)
    fail(path, "cannot flush", errno);
  }
}

void flush_folder(const fs::path& folder) {
  const Descriptor handle(open_retrying(folder, O_RDONLY | O_DIRECTORY));
  if (handle.number() >= 0) flush(handle, folder);
}

/// Reads the file back and compares: writers have been seen to report success on a full disk.
void verify(const fs::path& temporary, const fs::path& final_path,
            std::span<const std::uint8_t> bytes) {
  const Descriptor file(open_retrying(temporary, O_RDONLY | O_NOFOLLOW));
  if (file.number() < 0) fail(final_path, "cannot read back", errno);
  std::array<std::uint8_t, 65536> block;
  std::size_t offset = 0;
  while (true) {
    const ssize_t got = ::read(file.number(), block.data(), block.size());
    if (got < 0) {
      if (errno == EINTR) continue;
      fail(final_path, "cannot read back", errno);
    }
    if (got == 0) break;
    const auto count = static_cast<std::size_t>(got);
    if (offset + count > bytes.size() ||
        !std::equal(block.begin(), block.begin() + got,
                    bytes.begin() + static_cast<std::ptrdiff_t>(offset))) {
      fail(final_path, "what was read back differs from what was written", EIO);
    }
    offset += count;
  }
  if (offset != bytes.size()) fail(final_path, "the file is shorter than what was written", ENOSPC);
}

void make_folders(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error && !fs::is_directory(folder)) fail(folder, "cannot make the folder", error.value());
}

void rename_into_place(const fs::path& temporary, const fs::path& path) {
  if (::rename(temporary.c_str(), path.c_str()) != 0) {
    const int error_number = errno;
    ::unlink(temporary.c_str());
    fail(path, "cannot give the file its name", error_number);
  }
  flush_folder(path.parent_path().empty() ? fs::path(".") : path.parent_path());
}

}  // namespace

bool WriteError::temporary() const {
  return error_number == ENOSPC || error_number == EDQUOT || error_number == EIO;
}

OutputFolder::OutputFolder(fs::path path) : path_(std::move(path)) {
  if (path_.empty()) path_ = ".";
}

void OutputFolder::prepare() const {
  make_folders(path_);
  if (::access(path_.c_str(), W_OK | X_OK) != 0) fail(path_, "cannot write into the folder", errno);
}

fs::path OutputFolder::temporary_for(const fs::path& relative) const {
  static std::atomic<unsigned> counter{0};
  // Process numbers repeat in containers and on machines that share a folder.
  static const std::string process =
      std::to_string(::getpid()) + "-" + std::to_string(std::random_device{}());
  const fs::path target = path_ / relative;
  make_folders(target.parent_path());
  return target.parent_path() /
         ("." + target.filename().string() + ".tmp-" + process + "-" + std::to_string(counter++));
}

void OutputFolder::write(const fs::path& relative, std::span<const std::uint8_t> bytes) const {
  const fs::path target = path_ / relative;
  const fs::path temporary = temporary_for(relative);
  try {
    Descriptor file(open_retrying(temporary, O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW, 0666));
    if (file.number() < 0) fail(target, "cannot create", errno);
    write_all(file, target, bytes);
    flush(file, target);
    if (file.close() != 0 && errno != EINTR) fail(target, "cannot close", errno);
    verify(temporary, target, bytes);
  } catch (...) {
    ::unlink(temporary.c_str());
    throw;
  }
  rename_into_place(temporary, target);
}

void OutputFolder::write(const fs::path& relative, std::string_view text) const {
  write(relative, std::span(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()));
}

void OutputFolder::commit(const fs::path& temporary, const fs::path& relative) const {
  const fs::path target = path_ / relative;
  try {
    const Descriptor file(open_retrying(temporary, O_RDONLY | O_NOFOLLOW));
    if (file.number() < 0) fail(target, "cannot open what was written", errno);
    flush(file, target);
  } catch (...) {
    ::unlink(temporary.c_str());
    throw;
  }
  rename_into_place(temporary, target);
}

std::vector<std::uint8_t> read_bytes(const fs::path& path, std::uintmax_t most_bytes) {
  const auto refuse = [&](const std::string& why) -> ReadError {
    return ReadError(path.string() + ": " + why);
  };
  const Descriptor file(open_retrying(path, O_RDONLY | O_NONBLOCK));
  if (file.number() < 0) throw refuse(std::generic_category().message(errno));
  struct stat facts = {};
  if (::fstat(file.number(), &facts) != 0) throw refuse(std::generic_category().message(errno));
  if (S_ISDIR(facts.st_mode)) throw refuse("is a folder, expected a file");
  if (!S_ISREG(facts.st_mode)) throw refuse("is not a regular file");
  const auto size = static_cast<std::uintmax_t>(facts.st_size);
  if (size > most_bytes) {
    throw refuse("has " + std::to_string(size) + " bytes, more than the " +
                 std::to_string(most_bytes) + " that are read");
  }
  std::vector<std::uint8_t> bytes(size);
  std::size_t offset = 0;
  while (offset < bytes.size()) {
    const ssize_t got = ::read(file.number(), bytes.data() + offset, bytes.size() - offset);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) throw refuse(std::generic_category().message(errno));
    if (got == 0) throw refuse("became shorter while it was read");
    offset += static_cast<std::size_t>(got);
  }
  return bytes;
}

std::string read_text(const fs::path& path, std::uintmax_t most_bytes) {
  const std::vector<std::uint8_t> bytes = read_bytes(path, most_bytes);
  return std::string(bytes.begin(), bytes.end());
}

std::string file_word(std::string_view name) {
  std::string word;
  for (const char c : name) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                       c == '_' || c == '-' || c == '.';
    word += plain ? c : '_';
  }
  return word.substr(0, 80);
}

void remove_leftovers(const fs::path& folder, bool deep) {
  std::vector<fs::path> found;
  std::error_code error;
  for (fs::recursive_directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    if (!deep) entry.disable_recursion_pending();
    const std::string name = entry->path().filename().string();
    if (name.starts_with(".") && name.find(".tmp-") != std::string::npos &&
        entry->symlink_status(error).type() == fs::file_type::regular)
      found.push_back(entry->path());
  }
  for (const fs::path& file : found) fs::remove(file, error);
}

void point_link(const fs::path& link, const fs::path& target) {
  const fs::path temporary = link.string() + ".tmp-" + std::to_string(::getpid());
  ::unlink(temporary.c_str());
  if (::symlink(target.c_str(), temporary.c_str()) != 0) return;
  if (::rename(temporary.c_str(), link.c_str()) != 0) ::unlink(temporary.c_str());
}

}  // namespace backbend::validate
