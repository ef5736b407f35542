#include "render/image/picture_library.h"

#include <dlfcn.h>

#include <filesystem>
#include <stdexcept>

#include "render/image/own_file.h"

namespace backbend::render {
namespace {

namespace fs = std::filesystem;

constexpr const char* kModule = "backbend-pictures.so";
constexpr const char* kEntry = "backbend_picture_library";

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

fs::path picture_module() {
  fs::path file = libexec_file(kModule);
  std::error_code error;
  if (fs::is_regular_file(file, error)) return file;
  throw std::runtime_error("cannot find " + std::string(kModule) +
                           ", which reads and writes pictures: expected " + file.string());
}

const PictureLibrary& picture_library() {
  static const PictureLibrary& library = load();
  return library;
}

}  // namespace backbend::render
