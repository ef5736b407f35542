#pragma once
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string_view>

#include "skin/character/character.h"

namespace backbend::import {

/// A binary FBX from version 7 on, a tree of records. A record is its end, its number of properties
/// and their size (4 bytes each, 8 since version 7.5), a name, the properties and other records; an
/// empty one ends a list.
class FbxRecords {
 public:
  struct Record {
    std::size_t begin = 0, properties = 0, children = 0, end = 0;  // places in the file
    std::string_view name, values;                                 // values: of the properties
    bool ends_list = false;  // empty: the list goes on at no place, and ends at `end`
  };

  /// Whether the bytes are such a file; text and older versions are not.
  static bool are_in(std::string_view bytes);
  explicit FbxRecords(std::string_view bytes);  // needs are_in()

  std::size_t first() const { return first_; }
  std::size_t word() const { return word_; }  // bytes of an end and of a size
  /// The record at a place, in a list that ends at `limit`, below `depth` others. Throws
  /// skin::CharacterError where it reaches beyond the file or beyond what holds it.
  Record at(std::size_t place, std::size_t limit, int depth) const;

 private:
  std::uint64_t word_at(std::size_t at) const;

  std::string_view bytes_;
  std::size_t first_, word_;
};

/// Throws skin::CharacterError where the bytes end before.
template <class T>
T number_at(std::string_view bytes, std::size_t at) {
  if (at > bytes.size() || sizeof(T) > bytes.size() - at)
    throw skin::CharacterError("is cut short: a record reaches beyond the file's end");
  T out;  // little-endian, as the program's machines are
  std::memcpy(&out, bytes.data() + at, sizeof out);
  return out;
}

/// The properties of a Model record, a node: a number (L), a name and a class (S).
struct FbxNode {
  std::string_view name, node_class;
  std::size_t name_at = 0, name_end = 0;  // of the string property, its letter included
};
/// Of none where the properties are others.
FbxNode fbx_node(std::string_view values);

}  // namespace backbend::import
