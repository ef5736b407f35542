#include "skin/gltf/usd_names.h"

namespace backbend::skin {
namespace {

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

}  // namespace

std::string usd_identifier(std::string_view name, std::string_view otherwise) {
  if (name.empty()) return std::string(otherwise);
  std::string word = is_digit(name.front()) ? "_" : "";
  for (const char c : name) word += is_letter(c) || is_digit(c) ? c : '_';
  return word;
}

std::string UniqueNames::take(std::string name) {
  const std::string stem = name;
  for (int again = 2; !taken_.insert(name).second; ++again)
    name = stem + "_" + std::to_string(again);
  return name;
}

std::string usd_string(std::string_view text) {
  std::string quoted = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    quoted += byte < 0x20 || byte == 0x7f ? '?' : c == '"' ? '\'' : c == '\\' ? '/' : c;
  }
  return quoted + "\"";
}

}  // namespace backbend::skin
