#pragma once
#include <string>

namespace backbend::validate {

/// `word` in single quotes, as bash, zsh and fish take it back whatever bytes it holds.
std::string shell_quoted(const std::string& word);
/// The same, but as it is where nothing in it is special: for commands that people read.
std::string shell_word(const std::string& word);

}  // namespace backbend::validate
