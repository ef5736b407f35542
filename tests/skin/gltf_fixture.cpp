#include "tests/skin/gltf_fixture.h"

#include <fstream>
#include <stdexcept>

namespace backbend::skin {

using nlohmann::json;

void write_file(const std::filesystem::path& file, const std::vector<std::uint8_t>& bytes) {
  std::ofstream stream(file, std::ios::binary);
  stream.write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
  if (!stream) throw std::runtime_error("cannot write " + file.string());
}

json& GltfFixture::attributes(int mesh, int primitive) {
  return root["meshes"][static_cast<std::size_t>(mesh)]["primitives"]
             [static_cast<std::size_t>(primitive)]["attributes"];
}

std::vector<std::uint8_t> GltfFixture::glb() const {
  json whole = root;
  if (!whole.contains("buffers")) whole["buffers"] = {{{"byteLength", buffer.size()}}};
  std::string text = whole.dump();
  while (text.size() % 4 != 0) text += ' ';
  std::vector<std::uint8_t> binary = buffer;
  while (binary.size() % 4 != 0) binary.push_back(0);

  std::vector<std::uint8_t> out;
  const auto put = [&](std::size_t value) {
    for (int shift = 0; shift < 32; shift += 8)
      out.push_back(static_cast<std::uint8_t>(value >> shift & 0xFF));
  };
  put(0x46546C67);
  put(2);
  put(12 + 8 + text.size() + 8 + binary.size());
  put(text.size());
  put(0x4E4F534A);
  out.insert(out.end(), text.begin(), text.end());
  put(binary.size());
  put(0x004E4942);
  out.insert(out.end(), binary.begin(), binary.end());
  return out;
}

std::filesystem::path GltfFixture::write_glb(const TemporaryFolder& folder,
                                             const std::string& name) const {
  write_file(folder / name, glb());
  return folder / name;
}

std::filesystem::path GltfFixture::write_gltf(const TemporaryFolder& folder,
                                              const std::string& uri) const {
  json whole = root;
  if (!whole.contains("buffers"))
    whole["buffers"] = {{{"byteLength", buffer.size()}, {"uri", uri.empty() ? "test.bin" : uri}}};
  write_file(folder / "test.bin", buffer);
  const std::string text = whole.dump();
  write_file(folder / "test.gltf", {text.begin(), text.end()});
  return folder / "test.gltf";
}

GltfFixture strip() {
  GltfFixture file;
  file.root = {{"asset", {{"version", "2.0"}}},
               {"scene", 0},
               {"scenes", {{{"nodes", {0, 2}}}}},
               {"nodes",
                {{{"name", "hip"}, {"children", {1}}},
                 {{"name", "chest"}, {"translation", {0.0, 1.0, 0.0}}},
                 {{"name", "body"}, {"mesh", 0}, {"skin", 0}}}}};
  std::vector<float> position, normal, uv, weights;
  std::vector<std::uint8_t> joints;
  for (int row = 0; row < 5; ++row)
    for (int side = 0; side < 2; ++side) {
      position.insert(position.end(), {side - 0.5f, 0.5f * static_cast<float>(row), 0.0f});
      normal.insert(normal.end(), {0.0f, 0.0f, 1.0f});
      uv.insert(uv.end(), {static_cast<float>(side), 0.25f * static_cast<float>(row)});
      const float chest = 0.25f * static_cast<float>(row);
      weights.insert(weights.end(), {1.0f - chest, chest, 0.0f, 0.0f});
      joints.insert(joints.end(), {0, 1, 0, 0});
    }
  std::vector<std::uint16_t> index;
  for (std::uint16_t row = 0; row < 4; ++row) {
    const auto a = static_cast<std::uint16_t>(2 * row);
    for (const int k : {0, 1, 2, 2, 1, 3}) index.push_back(static_cast<std::uint16_t>(a + k));
  }
  std::vector<float> bind(32, 0.0f);
  for (int k = 0; k < 4; ++k) bind[static_cast<std::size_t>(5 * k)] = 1.0f;
  for (int k = 0; k < 4; ++k) bind[static_cast<std::size_t>(16 + 5 * k)] = 1.0f;
  bind[16 + 13] = -1.0f;  // chest: one unit down

  const int p = file.add(position, kFloat, "VEC3", 3), n = file.add(normal, kFloat, "VEC3", 3),
            t = file.add(uv, kFloat, "VEC2", 2), w = file.add(weights, kFloat, "VEC4", 4),
            j = file.add(joints, kUnsignedByte, "VEC4", 4),
            i = file.add(index, kUnsignedShort, "SCALAR", 1),
            b = file.add(bind, kFloat, "MAT4", 16);
  file.root["meshes"] = {
      {{"name", "strip"},
       {"primitives",
        {{{"attributes",
           {{"POSITION", p}, {"NORMAL", n}, {"TEXCOORD_0", t}, {"WEIGHTS_0", w}, {"JOINTS_0", j}}},
          {"indices", i}}}}}};
  file.root["skins"] = {{{"joints", {0, 1}}, {"inverseBindMatrices", b}}};
  return file;
}

}  // namespace backbend::skin
