#include "validate/live/in_process_rig.h"

#include <algorithm>
#include <map>
#include <mutex>

#include "validate/sweeps/external_spec.h"
#include "validate/sweeps/in_process_spec.h"
#include "validate/tasks/progress.h"

namespace backbend::validate {
namespace {

struct KnownRigs {
  std::mutex mutex;
  std::map<std::string, std::shared_ptr<InProcessRig>> rig;  // by name and number
  std::size_t count = 0;
};

KnownRigs& known_rigs() {
  static KnownRigs known;
  return known;
}

class InProcessServer final : public RigServer {
 public:
  InProcessServer(std::string who, std::shared_ptr<InProcessRig> rig)
      : who_(std::move(who)), rig_(std::move(rig)) {
    try {
      hello_ = parse_hello(rig_->hello());
    } catch (const ProtocolError& error) {
      throw solver::RigError(who_ + ": " + error.what());
    }
    hello_.selects = false;
    for (const RigJoint& joint : hello_.joints) joint_name_.push_back(joint.name);
  }

  void select(std::vector<int> channels, std::vector<int> joints) override {
    channels_ = std::move(channels);
    joints_ = std::move(joints);
  }

  Answer ask(std::span<const double> values, std::size_t poses, bool points) override {
    poll_interrupt();
    try {
      const InProcessRig::Answer said =
          rig_->ask(with_rest(values, poses, channels_), poses, points);
      Answer answer;
      check_size("joints", said.joints.size(), poses * hello_.joints.size() * 16 * sizeof(double));
      answer.joints = selected(unpack_joints(said.joints, joint_name_), poses, joints_);
      if (!points) return answer;
      check_size("points", said.points.size(), poses * hello_.points.size() * sizeof(glm::vec3));
      answer.points = unpack_points(said.points, hello_.points.size());
      return answer;
    } catch (const Interrupted&) {
      throw;
    } catch (const std::exception& error) {
      throw solver::RigError(who_ + ": " + error.what());
    }
  }

  std::size_t batch(bool points) const override {
    const std::size_t bytes = sizeof(glm::vec3) * std::max<std::size_t>(1, hello_.points.size());
    return points ? std::clamp<std::size_t>(kMostPointBytes / bytes, 1, kMostPosesAsked)
                  : kMostPosesAsked;
  }

 private:
  static void check_size(const std::string& what, std::size_t found, std::size_t expected) {
    if (found != expected)
      throw ProtocolError(what + " of an answer: " + std::to_string(found) + " bytes, expected " +
                          std::to_string(expected));
  }

  std::string who_;
  std::shared_ptr<InProcessRig> rig_;
  std::vector<int> channels_, joints_;
  std::vector<std::string> joint_name_;
};

}  // namespace

KnownRig::KnownRig(const std::string& name, std::shared_ptr<InProcessRig> rig) {
  KnownRigs& known = known_rigs();
  const std::lock_guard lock(known.mutex);
  name_ = name + kInProcessNumber + std::to_string(++known.count);
  known.rig[name_] = std::move(rig);
}

KnownRig::~KnownRig() {
  KnownRigs& known = known_rigs();
  std::shared_ptr<InProcessRig> last;  // ends outside of the lock
  const std::lock_guard lock(known.mutex);
  const auto found = known.rig.find(name_);
  last = std::move(found->second);
  known.rig.erase(found);
}

solver::SystemSpec KnownRig::spec() const {
  return {std::string(kExternal), {{"program", std::string(kInProcess)}, {"file", name_}}};
}

std::unique_ptr<RigServer> in_process_server(const std::string& who, const std::string& name) {
  std::shared_ptr<InProcessRig> rig;
  {
    KnownRigs& known = known_rigs();
    const std::lock_guard lock(known.mutex);
    if (const auto found = known.rig.find(name); found != known.rig.end()) rig = found->second;
  }
  if (!rig)
    throw solver::RigError(who +
                           ": a rig written in Python is known only to the Python that made it; "
                           "judge it there, with backbend.judge()");
  return std::make_unique<InProcessServer>(who, std::move(rig));
}

}  // namespace backbend::validate
