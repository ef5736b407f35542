#include "cli/import/fbx_names.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <set>
#include <string_view>

#include "cli/import/fbx_records.h"

namespace backbend::import {
namespace {

/// Copies a file's tree of records.
class Renaming {
 public:
  explicit Renaming(std::string_view in) : in_(in), records_(in) {}

  std::string run() {
    std::size_t at = records_.first();
    out_ = in_.substr(0, at);
    while (copy_record(at, in_.size(), Place::top, 0)) {
    }
    return out_ + std::string(in_.substr(at));
  }

 private:
  enum class Place { top, objects, other };

  void put_word(std::size_t at, std::uint64_t value) {
    std::memcpy(out_.data() + at, &value, records_.word());
  }

  /// Copies the record at `at` and moves on to the next; false after an empty one.
  bool copy_record(std::size_t& at, std::size_t limit, Place place, int depth) {
    const FbxRecords::Record record = records_.at(at, limit, depth);
    const std::size_t start = out_.size();
    if (record.ends_list) {
      out_ += in_.substr(at, record.end - at);
      at = record.end;
      return false;
    }
    out_ += in_.substr(at, record.properties - at);
    out_ += place == Place::objects && record.name == "Model" ? renamed(record.values)
                                                              : std::string(record.values);
    put_word(start + 2 * records_.word(), out_.size() - start - (record.properties - at));
    const Place inside =
        place == Place::top && record.name == "Objects" ? Place::objects : Place::other;
    at = record.children;
    while (at < record.end && copy_record(at, record.end, inside, depth + 1)) {
    }
    if (at != record.end)
      throw skin::CharacterError("is not whole: the record that begins at byte " +
                                 std::to_string(record.begin) + " ends too late");
    put_word(start, out_.size());
    return true;
  }

  std::string renamed(std::string_view values) {
    const FbxNode node = fbx_node(values);
    if (node.node_class != "LimbNode") return std::string(values);
    std::string own(node.name);
    for (int count = 1; !taken_.insert(own).second; ++count) {
      std::string digits = std::to_string(count);
      digits.insert(0, 3 - std::min<std::size_t>(digits.size(), 3), '0');
      own = std::string(node.name) + "." + digits;
    }
    // What follows the name in its string says what it is the name of.
    const std::size_t name_begin = node.name_at + 1 + sizeof(std::uint32_t);
    own += values.substr(name_begin, node.name_end - name_begin).substr(node.name.size());
    const auto length = static_cast<std::uint32_t>(own.size());
    std::string out(values.substr(0, node.name_at + 1));
    out.append(reinterpret_cast<const char*>(&length), sizeof length);
    return out + own + std::string(values.substr(node.name_end));
  }

  const std::string_view in_;
  const FbxRecords records_;
  std::string out_;
  std::set<std::string, std::less<>> taken_;
};

}  // namespace

std::optional<std::string> with_unique_joint_names(const std::string& fbx) {
  if (!FbxRecords::are_in(fbx)) return std::nullopt;
  return Renaming(fbx).run();
}

}  // namespace backbend::import
