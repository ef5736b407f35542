#include "render/image/own_file.h"

#include <dlfcn.h>
#include <link.h>

namespace backbend::render {

std::filesystem::path own_file() {
  static const char here = 0;
  Dl_info info;
  link_map* map = nullptr;
  // A program is called what its caller calls it, which says nothing; its map has no name.
  if (dladdr1(&here, &info, reinterpret_cast<void**>(&map), RTLD_DL_LINKMAP) == 0 ||
      map == nullptr || map->l_name == nullptr || *map->l_name == '\0')
    return std::filesystem::read_symlink("/proc/self/exe");
  return std::filesystem::canonical(map->l_name);
}

std::filesystem::path libexec_file(const std::string& name) {
  constexpr int kMostAbove = 4;
  const std::filesystem::path first = own_file().parent_path().parent_path();
  std::filesystem::path above = first;
  std::error_code error;
  for (int step = 0; step < kMostAbove; ++step, above = above.parent_path()) {
    std::filesystem::path file = above / "libexec" / "backbend" / name;
    if (std::filesystem::is_regular_file(file, error)) return file;
  }
  return first / "libexec" / "backbend" / name;
}

}  // namespace backbend::render
