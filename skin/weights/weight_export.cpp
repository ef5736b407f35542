#include "skin/weights/weight_export.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

namespace backbend::skin {
namespace {

using Index = std::size_t;
using nlohmann::ordered_json;

/// A mesh as other programs have it: vertices of the character in their order.
struct ExportedMesh {
  std::string name;
  std::vector<std::uint32_t> vertex;
};

/// `Body` of `Body.0`, the first of a mesh's several primitives.
std::string mesh_of_part(const Character& character, Index part) {
  const std::string& name = character.parts[part].name;
  const Index dot = name.rfind('.');
  if (dot == std::string::npos) return name;
  const std::string stem = name.substr(0, dot);
  const auto is = [&](Index other, int number) {
    return other < character.parts.size() &&
           character.parts[other].name == stem + "." + std::to_string(number);
  };
  int number = -1;
  const auto [end, error] =
      std::from_chars(name.data() + dot + 1, name.data() + name.size(), number);
  if (error != std::errc{} || end != name.data() + name.size() || number < 0) return name;
  const bool in_row = number > 0 ? part > 0 && is(part - 1, number - 1) : is(part + 1, 1);
  return in_row ? stem : name;
}

std::vector<ExportedMesh> meshes_of(const Character& character) {
  std::vector<ExportedMesh> out;
  for (Index p = 0; p < character.parts.size(); ++p) {
    const Part& part = character.parts[p];
    const std::string mesh = mesh_of_part(character, p);
    const bool goes_on =
        mesh != part.name && !out.empty() && out.back().name == mesh && !part.name.ends_with(".0");
    if (!goes_on) out.push_back({mesh, {}});
    std::vector<bool> used(part.vertex_count, false);
    for (Index t = part.first_triangle; t < part.first_triangle + part.triangle_count; ++t)
      for (int k = 0; k < 3; ++k) used[character.triangles[t][k] - part.first_vertex] = true;
    for (std::uint32_t v = 0; v < part.vertex_count; ++v)
      if (used[v]) out.back().vertex.push_back(part.first_vertex + v);
  }
  return out;
}

const std::string& joint_name(const Character& character, std::uint16_t joint) {
  return character.nodes[static_cast<Index>(character.joints[joint].node)].name;
}

/// Weights to six places, as text or number.
double rounded(float weight) { return std::round(1e6 * static_cast<double>(weight)) / 1e6; }

std::string decimal(double value) {
  char text[64];
  const auto end = std::to_chars(text, text + sizeof text, value, std::chars_format::fixed, 6).ptr;
  return {text, end};
}

/// By joint: the numbers and weights of the vertices of a mesh that it moves. Vertices without any
/// weight are left out.
std::map<std::string, std::vector<std::pair<Index, float>>> by_joint(const WeightExport& from,
                                                                     const ExportedMesh& mesh) {
  std::map<std::string, std::vector<std::pair<Index, float>>> out;
  for (Index i = 0; i < mesh.vertex.size(); ++i) {
    const std::uint32_t v = mesh.vertex[i];
    const bool has_none =
        !from.changed[v] &&
        std::binary_search(from.character.unweighted.begin(), from.character.unweighted.end(), v);
    if (has_none) continue;
    const Influences& influences = from.influences[v];
    for (Index k = 0; k < kMaxInfluences && influences.weight[k] > 0.0f; ++k) {
      auto& list = out[joint_name(from.character, influences.joint[k])];
      if (!list.empty() && list.back().first == i)
        list.back().second += influences.weight[k];
      else
        list.emplace_back(i, influences.weight[k]);
    }
  }
  return out;
}

std::string xml_text(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        // Other control characters cannot stand in XML at all.
        out += static_cast<unsigned char>(c) < 0x20 ? '_' : c;
    }
  }
  return out;
}

}  // namespace

std::string maya_weights_xml(const WeightExport& from) {
  std::string out = "<?xml version=\"1.0\"?>\n<deformerWeight>\n  <headerInfo fileName=\"" +
                    xml_text(from.character.file_name) +
                    "\" worldMatrix=\"1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\"/>\n";
  const std::vector<ExportedMesh> meshes = meshes_of(from.character);
  for (const ExportedMesh& mesh : meshes) {
    const std::string size = std::to_string(mesh.vertex.size());
    out += "  <shape name=\"" + xml_text(mesh.name) + "Shape\" group=\"0\" stride=\"3\" size=\"" +
           size + "\" max=\"" + size + "\">\n";
    for (Index i = 0; i < mesh.vertex.size(); ++i) {
      const glm::vec3& p = from.character.bind_position[mesh.vertex[i]];
      out += "    <point index=\"" + std::to_string(i) + "\" value=\"" + decimal(p.x) + " " +
             decimal(p.y) + " " + decimal(p.z) + "\"/>\n";
    }
    out += "  </shape>\n";
  }
  for (const ExportedMesh& mesh : meshes) {
    Index layer = 0;
    for (const auto& [joint, weights] : by_joint(from, mesh)) {
      out += "  <weights deformer=\"" + xml_text(mesh.name) + "_skinCluster\" source=\"" +
             xml_text(joint) + "\" shape=\"" + xml_text(mesh.name) + "Shape\" layer=\"" +
             std::to_string(layer++) + "\" defaultValue=\"0.000\" size=\"" +
             std::to_string(weights.size()) + "\" max=\"" + std::to_string(mesh.vertex.size()) +
             "\">\n";
      for (const auto& [index, weight] : weights)
        out += "    <point index=\"" + std::to_string(index) + "\" value=\"" +
               decimal(rounded(weight)) + "\"/>\n";
      out += "  </weights>\n";
    }
  }
  return out + "</deformerWeight>\n";
}

std::string weights_json(const WeightExport& from) {
  ordered_json root = {{"schema", "backbend.weights/1"},
                       {"file", from.character.file_name},
                       {"objs", ordered_json::array()},
                       {"objDDic", ordered_json::array()},
                       {"bypassObj", ordered_json::array()}};
  for (const ExportedMesh& mesh : meshes_of(from.character)) {
    ordered_json weights = ordered_json::object(), positions = ordered_json::array(),
                 changed = ordered_json::array();
    for (const auto& [joint, list] : by_joint(from, mesh)) {
      ordered_json& of_joint = weights[joint];
      for (const auto& [index, weight] : list) of_joint[std::to_string(index)] = rounded(weight);
    }
    for (Index i = 0; i < mesh.vertex.size(); ++i) {
      const glm::vec3& p = from.character.bind_position[mesh.vertex[i]];
      positions.push_back({p.x, p.y, p.z});
      if (from.changed[mesh.vertex[i]]) changed.push_back(i);
    }
    root["objs"].push_back(mesh.name);
    root["objDDic"].push_back({{"objName", mesh.name},
                               {"nameSpace", ""},
                               {"skinClsName", mesh.name + "_skinCluster"},
                               {"skinningMethod", 0},
                               {"normalizeWeights", 1},
                               {"vertexCount", mesh.vertex.size()},
                               {"weights", std::move(weights)},
                               {"blendWeights", ordered_json::object()},
                               {"changed", std::move(changed)},
                               {"positions", std::move(positions)}});
  }
  return root.dump(-1, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

std::string blender_weights_script(const WeightExport& from) {
  ordered_json meshes = ordered_json::array();
  for (const ExportedMesh& mesh : meshes_of(from.character)) {
    ordered_json vertices = ordered_json::array();
    for (Index i = 0; i < mesh.vertex.size(); ++i) {
      const std::uint32_t v = mesh.vertex[i];
      if (!from.changed[v]) continue;
      ordered_json weights = ordered_json::array();
      const Influences& influences = from.influences[v];
      for (Index k = 0; k < kMaxInfluences && influences.weight[k] > 0.0f; ++k)
        weights.push_back(
            {joint_name(from.character, influences.joint[k]), rounded(influences.weight[k])});
      const glm::vec3& p = from.character.bind_position[v];
      vertices.push_back({i, {p.x, p.y, p.z}, std::move(weights)});
    }
    if (!vertices.empty())
      meshes.push_back(
          {{"name", mesh.name}, {"count", mesh.vertex.size()}, {"vertices", std::move(vertices)}});
  }
  // JSON inside a Python string: two levels of escapes, and only ASCII.
  const std::string data = meshes.dump(-1, ' ', true, ordered_json::error_handler_t::replace);
  std::string quoted;
  for (const char c : data) {
    if (c == '\\' || c == '\'') quoted += '\\';
    quoted += c;
  }
  return R"PY(# Sets the repaired weights of a character as vertex groups: run it in Blender's text editor, or
# blender FILE.blend --background --python THIS --python-expr "import bpy; bpy.ops.wm.save_mainfile()"
#
# A mesh with as many vertices as the repaired file's is set by vertex number. Another one (vertices
# merged or split since) is set by place, where nine in ten of the changed vertices have one within
# a ten-thousandth of the mesh's size; otherwise it is left alone.
import json

import bpy
import mathutils

MESHES = json.loads(')PY" +
         quoted + R"PY(')


def objects_named(name):
    """Mesh objects of this name, of the object or of its data; `.001` and the like count."""
    def stem(text):
        head, _, tail = text.rpartition(".")
        return head if head and tail.isdigit() and len(tail) == 3 else text

    found = [o for o in bpy.data.objects if o.type == "MESH"]
    exact = [o for o in found if name in (o.data.name, o.name)]
    return exact or [o for o in found if stem(o.data.name) == name or stem(o.name) == name]


def numbers_by_place(mesh, vertices):
    """For each changed vertex those of the mesh at its place; how many have any."""
    tree = mathutils.kdtree.KDTree(len(mesh.vertices))
    for vertex in mesh.vertices:
        tree.insert(vertex.co, vertex.index)
    tree.balance()
    low = [min(v.co[k] for v in mesh.vertices) for k in range(3)]
    high = [max(v.co[k] for v in mesh.vertices) for k in range(3)]
    reach = 1e-4 * max(h - l for l, h in zip(low, high))
    out = []
    for _, (x, y, z), _ in vertices:  # glTF has Y up, Blender Z
        out.append([index for _, index, _ in tree.find_range((x, -z, y), reach)])
    return out, sum(1 for numbers in out if numbers)


def set_weights(obj, entry):
    vertices = entry["vertices"]
    if len(obj.data.vertices) == entry["count"]:
        numbers, how = [[index] for index, _, _ in vertices], "by vertex number"
    else:
        numbers, covered = numbers_by_place(obj.data, vertices)
        share = covered / len(vertices)
        how = "by place, %.1f %% covered" % (100.0 * share)
        if share < 0.9:
            print("%s: left alone: it has %d vertices, the file %d, and only %.1f %% of the changed "
                  "ones have a place here" % (obj.name, len(obj.data.vertices), entry["count"],
                                              100.0 * share))
            return 0
    changed = sorted({index for each in numbers for index in each})
    for group in obj.vertex_groups:
        if not group.lock_weight:
            group.remove(changed)
    for each, (_, _, weights) in zip(numbers, vertices):
        for joint, weight in weights:
            group = obj.vertex_groups.get(joint) or obj.vertex_groups.new(name=joint)
            group.add(each, weight, "REPLACE")
    print("%s: weights of %d vertices set, %s" % (obj.name, len(changed), how))
    return len(changed)


def main():
    if bpy.context.mode != "OBJECT":
        bpy.ops.object.mode_set(mode="OBJECT")
    for entry in MESHES:
        objects = objects_named(entry["name"])
        if not objects:
            print("no mesh is called %r" % entry["name"])
        for obj in objects:
            set_weights(obj, entry)


main()
)PY";
}

}  // namespace backbend::skin
