#include "skin/gltf/asset_folder.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>

#include "skin/character/character.h"
#include "skin/character/printable.h"
#include "skin/gltf/lfs_pointer.h"

namespace backbend::skin {
namespace {

/// An open file, closed on every way out.
struct OpenFile {
  int descriptor;
  explicit OpenFile(const char* name)
      // Without O_NONBLOCK the open of a pipe would wait for a writer that never comes.
      : descriptor(::open(name, O_RDONLY | O_NONBLOCK | O_CLOEXEC | O_NOCTTY)) {}
  ~OpenFile() {
    if (descriptor >= 0) ::close(descriptor);
  }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
};

std::string reason(int error) { return std::generic_category().message(error); }

int hex_value(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

}  // namespace

std::vector<std::uint8_t> read_regular_file(const std::filesystem::path& file,
                                            std::size_t max_bytes) {
  const OpenFile open(file.c_str());
  if (open.descriptor < 0) throw CharacterError(file.string() + ": " + reason(errno));
  struct stat facts {};
  if (::fstat(open.descriptor, &facts) != 0)
    throw CharacterError(file.string() + ": " + reason(errno));
  if (!S_ISREG(facts.st_mode)) throw CharacterError(file.string() + ": not a regular file");
  if (facts.st_size < 0 || static_cast<std::uint64_t>(facts.st_size) > max_bytes)
    throw CharacterError(file.string() + ": " + std::to_string(facts.st_size) +
                         " bytes, more than the " + std::to_string(max_bytes) + " that are read");

  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(facts.st_size));
  std::size_t filled = 0;
  while (filled < bytes.size()) {
    const ssize_t got = ::read(open.descriptor, bytes.data() + filled, bytes.size() - filled);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) throw CharacterError(file.string() + ": " + reason(errno));
    if (got == 0) break;  // it shrank while we read
    filled += static_cast<std::size_t>(got);
  }
  bytes.resize(filled);
  if (is_lfs_pointer(bytes)) throw CharacterError(file.string() + ": " + kLfsPointerError);
  return bytes;
}

std::filesystem::path path_inside(const std::filesystem::path& folder, const std::string& uri) {
  namespace fs = std::filesystem;
  if (uri.empty()) throw CharacterError("empty file name");
  const fs::path relative(uri);
  const auto colon = uri.find(':');
  const bool has_scheme = colon != std::string::npos && colon < uri.find('/');
  if (has_scheme || relative.is_absolute() || uri.find('\0') != std::string::npos)
    throw CharacterError(in_quotes(uri) + " is not a relative path");
  if (std::any_of(relative.begin(), relative.end(), [](const fs::path& p) { return p == ".."; }))
    throw CharacterError(in_quotes(uri) + " leaves the asset's folder");

  std::error_code error;
  const fs::path base = fs::canonical(folder.empty() ? fs::path(".") : folder, error);
  if (error) throw CharacterError(folder.string() + ": " + error.message());
  const fs::path target = fs::canonical(base / relative, error);
  if (error) throw CharacterError(in_quotes(uri) + ": " + error.message());
  if (std::mismatch(base.begin(), base.end(), target.begin(), target.end()).first != base.end())
    throw CharacterError(in_quotes(uri) + " leaves the asset's folder through a link");
  return target;
}

std::string percent_decoded(const std::string& uri) {
  std::string out;
  for (std::size_t at = 0; at < uri.size(); ++at) {
    const int high = uri[at] == '%' && at + 2 < uri.size() ? hex_value(uri[at + 1]) : -1;
    const int low = high >= 0 ? hex_value(uri[at + 2]) : -1;
    if (low < 0) {
      out += uri[at];
    } else {
      out += static_cast<char>(high * 16 + low);
      at += 2;
    }
  }
  return out;
}

}  // namespace backbend::skin
