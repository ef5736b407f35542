#pragma once
#include <optional>
#include <string>

#include "render/image/picture.h"
#include "render/trace/scene.h"
#include "validate/camera/photographer.h"
#include "validate/evidence/metric_heat.h"
#include "validate/files/output_folder.h"
#include "validate/model/report.h"

namespace backbend::validate {

/// How far each vertex is from where it is in another pose of the same mesh, % of `height` (in the
/// unit of the positions), on a scale from 0 to 10. `label` says what the distance is.
VertexHeat distance_heat(const PosedCharacter& body, const PosedCharacter& other, double height,
                         const std::string& label);

/// The body coloured by `heat`, with a ring around `mark` (world space) where it is in front of the
/// camera, and a legend. `settings` give size and samples.
render::Picture heat_picture(Photographer& photographer, render::Settings settings,
                             const PosedCharacter& body, const VertexHeat& heat,
                             const render::Camera& camera, const std::optional<glm::dvec3>& mark);

/// Writes `place`/pose.glb, the posed mesh with the heat as vertex colours, for any viewer.
void write_posed_glb(const OutputFolder& folder, const std::string& place,
                     const skin::Character& character, const PosedCharacter& body,
                     const VertexHeat& heat);

/// Writes the posed mesh in the page's form and adds it to the report under `title`, as it is seen
/// in `view`, with the place marked; nothing for meshes that are too large to travel inside a page.
/// `finding` is the finding's number in the report, -1 where it is not known yet.
void add_page_mesh(const OutputFolder& folder, const std::string& place, const std::string& title,
                   const skin::Character& character, const PosedCharacter& body,
                   const VertexHeat& heat, const std::string& view,
                   const std::optional<glm::dvec3>& mark, int finding, Report& report);

}  // namespace backbend::validate
