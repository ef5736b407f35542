#include "validate/files/program_hash.h"

#include <filesystem>

#include "render/image/own_file.h"
#include "render/image/picture_library.h"
#include "validate/files/hash.h"
#include "validate/files/output_folder.h"

namespace backbend::validate {
namespace {

namespace fs = std::filesystem;

std::string hash_or_none(const fs::path& file) {
  std::error_code error;
  return fs::is_regular_file(file, error) ? content_hash(read_bytes(file)) : "none";
}

std::string compute() {
  std::string parts = content_hash(read_bytes(render::own_file()));
  try {
    const fs::path module = render::picture_module();
    parts +=
        " " + hash_or_none(module) + " " + hash_or_none(module.parent_path() / "backbend-import");
  } catch (const std::runtime_error&) {
    parts += " none none";
  }
  return content_hash(parts);
}

}  // namespace

const std::string& program_hash() {
  static const std::string hash = compute();
  return hash;
}

}  // namespace backbend::validate
