#include "render/picture_library.h"

#include <dlfcn.h>
#include <link.h>

#include <filesystem>
#include <stdexcept>

namespace backbend::render {
namespace {

namespace fs = std::filesystem;

constexpr const char* kModule = "backbend-pictures.so";
constexpr const char* kEntry = "backbend_picture_library";

/// The folder of the file that this code is linked into: a program, or a library of one.
fs::path own_folder() {
  static const char here = 0;
  Dl_info info;
  link_map* map = nullptr;
  // A program is called what its caller calls it, which says nothing; its map has no name.
  if (dladdr1(&here, &info, reinterpret_cast<void**>(&map), RTLD_DL_LINKMAP) == 0 ||
      map == nullptr || map->l_name == nullptr || *map->l_name == '\0')
    return fs::read_symlink("/proc/self/exe").parent_path();
  return fs::canonical(map->l_name).parent_path();
}

const PictureLibrary& load() {
  const fs::path file = picture_module();
  // Never unloaded: its library has threads of its own.
  void* module = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  void* entry = module == nullptr ? nullptr : dlsym(module, kEntry);
  if (entry == nullptr) {
    const char* why = dlerror();
    throw std::runtime_error("cannot load " + file.string() + ": " +
                             (why == nullptr ? "no reason given" : why));
  }
  return *reinterpret_cast<const PictureLibrary* (*)()>(entry)();
}

}  // namespace

/// <prefix>/bin/backbend has it in <prefix>/libexec/backbend, a build folder in its own
/// libexec/backbend; programs of a build are up to two folders deep, libraries of Python's three.
fs::path picture_module() {
  const fs::path first = own_folder().parent_path();
  fs::path above = first;
  std::error_code error;
  for (int step = 0; step < 3; ++step, above = above.parent_path()) {
    const fs::path file = above / "libexec" / "backbend" / kModule;
    if (fs::is_regular_file(file, error)) return file;
  }
  throw std::runtime_error("cannot find " + std::string(kModule) +
                           ", which reads and writes pictures: expected " +
                           (first / "libexec" / "backbend" / kModule).string());
}

const PictureLibrary& picture_library() {
  static const PictureLibrary& library = load();
  return library;
}

}  // namespace backbend::render
