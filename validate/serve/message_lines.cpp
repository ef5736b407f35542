#include "validate/serve/message_lines.h"

#include <utility>

namespace backbend::validate {

void MessageLines::add(std::string_view bytes) {
  waiting_.erase(0, begin_);
  searched_ -= begin_;
  begin_ = 0;
  waiting_ += bytes;
}

std::optional<MessageLines::Line> MessageLines::next() {
  for (;;) {
    const std::size_t end = waiting_.find('\n', searched_);
    if (end == std::string::npos) {
      searched_ = waiting_.size();
      if (searched_ - begin_ > most_) {
        dropping_ = true;
        begin_ = searched_;
      }
      return std::nullopt;
    }
    Line line{waiting_.substr(begin_, end - begin_), false};
    begin_ = searched_ = end + 1;
    if (std::exchange(dropping_, false) || line.text.size() > most_) return Line{"", true};
    if (line.text.ends_with('\r')) line.text.pop_back();
    if (line.text.find_first_not_of(" \t") != std::string::npos) return line;
  }
}

}  // namespace backbend::validate
