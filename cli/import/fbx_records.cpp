#include "cli/import/fbx_records.h"

#include <string>

namespace backbend::import {
namespace {

using namespace std::string_view_literals;
using skin::CharacterError;

constexpr auto kMagic = "Kaydara FBX Binary  \0\x1a\0"sv;
constexpr auto kKind = "\0\x01Model"sv;  // follows a node's name
constexpr std::uint32_t kFirstVersion = 7000, kFirstWide = 7500;
constexpr int kDeepest = 64;

}  // namespace

bool FbxRecords::are_in(std::string_view bytes) {
  return bytes.starts_with(kMagic) &&
         number_at<std::uint32_t>(bytes, kMagic.size()) >= kFirstVersion;
}

FbxRecords::FbxRecords(std::string_view bytes)
    : bytes_(bytes),
      first_(kMagic.size() + sizeof(std::uint32_t)),
      word_(number_at<std::uint32_t>(bytes, kMagic.size()) >= kFirstWide ? 8 : 4) {}

std::uint64_t FbxRecords::word_at(std::size_t at) const {
  return word_ == 8 ? number_at<std::uint64_t>(bytes_, at) : number_at<std::uint32_t>(bytes_, at);
}

FbxRecords::Record FbxRecords::at(std::size_t place, std::size_t limit, int depth) const {
  Record out;
  out.begin = place;
  const std::size_t name_at = place + 3 * word_ + 1;
  const std::uint64_t end = word_at(place), size = word_at(place + 2 * word_);
  const std::size_t name_size = number_at<std::uint8_t>(bytes_, name_at - 1);
  if (end == 0) {
    out.ends_list = true;
    out.end = name_at;
    return out;
  }
  out.properties = name_at + name_size;
  if (end > limit || out.properties > end || size > end - out.properties || depth > kDeepest)
    throw CharacterError("is not whole: a record at byte " + std::to_string(place) +
                         " does not end within what holds it");
  out.name = bytes_.substr(name_at, name_size);
  out.values = bytes_.substr(out.properties, size);
  out.children = out.properties + size;
  out.end = end;
  return out;
}

FbxNode fbx_node(std::string_view values) {
  constexpr std::size_t kNumber = 1 + 8, kString = 1 + 4;
  if (values.size() < kNumber + kString || values[0] != 'L' || values[kNumber] != 'S') return {};
  const std::size_t size = number_at<std::uint32_t>(values, kNumber + 1);
  const std::size_t first = kNumber + kString, next = first + size;
  if (next > values.size() - kString || values[next] != 'S') return {};
  const std::string_view full = values.substr(first, size);
  if (!full.ends_with(kKind)) return {};
  return {full.substr(0, size - kKind.size()),
          values.substr(next + kString, number_at<std::uint32_t>(values, next + 1)), kNumber, next};
}

}  // namespace backbend::import
