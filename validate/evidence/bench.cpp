#include "validate/evidence/bench.h"

#include "render/trace/cameras.h"
#include "validate/measure/measure.h"

namespace backbend::validate {

render::RayCost bench_rays(const RenderRequest& request, int repeats) {
  const Stage stage(load_character(request.character), request.hints, request.chain);
  const auto system = stage.build(request.rig.spec);
  const PosedCharacter posed =
      stage.pose(*system, controls_at(*system, request.pose, request.mapping));
  render::Scene scene(stage.topology());
  render::PoseGeometry geometry;
  geometry.position = posed.mesh.position;
  geometry.normal = posed.mesh.normal;
  scene.set_pose(geometry);
  const double aspect = static_cast<double>(request.settings.width) / request.settings.height;
  const render::Camera camera = render::view_camera(request.view, stage.bounds(posed.mesh),
                                                    facing_of(stage.anatomy()), aspect);
  return render::measure_rays(scene, *stage.topology(), posed.mesh.position, camera,
                              request.settings, repeats);
}

}  // namespace backbend::validate
