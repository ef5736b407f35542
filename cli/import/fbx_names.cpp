#include "cli/import/fbx_names.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <set>
#include <string_view>

#include "skin/character/character.h"

namespace backbend::import {
namespace {

using namespace std::string_view_literals;
using skin::CharacterError;

constexpr auto kMagic = "Kaydara FBX Binary  \0\x1a\0"sv;
constexpr auto kKind = "\0\x01Model"sv;  // follows a node's name
constexpr std::uint32_t kFirstVersion = 7000, kFirstWide = 7500;
constexpr int kDeepest = 64;

template <class T>
T number_at(std::string_view bytes, std::size_t at) {
  if (at > bytes.size() || sizeof(T) > bytes.size() - at)
    throw CharacterError("is cut short: a record reaches beyond the file's end");
  T out;  // little-endian, as the program's machines are
  std::memcpy(&out, bytes.data() + at, sizeof out);
  return out;
}

/// Copies a file's tree of records. A record is its end, its number of properties and their size
/// (4 bytes each, 8 since version 7.5), a name, the properties and other records; an empty one ends
/// a list.
class Renaming {
 public:
  explicit Renaming(std::string_view in)
      : in_(in), word_(number_at<std::uint32_t>(in, kMagic.size()) >= kFirstWide ? 8 : 4) {}

  std::string run() {
    std::size_t at = kMagic.size() + sizeof(std::uint32_t);
    out_ = in_.substr(0, at);
    while (copy_record(at, in_.size(), Place::top, 0)) {
    }
    return out_ + std::string(in_.substr(at));
  }

 private:
  enum class Place { top, objects, other };

  std::uint64_t word_at(std::size_t at) const {
    return word_ == 8 ? number_at<std::uint64_t>(in_, at) : number_at<std::uint32_t>(in_, at);
  }
  void put_word(std::size_t at, std::uint64_t value) {
    std::memcpy(out_.data() + at, &value, word_);
  }

  /// Copies the record at `at` and moves on to the next; false after an empty one.
  bool copy_record(std::size_t& at, std::size_t limit, Place place, int depth) {
    const std::size_t begin = at, name_at = begin + 3 * word_ + 1;
    const std::uint64_t end = word_at(begin), size = word_at(begin + 2 * word_);
    const std::size_t name_size = number_at<std::uint8_t>(in_, name_at - 1);
    const std::size_t start = out_.size();
    if (end == 0) {
      out_ += in_.substr(begin, name_at - begin);
      at = name_at;
      return false;
    }
    const std::size_t properties = name_at + name_size;
    if (end > limit || properties > end || size > end - properties || depth > kDeepest)
      throw CharacterError("is not whole: a record at byte " + std::to_string(begin) +
                           " does not end within what holds it");
    out_ += in_.substr(begin, properties - begin);
    const std::string_view name = in_.substr(name_at, name_size);
    const std::string_view values = in_.substr(properties, size);
    out_ += place == Place::objects && name == "Model" ? renamed(values) : std::string(values);
    put_word(start + 2 * word_, out_.size() - start - (properties - begin));
    const Place inside = place == Place::top && name == "Objects" ? Place::objects : Place::other;
    at = properties + size;
    while (at < end && copy_record(at, end, inside, depth + 1)) {
    }
    if (at != end)
      throw CharacterError("is not whole: the record that begins at byte " + std::to_string(begin) +
                           " ends too late");
    put_word(start, out_.size());
    return true;
  }

  /// A node's properties: its number (L), its name and its class (S), each after a letter.
  std::string renamed(std::string_view values) {
    constexpr std::size_t kNumber = 1 + 8, kString = 1 + 4;
    if (values.size() < kNumber + kString || values[0] != 'L' || values[kNumber] != 'S')
      return std::string(values);
    const std::size_t size = number_at<std::uint32_t>(values, kNumber + 1);
    const std::size_t first = kNumber + kString, next = first + size;
    if (next > values.size() - kString || values[next] != 'S') return std::string(values);
    const std::string_view full = values.substr(first, size);
    const std::string_view node_class =
        values.substr(next + kString, number_at<std::uint32_t>(values, next + 1));
    if (!full.ends_with(kKind) || node_class != "LimbNode") return std::string(values);
    const std::string_view name = full.substr(0, size - kKind.size());
    std::string own(name);
    for (int count = 1; !taken_.insert(own).second; ++count) {
      std::string digits = std::to_string(count);
      digits.insert(0, 3 - std::min<std::size_t>(digits.size(), 3), '0');
      own = std::string(name) + "." + digits;
    }
    own += kKind;
    const auto length = static_cast<std::uint32_t>(own.size());
    std::string out(values.substr(0, kNumber + 1));
    out.append(reinterpret_cast<const char*>(&length), sizeof length);
    return out + own + std::string(values.substr(next));
  }

  const std::string_view in_;
  const std::size_t word_;
  std::string out_;
  std::set<std::string, std::less<>> taken_;
};

}  // namespace

std::optional<std::string> with_unique_joint_names(const std::string& fbx) {
  if (!fbx.starts_with(kMagic) || number_at<std::uint32_t>(fbx, kMagic.size()) < kFirstVersion)
    return std::nullopt;
  return Renaming(fbx).run();
}

}  // namespace backbend::import
