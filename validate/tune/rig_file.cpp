#include "validate/tune/rig_file.h"

#include <nlohmann/json.hpp>

#include "skin/character/printable.h"
#include "validate/text/number_text.h"

namespace backbend::validate {
namespace {

struct TomlText {
  std::string operator()(bool flag) const { return flag ? "true" : "false"; }
  std::string operator()(double number) const { return shortest(number); }
  // A JSON string is a basic string of TOML.
  std::string operator()(const std::string& text) const {
    return nlohmann::json(text).dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
  }
  template <class Element>
  std::string operator()(const std::vector<Element>& list) const {
    std::string text;
    for (const Element& each : list) text += (text.empty() ? "" : ", ") + (*this)(each);
    return "[" + text + "]";
  }
};

}  // namespace

std::string rig_toml(const solver::SystemSpec& spec, const std::vector<std::string>& comment) {
  std::string out;
  for (const std::string& line : comment) out += "# " + skin::printable(line) + "\n";
  out += "[rig]\nsystem = " + TomlText()(spec.system) + "\n";
  for (const auto& [key, value] : spec.options)
    out += key + " = " + std::visit(TomlText(), value) + "\n";
  return out;
}

}  // namespace backbend::validate
