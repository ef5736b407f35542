// glTF's accessors, views and skins over one fixed buffer: the JSON is what is tried.
#include <nlohmann/json.hpp>

#include "tests/fuzz/gltf_use.h"
#include "tests/skin/gltf_fixture.h"

namespace backbend::fuzz {
namespace {

bool run(Input input) {
  static const Bytes buffer = skin::strip().buffer;
  return use_gltf(glb_of(std::string(text_of(input)), buffer));
}

std::vector<Bytes> seeds() {
  using nlohmann::json;
  skin::GltfFixture file = skin::strip();
  file.root["buffers"] = {{{"byteLength", file.buffer.size()}}};
  std::vector<Bytes> out{bytes_of(file.root.dump())};
  // Views that are interleaved, sparse values over a view and over nothing.
  json sparse = file.root;
  sparse["accessors"][0]["sparse"] = {
      {"count", 2},
      {"indices", {{"bufferView", 5}, {"byteOffset", 2}, {"componentType", 5123}}},
      {"values", {{"bufferView", 1}}}};
  out.push_back(bytes_of(sparse.dump()));
  sparse["accessors"][1].erase("bufferView");
  sparse["bufferViews"][0]["byteStride"] = 12;
  sparse["meshes"][0]["primitives"][0]["targets"] = {{{"POSITION", 1}}};
  sparse["meshes"][0]["weights"] = {0.5};
  out.push_back(bytes_of(sparse.dump()));
  json moving = file.root;
  moving["accessors"].push_back(
      {{"bufferView", 0}, {"componentType", 5126}, {"type", "SCALAR"}, {"count", 1}});
  moving["animations"] = {
      {{"samplers", {{{"input", 7}, {"output", 7}, {"interpolation", "STEP"}}}},
       {"channels", {{{"sampler", 0}, {"target", {{"node", 1}, {"path", "weights"}}}}}}}};
  out.push_back(bytes_of(moving.dump()));
  return out;
}

const Registration registration{{"accessors", run, seeds, gltf_words(), 4096}};

}  // namespace
}  // namespace backbend::fuzz
