#include "validate/stage/pose_many.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>

#include "validate/tasks/progress.h"

namespace backbend::validate {
namespace {

using Index = std::size_t;

/// `work(p)` for each pose. One alone is left to the threads inside of it.
template <typename Work>
void each_pose(Index poses, const Work& work) {
  if (poses == 1) return work(Index{0});
  oneapi::tbb::parallel_for(Index{0}, poses, [&](Index p) {
    poll_interrupt();
    work(p);
  });
}

void copy_mesh(const skin::PosedMesh& mesh, Index pose, std::span<glm::vec3> position,
               std::span<glm::vec3> normal) {
  const Index vertices = mesh.position.size();
  std::ranges::copy(mesh.position, position.subspan(pose * vertices).begin());
  std::ranges::copy(mesh.normal, normal.subspan(pose * vertices).begin());
}

}  // namespace

void skin_many(const skin::SkinningPlan& plan, std::size_t nodes,
               std::span<const glm::dmat4> world_from_node, std::span<glm::vec3> position,
               std::span<glm::vec3> normal) {
  const Index poses = world_from_node.size() / std::max<Index>(1, nodes);
  const Index vertices = position.size() / std::max<Index>(1, poses);
  each_pose(poses, [&](Index p) {
    plan.skin(world_from_node.subspan(p * nodes, nodes), position.subspan(p * vertices, vertices),
              normal.subspan(p * vertices, vertices));
  });
}

void pose_many(const Stage& stage, const solver::SpineSystem& system,
               std::span<const double> controls, const ManyPoses& out) {
  const Index channels = system.channels().size(), nodes = stage.character().nodes.size();
  const Index poses = out.world_from_node.size() / std::max<Index>(1, nodes);
  std::vector<std::vector<double>> asked;
  for (Index p = 0; p < poses; ++p) {
    const auto own = controls.subspan(p * channels, channels);
    asked.emplace_back(own.begin(), own.end());
  }
  system.prepare(asked, solver::Detail::all);
  each_pose(poses, [&](Index p) {
    const PosedCharacter posed = stage.pose(system, asked[p]);
    std::ranges::copy(posed.world_from_node, out.world_from_node.subspan(p * nodes).begin());
    copy_mesh(posed.mesh, p, out.position, out.normal);
  });
}

}  // namespace backbend::validate
