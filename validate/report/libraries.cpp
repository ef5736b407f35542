#include "validate/report/libraries.h"

#include <gnu/libc-version.h>
#include <oneapi/tbb/version.h>
#include <sqlite3.h>

#include <string_view>

#include "render/trace/library_versions.h"

namespace backbend::validate {

std::map<std::string, std::string> program_versions() {
  std::map<std::string, std::string> out = {{"backbend", BACKBEND_VERSION},
                                            {"compiler", __VERSION__}};
  // NAME VERSION|NAME VERSION|, from cmake/Libraries.cmake
  for (std::string_view rest = BACKBEND_LIBRARIES; !rest.empty();) {
    const std::string_view entry = rest.substr(0, rest.find('|'));
    rest.remove_prefix(entry.size() + 1);
    const std::size_t blank = entry.find(' ');
    out["library " + std::string(entry.substr(0, blank))] = std::string(entry.substr(blank + 1));
  }
  std::map<std::string, std::string> running = render::library_versions();
  running["tbb"] = TBB_runtime_version();
  running["sqlite"] = sqlite3_libversion();
  for (const auto& [name, version] : running) out["library " + name] += ", running " + version;
  // The mathematical functions that results rest on are its own.
  out["library glibc"] = std::string("running ") + gnu_get_libc_version();
  return out;
}

}  // namespace backbend::validate
