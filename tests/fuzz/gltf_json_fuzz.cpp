// A .gltf whose buffers stand in it as base64.
#include <nlohmann/json.hpp>

#include "tests/fuzz/gltf_use.h"
#include "tests/skin/gltf_fixture.h"

namespace backbend::fuzz {
namespace {

bool run(Input input) {
  // What starts as a GLB is the target glb's.
  if (text_of(input).starts_with("glTF")) return false;
  return use_gltf({input.begin(), input.end()});
}

std::string base64(const Bytes& bytes) {
  constexpr std::string_view digits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  for (std::size_t at = 0; at < bytes.size(); at += 3) {
    std::uint32_t three = 0;
    for (std::size_t k = 0; k < 3; ++k)
      three = three << 8 | (at + k < bytes.size() ? bytes[at + k] : 0u);
    for (std::size_t k = 0; k < 4; ++k)
      out += at + k > bytes.size() ? '=' : digits[three >> (18 - 6 * k) & 63];
  }
  return out;
}

std::vector<Bytes> seeds() {
  skin::GltfFixture file = skin::strip();
  file.root["buffers"] = {{{"byteLength", file.buffer.size()},
                           {"uri", "data:application/octet-stream;base64," + base64(file.buffer)}}};
  return {bytes_of(file.root.dump())};
}

const Registration registration{{"gltf_json", run, seeds, gltf_words(), 8192}};

}  // namespace
}  // namespace backbend::fuzz
