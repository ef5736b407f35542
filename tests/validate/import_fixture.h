#pragma once
#include <string>

namespace backbend::validate {

/// A square tower on a chain of four joints, one above the other, in the words of three programs.
/// Ring k of its mesh stands at joint k and follows it alone; the tower is 0.6 m high, its joints
/// 0.2 m apart, the sides 0.1 m. All formats hold the same animation: over one second joint `j1`
/// turns 90 degrees about the tower's left (+X).
struct TowerFile {
  double metres_per_unit = 0.01;
  bool z_up = false;       // the file's up axis is Z, its front -Y; Y up, facing +Z else
  double weight = 1.0;     // what stands for a whole weight
  std::string name = "j";  // of the joints, before their number
  // FBX: further towers with joints of the same names, 1 m to the left of the one before, all on
  // one node.
  int more = 0;
};
std::string tower_fbx(const TowerFile& file = {});  // ASCII FBX 7.4
std::string tower_dae(const TowerFile& file = {});  // Collada 1.4.1
std::string tower_bvh();                            // in units of 0.2 m, Y up

}  // namespace backbend::validate
