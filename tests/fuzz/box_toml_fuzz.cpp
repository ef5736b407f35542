#include "tests/fuzz/target.h"
#include "validate/files/output_folder.h"
#include "validate/hunt/control_box.h"

namespace backbend::fuzz {
namespace {

using namespace validate;

/// A box of poses for `hunt` and `prove`.
bool run(Input input) {
  try {
    const ControlBox box = read_box(as_file(input, "box.toml"));
    require(!box.axes.empty(), "a box moves a channel");
    const std::vector<double> middle(box.axes.size(), 0.5);
    const std::vector<double> again = box.point_of(box.pose_at(middle));
    for (const double each : again)
      require(each >= 0.0 && each <= 1.0, "a pose of the box is in it");
    return true;
  } catch (const ReadError& error) {
    return refused(error);
  }
}

std::vector<Bytes> seeds() {
  return {bytes_of("[box]\nextension = [-30, 60]\nside = [-20, 45]\ntwist = 15\n"),
          bytes_of("flexion = [0, 40]\nhip = [0, 5]\nstretch = [-5, 5.5]\n")};
}

const Registration registration{{"box_toml",
                                 run,
                                 seeds,
                                 {"[box]", "extension", "flexion", "side", "twist", "hip",
                                  "stretch", "=", "[", "]", "-", "inf", "nan", "1e308"},
                                 2048}};

}  // namespace
}  // namespace backbend::fuzz
