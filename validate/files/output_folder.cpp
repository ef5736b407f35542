#include "validate/files/output_folder.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <map>
#include <mutex>
#include <random>
#include <system_error>
#include <utility>

#include "skin/gltf/lfs_pointer.h"
#include "validate/files/descriptor.h"

namespace backbend::validate {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& path, const std::string& doing, int error_number) {
  throw WriteError(
      path.string() + ": " + doing + ": " + std::generic_category().message(error_number),
      error_number);
}

int open_retrying(int folder, const fs::path& path, int flags, mode_t mode = 0) {
  int number = -1;
  do {
    number = ::openat(folder, path.c_str(), flags | O_CLOEXEC, mode);
  } while (number < 0 && errno == EINTR);
  return number;
}

int open_retrying(const fs::path& path, int flags) { return open_retrying(AT_FDCWD, path, flags); }

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

/// Reads the file back and compares: writers have been seen to report success on a full disk.
void verify(const Descriptor& file, const fs::path& final_path,
            std::span<const std::uint8_t> bytes) {
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

/// Which folder a path was when this process first wrote to it. They are held open: file systems in
/// user space may renumber a folder that no process holds open, and automounters its device.
class KnownFolders {
 public:
  void remember(const fs::path& path, Descriptor folder) {
    const std::lock_guard lock(mutex_);
    known_.insert_or_assign(key(path), std::move(folder));
  }
  /// The same folder as ever; one that is not known yet is from now on.
  bool is_still(const fs::path& path, const Descriptor& folder) {
    const std::lock_guard lock(mutex_);
    const auto known = known_.find(key(path));
    if (known != known_.end()) return identity(known->second) == identity(folder);
    Descriptor held(::fcntl(folder.number(), F_DUPFD_CLOEXEC, 0));
    if (held.number() >= 0) known_.emplace(key(path), std::move(held));
    return true;
  }

 private:
  static std::string key(const fs::path& path) {
    return fs::absolute(path).lexically_normal().string();
  }
  static std::pair<dev_t, ino_t> identity(const Descriptor& folder) {
    struct stat facts = {};
    ::fstat(folder.number(), &facts);
    return {facts.st_dev, facts.st_ino};
  }
  std::mutex mutex_;
  std::map<std::string, Descriptor> known_;
};

KnownFolders& known_folders() {
  static KnownFolders folders;
  return folders;
}

/// A folder to write in, made where there is none.
Descriptor open_folder(const fs::path& path) {
  make_folders(path);
  Descriptor folder(open_retrying(path, O_PATH | O_DIRECTORY));
  if (folder.number() < 0) fail(path, "cannot open the folder", errno);
  return folder;
}

/// The folder of that name in `parent`, made where there is none; never one behind a link.
Descriptor open_below(const Descriptor& parent, const fs::path& name, const fs::path& path) {
  constexpr int flags = O_PATH | O_DIRECTORY | O_NOFOLLOW;
  int number = open_retrying(parent.number(), name, flags);
  if (number < 0 && errno == ENOENT) {
    if (::mkdirat(parent.number(), name.c_str(), 0777) != 0 && errno != EEXIST)
      fail(path, "cannot make the folder", errno);
    number = open_retrying(parent.number(), name, flags);
  }
  if (number >= 0) return Descriptor(number);
  const int error_number = errno;
  struct stat facts = {};
  if (::fstatat(parent.number(), name.c_str(), &facts, AT_SYMLINK_NOFOLLOW) == 0 &&
      S_ISLNK(facts.st_mode))
    fail(path, "is a link where a folder of the run should be", ELOOP);
  fail(path, "cannot open the folder", error_number);
}

}  // namespace

/// The folder of a file to be, held open: what is put in its place meanwhile is not written to.
struct OutputFolder::Temporary::Place {
  Descriptor folder;
  fs::path target;   // as the user knows it
  std::string name;  // in its folder, until it is given its own
  bool committed = false;

  int open(int flags) const {
    return open_retrying(folder.number(), name, flags | O_NOFOLLOW, 0666);
  }

  void rename() {
    if (::renameat(folder.number(), name.c_str(), folder.number(), target.filename().c_str()) != 0)
      fail(target, "cannot give the file its name", errno);
    committed = true;
    const Descriptor handle(open_retrying(folder.number(), ".", O_RDONLY | O_DIRECTORY));
    if (handle.number() >= 0) flush(handle, target.parent_path());
  }
};

bool WriteError::temporary() const {
  return error_number == ENOSPC || error_number == EDQUOT || error_number == EIO;
}

OutputFolder::OutputFolder(fs::path path) : path_(std::move(path)) {
  if (path_.empty()) path_ = ".";
}

void OutputFolder::prepare() const {
  known_folders().remember(path_, open_folder(path_));
  if (::access(path_.c_str(), W_OK | X_OK) != 0) fail(path_, "cannot write into the folder", errno);
}

OutputFolder::Temporary::Temporary(std::unique_ptr<Place> place) : place_(std::move(place)) {}

OutputFolder::Temporary::~Temporary() {
  if (!place_->committed) ::unlinkat(place_->folder.number(), place_->name.c_str(), 0);
}

OutputFolder::Temporary OutputFolder::temporary_for(const fs::path& relative) const {
  static std::atomic<unsigned> counter{0};
  // Process numbers repeat in containers and on machines that share a folder.
  static const std::string process =
      std::to_string(::getpid()) + "-" + std::to_string(std::random_device{}());
  Descriptor folder = open_folder(path_);
  if (!known_folders().is_still(path_, folder))
    fail(path_, "another folder was put in its place while this was written", ESTALE);
  fs::path so_far = path_;
  for (const fs::path& name : relative.parent_path()) {
    so_far /= name;
    if (name == ".." || name == "/") fail(so_far, "is not below the output folder", EXDEV);
    if (!name.empty() && name != ".") folder = open_below(folder, name, so_far);
  }
  const std::string name =
      "." + relative.filename().string() + ".tmp-" + process + "-" + std::to_string(counter++);
  return Temporary(std::unique_ptr<Temporary::Place>(
      new Temporary::Place{std::move(folder), path_ / relative, name}));
}

fs::path OutputFolder::Temporary::path() const {
  fs::path held =
      "/proc/" + std::to_string(::getpid()) + "/fd/" + std::to_string(place_->folder.number());
  std::error_code error;
  // Where no /proc is mounted, the name must do.
  if (!fs::is_directory(held, error)) held = place_->target.parent_path();
  return held / place_->name;
}

void OutputFolder::Temporary::commit() {
  {
    const Descriptor file(place_->open(O_RDONLY));
    if (file.number() < 0) fail(place_->target, "cannot open what was written", errno);
    flush(file, place_->target);
  }
  place_->rename();
}

void OutputFolder::write(const fs::path& relative, std::span<const std::uint8_t> bytes) const {
  const Temporary temporary = temporary_for(relative);
  Temporary::Place& place = *temporary.place_;
  Descriptor file(place.open(O_WRONLY | O_CREAT | O_EXCL));
  if (file.number() < 0) fail(place.target, "cannot create", errno);
  write_all(file, place.target, bytes);
  flush(file, place.target);
  if (file.close() != 0 && errno != EINTR) fail(place.target, "cannot close", errno);
  verify(Descriptor(place.open(O_RDONLY)), place.target, bytes);
  place.rename();
}

void OutputFolder::write(const fs::path& relative, std::string_view text) const {
  write(relative, std::span(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()));
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
  if (skin::is_lfs_pointer(bytes)) throw refuse(skin::kLfsPointerError);
  return bytes;
}

std::string read_text(const fs::path& path, std::uintmax_t most_bytes) {
  const std::vector<std::uint8_t> bytes = read_bytes(path, most_bytes);
  return std::string(bytes.begin(), bytes.end());
}

bool is_inside(const std::string& name) {
  const fs::path path(name);
  return !path.empty() && path.is_relative() && path.lexically_normal() == path &&
         *path.begin() != "..";
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
