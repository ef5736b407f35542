#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace tinygltf {
class Model;
}

namespace backbend::skin {

/// Reads the accessors of a parsed glTF file: every offset, stride, count and type is checked in
/// 64-bit arithmetic before a byte is touched or an array is made.
///
/// Interleaved, sparse (with or without a base), normalised and quantised accessors are decoded as
/// glTF 2.0 section 3.6.2 says. All errors are CharacterError: `file: /accessors/5/...: cause`.
class GltfAccessors {
 public:
  /// `file` heads every error; `model` must outlive this.
  GltfAccessors(const tinygltf::Model& model, std::string file);

  /// Elements in an accessor; `place` is the JSON path of the reference, for errors.
  std::size_t count(int accessor, const std::string& place) const;

  /// The decoded components, element after element: count x `components` numbers (1..4, or 16 for
  /// matrices, column by column). Refuses numbers that are not finite.
  std::vector<float> numbers(int accessor, int components, const std::string& place) const;

  /// The integers of an unsigned accessor that is not normalised: count x `components`.
  std::vector<std::uint32_t> integers(int accessor, int components, const std::string& place) const;

  /// Half the step of a normalised component, 0 for float: what a stored weight may be off by.
  double quantisation_slack(int accessor, const std::string& place) const;

 private:
  struct Source;
  Source open(int accessor, int components, const std::string& place) const;
  template <typename Value, typename Decode>
  std::vector<Value> gather(const Source& source, Decode decode) const;

  const tinygltf::Model& model_;
  std::string file_;
};

}  // namespace backbend::skin
