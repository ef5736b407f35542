#include "render/trace/modes.h"

namespace backbend::render {

const std::map<std::string, Mode>& modes() {
  static const std::map<std::string, Mode> all = {
      {"beauty", Mode::beauty}, {"clay", Mode::clay},           {"ao", Mode::ao},
      {"matcap", Mode::matcap}, {"wireframe", Mode::wireframe}, {"heat", Mode::heat},
      {"xray", Mode::xray},     {"contour", Mode::contour},     {"primary", Mode::primary}};
  return all;
}

}  // namespace backbend::render
