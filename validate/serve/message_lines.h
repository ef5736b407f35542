#pragma once
#include <optional>
#include <string>
#include <string_view>

namespace backbend::validate {

/// Cuts what arrives into lines, of which it never keeps more than `most` bytes.
class MessageLines {
 public:
  explicit MessageLines(std::size_t most) : most_(most) {}

  struct Line {
    std::string text;       // without its line feed
    bool too_long = false;  // the text was dropped
  };

  void add(std::string_view bytes);
  /// The next whole line, in their order; nullopt until one is there. Blank lines are left out.
  std::optional<Line> next();

 private:
  std::size_t most_;
  std::string waiting_;
  std::size_t begin_ = 0, searched_ = 0;  // of waiting_
  bool dropping_ = false;                 // in the middle of a line that is too long
};

}  // namespace backbend::validate
