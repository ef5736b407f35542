#include "tests/fuzz/target.h"

#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <stdexcept>

#include "tests/source_folder.h"

namespace backbend::fuzz {
namespace {

/// A folder of this process, gone with it. In memory where it can be: on a disk, writing a small
/// file takes longer than everything that is tried on it.
struct Scratch {
  std::filesystem::path path;
  Scratch() {
    for (const std::filesystem::path& place :
         {std::filesystem::path("/dev/shm"), std::filesystem::temp_directory_path()}) {
      std::string pattern = (place / "backbend_fuzz_XXXXXX").string();
      if (::mkdtemp(pattern.data()) == nullptr) continue;
      path = pattern;
      return;
    }
    throw std::runtime_error("no temporary folder");
  }
  ~Scratch() {
    std::error_code ignored;
    std::filesystem::remove_all(path, ignored);
  }
};

std::string& refusal() {
  static std::string last;
  return last;
}

}  // namespace

std::vector<Target>& targets() {
  static std::vector<Target> all;
  return all;
}

void require(bool holds, const char* promise) {
  if (holds) return;
  std::fprintf(stderr, "broken promise: %s\n", promise);
  std::abort();
}

bool refused(const std::exception& error) {
  refusal() = error.what();
  require(!refusal().empty(), "a refusal says why");
  return false;
}

const std::string& last_refusal() { return refusal(); }

bool one_in(unsigned many, Input input) {
  std::uint32_t sum = 2166136261;  // FNV-1a
  for (const std::uint8_t byte : input) sum = (sum ^ byte) * 16777619;
  return (sum >> 8) % many == 0;
}

std::filesystem::path as_file(Input input, const std::string& name) {
  static const Scratch scratch;
  const std::filesystem::path file = scratch.path / name;
  std::ofstream out(file, std::ios::binary | std::ios::trunc);
  out.write(reinterpret_cast<const char*>(input.data()),
            static_cast<std::streamsize>(input.size()));
  out.close();
  if (!out) throw std::runtime_error("cannot write " + file.string());
  return file;
}

std::string source_text(const std::string& relative) {
  std::ifstream in(source_folder() / relative, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(in), {}};
  if (!in || text.empty()) throw std::runtime_error("cannot read " + relative);
  return text;
}

}  // namespace backbend::fuzz
