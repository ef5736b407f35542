#include "skin/gltf/usd_writer.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/packing.hpp>

#include "skin/gltf/rigid_parts.h"
#include "skin/gltf/usd_names.h"
#include "skin/gltf/usd_skeleton.h"
#include "skin/gltf/written_influences.h"

namespace backbend::skin {
namespace {

constexpr const char* kCharacterPath = "/Root/Character";

/// Lines of USD's text form; what stands between braces is indented.
class UsdLines {
 public:
  void line(const std::string& text) {
    text_.append(static_cast<std::size_t>(depth_) * 4, ' ');
    text_ += text + "\n";
  }
  /// `def TYPE "NAME" (META)`, and its brace.
  void open(const std::string& head, const std::vector<std::string>& meta = {}) {
    line(meta.empty() ? head : head + " (");
    if (!meta.empty()) {
      ++depth_;
      for (const std::string& each : meta) line(each);
      --depth_;
      line(")");
    }
    begin("{");
  }
  /// A line whose last character is a brace.
  void begin(const std::string& text) {
    line(text);
    ++depth_;
  }
  void close() {
    --depth_;
    line("}");
  }
  std::string take() { return std::move(text_); }

 private:
  std::string text_;
  int depth_ = 0;
};

template <typename T>
std::string number(T value) {
  char buffer[32];
  const auto [end, error] = std::to_chars(buffer, buffer + sizeof buffer, value);
  return {buffer, end};
}

std::string tuple(const glm::vec2& v) { return "(" + number(v.x) + ", " + number(v.y) + ")"; }
std::string tuple(const glm::vec3& v) {
  return "(" + number(v.x) + ", " + number(v.y) + ", " + number(v.z) + ")";
}
std::string tuple(const glm::quat& q) {
  return "(" + number(q.w) + ", " + number(q.x) + ", " + number(q.y) + ", " + number(q.z) + ")";
}
/// USD multiplies row vectors: its rows are our columns.
std::string tuple(const glm::dmat4& m) {
  std::string text = "( ";
  for (int c = 0; c < 4; ++c)
    text += std::string(c == 0 ? "" : ", ") + "(" + number(m[c][0]) + ", " + number(m[c][1]) +
            ", " + number(m[c][2]) + ", " + number(m[c][3]) + ")";
  return text + " )";
}

template <typename Items, typename Text>
std::string list(const Items& items, const Text& text_of) {
  std::string text = "[";
  for (const auto& item : items) {
    if (text.size() > 1) text += ", ";
    text += text_of(item);
  }
  return text + "]";
}
template <typename T>
std::string tuples(const std::vector<T>& items) {
  return list(items, [](const T& item) { return tuple(item); });
}
template <typename T>
std::string numbers(const std::vector<T>& items) {
  return list(items, [](T item) { return number(item); });
}
std::string strings(const std::vector<std::string>& items) {
  return list(items, [](const std::string& item) { return usd_string(item); });
}

void add_skeleton(UsdLines& lines, const UsdSkeleton& skeleton) {
  lines.line("uniform token[] joints = " + strings(skeleton.path));
  lines.line("uniform token[] jointNames = " + strings(skeleton.name));
  lines.line("uniform matrix4d[] bindTransforms = " + tuples(skeleton.bind));
  lines.line("uniform matrix4d[] restTransforms = " +
             list(skeleton.rest, [](const NodeTransform& t) { return tuple(matrix_of(t)); }));
  lines.line("rel skel:animationSource = <" + std::string(kCharacterPath) + "/Skeleton/Motion>");
}

/// The samples of one attribute: one value where every frame has the same.
void add_samples(UsdLines& lines, const std::string& attribute, int first_frame,
                 const std::vector<std::string>& value) {
  if (std::ranges::all_of(value, [&](const std::string& v) { return v == value.front(); })) {
    lines.line(attribute + " = " + value.front());
    return;
  }
  lines.begin(attribute + ".timeSamples = {");
  for (std::size_t f = 0; f < value.size(); ++f)
    lines.line(std::to_string(first_frame + static_cast<int>(f)) + ": " + value[f] + ",");
  lines.close();
}

/// A scale as UsdSkel holds it, in half precision.
glm::vec3 half_scale(const glm::dvec3& scale, UsdText& out) {
  glm::vec3 rounded(1.0f);
  for (int c = 0; c < 3; ++c) {
    rounded[c] = glm::unpackHalf1x16(glm::packHalf1x16(static_cast<float>(scale[c])));
    const double error = std::abs(rounded[c] / scale[c] - 1.0);
    // Half precision keeps 11 bits; far less than that is the rounding of the matrices themselves.
    if (error > 1e-7) ++out.rounded_scales;
    out.worst_scale_error = std::max(out.worst_scale_error, error);
  }
  return rounded;
}

void add_motion(UsdLines& lines, const UsdSkeleton& skeleton, int first_frame, UsdText& out) {
  std::vector<std::string> translations, rotations, scales;
  std::vector<glm::dquat> before;
  for (const NodeTransform& t : skeleton.rest) before.push_back(t.rotation);
  for (const std::vector<NodeTransform>& frame : skeleton.frames) {
    std::vector<glm::vec3> translation, scale;
    std::vector<glm::quat> rotation;
    for (std::size_t j = 0; j < frame.size(); ++j) {
      // q and -q are one turn; players blend the numbers, so neighbours must be close as numbers.
      const glm::dquat q = frame[j].rotation;
      before[j] = glm::dot(before[j], q) < 0.0 ? -q : q;
      translation.emplace_back(frame[j].translation);
      rotation.emplace_back(before[j]);
      scale.push_back(half_scale(frame[j].scale, out));
    }
    translations.push_back(tuples(translation));
    rotations.push_back(tuples(rotation));
    scales.push_back(tuples(scale));
  }
  lines.open("def SkelAnimation \"Motion\"");
  lines.line("uniform token[] joints = " + strings(skeleton.path));
  add_samples(lines, "float3[] translations", first_frame, translations);
  add_samples(lines, "quatf[] rotations", first_frame, rotations);
  add_samples(lines, "half3[] scales", first_frame, scales);
  lines.close();
}

template <typename T>
std::vector<T> of_part(const std::vector<T>& all, const Part& part) {
  const auto first = all.begin() + part.first_vertex;
  return {first, first + part.vertex_count};
}

void add_weights(UsdLines& lines, const std::vector<WrittenInfluences>& influences,
                 const UsdSkeleton& skeleton) {
  int most = 1;
  for (const WrittenInfluences& one : influences) most = std::max(most, one.count);
  std::vector<std::size_t> joint;
  std::vector<float> weight;
  for (const WrittenInfluences& one : influences) {
    for (std::size_t k = 0; k < static_cast<std::size_t>(most); ++k) {
      const bool used = k < static_cast<std::size_t>(one.count);
      joint.push_back(used ? skeleton.of_skin[one.joint[k]] : 0);
      weight.push_back(used ? one.weight[k] : 0.0f);
    }
  }
  const auto add = [&](const std::string& attribute) {
    lines.line(attribute + " (");
    lines.line("    elementSize = " + std::to_string(most));
    lines.line("    interpolation = \"vertex\"");
    lines.line(")");
  };
  add("int[] primvars:skel:jointIndices = " + numbers(joint));
  add("float[] primvars:skel:jointWeights = " + numbers(weight));
}

/// An attribute with one value a vertex, or one for all.
void add_primvar(UsdLines& lines, const std::string& attribute, const char* interpolation) {
  lines.line(attribute + " (");
  lines.line("    interpolation = \"" + std::string(interpolation) + "\"");
  lines.line(")");
}

void add_look(UsdLines& lines, const Character& character, const Part& part) {
  if (part.material < 0 || static_cast<std::size_t>(part.material) >= character.materials.size())
    return;
  const Material& material = character.materials[static_cast<std::size_t>(part.material)];
  add_primvar(lines,
              "color3f[] primvars:displayColor = [" + tuple(glm::vec3(material.base_color)) + "]",
              "constant");
  if (material.double_sided) lines.line("uniform bool doubleSided = 1");
}

/// Points of a part in bind space. Throws CharacterError where one is not finite.
std::vector<glm::vec3> points_of(const Character& character, const Part& part) {
  std::vector<glm::vec3> points = of_part(character.bind_position, part);
  for (std::size_t v = 0; v < points.size(); ++v) {
    if (!std::isfinite(points[v].x + points[v].y + points[v].z))
      throw CharacterError("part `" + part.name + "`: vertex " +
                           std::to_string(v + part.first_vertex) + " is not finite");
  }
  return points;
}

std::vector<glm::vec3> normals_of(const Character& character, const Part& part) {
  std::vector<glm::vec3> normals = of_part(character.bind_normal, part);
  for (glm::vec3& n : normals) {
    const float length = glm::length(n);
    n = std::isfinite(length) && length > 0.0f ? n / length : glm::vec3(0, 1, 0);
  }
  return normals;
}

void add_mesh(UsdLines& lines, const Character& character, const Part& part,
              const std::string& name, const std::vector<WrittenInfluences>& influences,
              const UsdSkeleton& skeleton) {
  const std::vector<glm::vec3> points = points_of(character, part);
  glm::vec3 low = points.front(), high = low;
  for (const glm::vec3& p : points) low = glm::min(low, p), high = glm::max(high, p);
  std::vector<std::uint32_t> corner;
  for (std::uint32_t t = part.first_triangle; t < part.first_triangle + part.triangle_count; ++t)
    for (int k = 0; k < 3; ++k) corner.push_back(character.triangles[t][k] - part.first_vertex);

  lines.open("def Mesh \"" + name + "\"", {"prepend apiSchemas = [\"SkelBindingAPI\"]"});
  lines.line("uniform token subdivisionScheme = \"none\"");
  lines.line("float3[] extent = " + tuples(std::vector{low, high}));
  lines.line("int[] faceVertexCounts = " + numbers(std::vector<int>(part.triangle_count, 3)));
  lines.line("int[] faceVertexIndices = " + numbers(corner));
  lines.line("point3f[] points = " + tuples(points));
  add_primvar(lines, "normal3f[] normals = " + tuples(normals_of(character, part)), "vertex");
  if (!character.uv.empty()) {
    std::vector<glm::vec2> uv = of_part(character.uv, part);
    for (glm::vec2& each : uv) each.y = 1.0f - each.y;  // USD counts from the lower edge
    add_primvar(lines, "texCoord2f[] primvars:st = " + tuples(uv), "vertex");
  }
  add_look(lines, character, part);
  lines.line("uniform token primvars:skel:skinningMethod = \"classicLinear\"");
  lines.line("matrix4d primvars:skel:geomBindTransform = " + tuple(skeleton.geom_bind));
  add_weights(lines, influences, skeleton);
  lines.line("rel skel:skeleton = <" + std::string(kCharacterPath) + "/Skeleton>");
  lines.close();
}

void add_meshes(UsdLines& lines, const Character& character, UniqueNames& names,
                const std::vector<WrittenInfluences>& influences, const UsdSkeleton& skeleton) {
  bool any = false;
  for (const Part& part : character.parts) {
    if (part.triangle_count == 0) continue;
    any = true;
    add_mesh(lines, character, part, names.take(usd_identifier(part.name, "Mesh")),
             of_part(influences, part), skeleton);
  }
  if (!any) throw CharacterError(character.file_name + ": no triangles to write");
}

void add_cameras(UsdLines& lines, const std::vector<UsdCamera>& cameras) {
  if (cameras.empty()) return;
  lines.open("def Scope \"Cameras\"");
  UniqueNames names;
  for (const UsdCamera& camera : cameras) {
    lines.open("def Camera \"" + names.take(usd_identifier(camera.name, "camera")) + "\"");
    lines.line("token projection = \"perspective\"");
    lines.line("float focalLength = " + number(static_cast<float>(camera.focal_mm)));
    lines.line("float horizontalAperture = " + number(static_cast<float>(camera.film_width_mm)));
    lines.line("float verticalAperture = " + number(static_cast<float>(camera.film_height_mm)));
    lines.line("float2 clippingRange = " + tuple(glm::vec2(camera.near, camera.far)));
    lines.line("matrix4d xformOp:transform = " + tuple(camera.world_from_camera));
    lines.line("uniform token[] xformOpOrder = [\"xformOp:transform\"]");
    lines.close();
  }
  lines.close();
}

void add_notes(UsdLines& lines, const std::string& scope, const std::vector<UsdNote>& notes) {
  if (notes.empty()) return;
  lines.open("def Scope \"" + usd_identifier(scope, "Notes") + "\"");
  UniqueNames names;
  for (const UsdNote& note : notes) {
    std::vector<std::string> meta = {"customData = {"};
    for (const auto& [key, text] : note.text)
      meta.push_back("    string " + key + " = " + usd_string(text));
    for (const auto& [key, value] : note.number)
      if (std::isfinite(value)) meta.push_back("    double " + key + " = " + number(value));
    meta.emplace_back("}");
    lines.open("def Scope \"" + names.take(usd_identifier(note.name, "note")) + "\"", meta);
    lines.close();
  }
  lines.close();
}

void add_header(UsdLines& lines, const UsdScene& scene, std::size_t frames) {
  lines.line("#usda 1.0");
  lines.line("(");
  lines.line("    defaultPrim = \"Root\"");
  lines.line("    doc = " + usd_string(scene.doc));
  lines.line("    endTimeCode = " +
             std::to_string(scene.first_frame + static_cast<int>(frames) - 1));
  lines.line("    framesPerSecond = " + number(scene.frames_per_second));
  lines.line("    metersPerUnit = " + number(scene.metres_per_unit));
  lines.line("    startTimeCode = " + std::to_string(scene.first_frame));
  lines.line("    timeCodesPerSecond = " + number(scene.frames_per_second));
  lines.line("    upAxis = \"" + std::string(1, scene.up) + "\"");
  lines.line(")");
  lines.line("");
}

}  // namespace

UsdText usd_text(const Character& given, const GlbAnimation& animation, const UsdScene& scene) {
  const WrittenSkin skin = written_skin(given);
  const Character character = with_rigid_parts_at_rest(given);
  const UsdSkeleton skeleton = usd_skeleton(character, animation, skin.unskinned);
  UsdText out;
  UsdLines lines;
  add_header(lines, scene, skeleton.frames.size());
  lines.open("def Xform \"Root\"", {"kind = \"component\""});
  lines.open("def SkelRoot \"Character\"",
             {"prepend apiSchemas = [\"SkelBindingAPI\"]", "customData = {",
              "    string name = " + usd_string(character.name), "}"});
  UniqueNames names;
  lines.open("def Skeleton \"" + names.take("Skeleton") + "\"",
             {"prepend apiSchemas = [\"SkelBindingAPI\"]"});
  add_skeleton(lines, skeleton);
  add_motion(lines, skeleton, scene.first_frame, out);
  lines.close();
  add_meshes(lines, character, names, skin.influences, skeleton);
  lines.close();
  add_cameras(lines, scene.cameras);
  add_notes(lines, scene.notes_name, scene.notes);
  lines.close();
  out.text = lines.take();
  return out;
}

}  // namespace backbend::skin
