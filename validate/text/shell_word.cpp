#include "validate/text/shell_word.h"

#include <algorithm>
#include <cctype>
#include <string_view>

namespace backbend::validate {

std::string shell_quoted(const std::string& word) {
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

std::string shell_word(const std::string& word) {
  const bool plain = !word.empty() && std::ranges::all_of(word, [](unsigned char c) {
    return std::isalnum(c) != 0 ||
           std::string_view("._-/=:,+@%").find(static_cast<char>(c)) != std::string_view::npos;
  });
  return plain ? word : shell_quoted(word);
}

}  // namespace backbend::validate
