#include "validate/evidence/review.h"

#include <cassert>
#include <cmath>

#include "validate/model/report.h"
#include "validate/text/number_text.h"

namespace backbend::validate {

std::vector<ReviewFrame> held_at(std::size_t poses, std::size_t worst, std::size_t hold) {
  assert(worst < poses);
  std::vector<ReviewFrame> frames;
  for (std::size_t pose = 0; pose < poses; ++pose) {
    frames.push_back({pose, false});
    if (pose == worst) frames.insert(frames.end(), hold, {pose, true});
  }
  return frames;
}

std::size_t nearest_pose(const std::vector<double>& control_deg, double degrees) {
  std::size_t nearest = 0;
  for (std::size_t i = 1; i < control_deg.size(); ++i) {
    if (std::abs(control_deg[i] - degrees) <= std::abs(control_deg[nearest] - degrees)) nearest = i;
  }
  return nearest;
}

std::string review_csv(const std::vector<ReviewFrame>& frames,
                       const std::vector<double>& control_deg) {
  std::string text = "frame,seconds,control_deg,held\r\n";
  for (std::size_t i = 0; i < frames.size(); ++i) {
    text += std::to_string(kFirstFrame + static_cast<int>(i)) + "," +
            fixed(static_cast<double>(i) / kFramesPerSecond, 4) + "," +
            shortest(control_deg[frames[i].pose]) + (frames[i].held ? ",1\r\n" : ",0\r\n");
  }
  return text;
}

}  // namespace backbend::validate
