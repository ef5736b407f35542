#include "validate/evidence/heat_picture.h"

#include "render/image/heat_map.h"
#include "render/review/mark.h"
#include "render/review/sheet.h"
#include "render/trace/projection.h"
#include "skin/gltf/glb_writer.h"
#include "validate/evidence/page_mesh.h"
#include "validate/text/escape.h"

namespace backbend::validate {
namespace {

/// Distances are shown on one scale, % of height.
constexpr float kFarthest = 10.0f;
/// The ring around a place, of the picture's height.
constexpr double kMark = 0.05;
/// Meshes travel inside the page: none with more vertices.
constexpr std::size_t kMostMeshVertices = 200000;

}  // namespace

VertexHeat distance_heat(const PosedCharacter& body, const PosedCharacter& other, double height,
                         const std::string& label) {
  VertexHeat heat{label + ", % of height", "% of height", 0.0f, kFarthest, {}};
  for (std::size_t v = 0; v < body.mesh.position.size(); ++v)
    heat.value.push_back(static_cast<float>(
        100.0 * glm::distance(body.mesh.position[v], other.mesh.position[v]) / height));
  return heat;
}

render::Picture heat_picture(Photographer& photographer, render::Settings settings,
                             const PosedCharacter& body, const VertexHeat& heat,
                             const render::Camera& camera, const std::optional<glm::dvec3>& mark) {
  photographer.pose(body, heat.value);  // looked at until it is shot
  settings.mode = render::Mode::heat;
  settings.mattes = false;
  settings.heat_low = heat.low;
  settings.heat_high = heat.high;
  render::Picture drawn = render::picture_from(photographer.shoot(camera, settings));
  if (mark) {
    const glm::dvec3 at =
        render::project_camera(camera, settings.width, settings.height).project(*mark);
    if (at.z > 0.0) render::draw_mark(drawn, at.x, at.y, kMark * settings.height);
  }
  render::draw_legend(drawn, heat.low, heat.high, heat.label);
  return drawn;
}

void write_posed_glb(const OutputFolder& folder, const std::string& place,
                     const skin::Character& character, const PosedCharacter& body,
                     const VertexHeat& heat) {
  std::vector<glm::vec3> color;
  for (const float value : heat.value)
    color.push_back(render::heat_color((value - heat.low) / (heat.high - heat.low)));
  folder.write(place + "/pose.glb", skin::encode_posed_glb(character, body.mesh, color));
}

void add_page_mesh(const OutputFolder& folder, const std::string& place, const std::string& title,
                   const skin::Character& character, const PosedCharacter& body,
                   const VertexHeat& heat, const std::string& view,
                   const std::optional<glm::dvec3>& mark, int finding, Report& report) {
  if (heat.value.size() > kMostMeshVertices) return;
  const std::string triangles = "meshes/" + file_word(character.name) + ".triangles";
  folder.write(triangles, encode_mesh_triangles(character.triangles,
                                                static_cast<std::uint32_t>(heat.value.size())));
  folder.write(place + "/mesh.pose",
               encode_mesh_pose(body.mesh.position, heat.value, heat.low, heat.high));
  MeshView mesh{title,     place + "/mesh.pose",
                triangles, heat.label,
                heat.unit, heat.low,
                heat.high, finding,
                view,      {}};
  if (mark) mesh.mark = {mark->x, mark->y, mark->z};
  report.meshes.push_back(std::move(mesh));
}

}  // namespace backbend::validate
