#include "cli/import/fbx_geometry.h"

#include <algorithm>
#include <cstring>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/trigonometric.hpp>
#include <optional>
#include <string_view>
#include <vector>

#include "cli/import/fbx_records.h"

namespace backbend::import {
namespace {

/// The vector of a property that is one: four strings, the first its name, and three numbers (D),
/// each after a letter.
struct Property {
  std::string_view name;
  glm::dvec3 value;
  std::size_t at = 0;  // of the first number's letter
};

constexpr std::size_t kNumber = 1 + sizeof(double);

std::optional<Property> vector_in(std::string_view values) {
  Property out{};
  std::size_t at = 0;
  for (int text = 0; text < 4; ++text) {
    if (at >= values.size() || values[at] != 'S') return std::nullopt;
    const std::size_t size = number_at<std::uint32_t>(values, at + 1);
    const std::size_t begin = at + 1 + sizeof(std::uint32_t);
    if (size > values.size() || begin > values.size() - size) return std::nullopt;
    if (text == 0) out.name = values.substr(begin, size);
    at = begin + size;
  }
  out.at = at;
  for (int axis = 0; axis < 3; ++axis, at += kNumber) {
    if (at >= values.size() || values[at] != 'D') return std::nullopt;
    out.value[axis] = number_at<double>(values, at + 1);
  }
  return out;
}

/// Visits the records of a list.
template <class Visit>
void each(const FbxRecords& records, std::size_t at, std::size_t end, int depth,
          const Visit& visit) {
  while (at < end) {
    const FbxRecords::Record record = records.at(at, end, depth);
    if (record.ends_list) return;
    visit(record);
    at = record.end;
  }
}

/// One of a transform's three vectors in a file, and what leaves a mesh where it is.
struct Part {
  std::size_t at;  // in the file
  double identity;
};

struct Geometric {
  std::vector<Part> part;
  glm::dmat4 matrix{1.0};
};

/// Scaled, turned about X, Y and Z in that order, then moved.
Geometric geometric_of(const FbxRecords& records, const FbxRecords::Record& node) {
  Geometric out;
  glm::dvec3 moved(0.0), turned(0.0), scaled(1.0);
  each(records, node.children, node.end, 2, [&](const FbxRecords::Record& list) {
    if (list.name != "Properties70") return;
    each(records, list.children, list.end, 3, [&](const FbxRecords::Record& one) {
      const std::optional<Property> property = vector_in(one.values);
      if (!property) return;
      const auto take = [&](std::string_view name, double identity, glm::dvec3& into) {
        if (property->name != name) return;
        into = property->value;
        out.part.push_back({one.properties + property->at, identity});
      };
      take("GeometricTranslation", 0.0, moved);
      take("GeometricRotation", 0.0, turned);
      take("GeometricScaling", 1.0, scaled);
    });
  });
  out.matrix = glm::translate(out.matrix, moved);
  for (const int axis : {2, 1, 0}) {
    glm::dvec3 about(0.0);
    about[axis] = 1.0;
    out.matrix = glm::rotate(out.matrix, glm::radians(turned[axis]), about);
  }
  out.matrix = glm::scale(out.matrix, scaled);
  return out;
}

using MeshNodes = std::map<std::string, std::vector<Geometric>, std::less<>>;

MeshNodes mesh_nodes_of(std::string_view fbx) {
  MeshNodes nodes;
  const FbxRecords records(fbx);
  each(records, records.first(), fbx.size(), 0, [&](const FbxRecords::Record& top) {
    if (top.name != "Objects") return;
    each(records, top.children, top.end, 1, [&](const FbxRecords::Record& object) {
      const FbxNode node = object.name == "Model" ? fbx_node(object.values) : FbxNode();
      if (node.node_class == "Mesh")
        nodes[std::string(node.name)].push_back(geometric_of(records, object));
    });
  });
  return nodes;
}

}  // namespace

GeometricTransforms take_geometric_transforms(std::string& fbx) {
  GeometricTransforms out;
  if (!FbxRecords::are_in(fbx)) return out;
  MeshNodes nodes;
  try {
    nodes = mesh_nodes_of(fbx);
  } catch (const skin::CharacterError&) {
    return out;
  }
  for (const auto& [name, all] : nodes) {
    const glm::dmat4& matrix = all.front().matrix;
    if (matrix == glm::dmat4(1.0) ||
        !std::ranges::all_of(all, [&](const Geometric& one) { return one.matrix == matrix; }))
      continue;
    out[name] = matrix;
    for (const Geometric& one : all)
      for (const Part& part : one.part)
        for (std::size_t axis = 0; axis < 3; ++axis)
          std::memcpy(fbx.data() + part.at + axis * kNumber + 1, &part.identity, sizeof(double));
  }
  return out;
}

}  // namespace backbend::import
