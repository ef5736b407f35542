#include "solver/rig/naming.h"

#include <algorithm>
#include <map>

#include "solver/rig/crowd.h"
#include "solver/rig/option_reader.h"

namespace backbend::solver {
namespace {

using Names = std::vector<std::string>;

std::string padded(std::size_t number, std::size_t most) {
  const std::string digits = std::to_string(number);
  return std::string(std::to_string(most).size() - digits.size(), '0') + digits;
}

bool may_stand(char c) { return c != '.' && c != ' ' && c != 0x7f && (c < 0 || c > 0x1f); }

/// Every name of a rig once: a scene has room for no second thing of the same name.
class Taken {
 public:
  explicit Taken(std::string key) : key_(std::move(key)) {}
  void add(const Names& old_names, const Names& names, const char* kind) {
    for (std::size_t i = 0; i < names.size(); ++i) {
      const std::string who = std::string(kind) + " '" + old_names[i] + "'";
      const auto [at, is_new] = by_name_.emplace(names[i], who);
      if (!is_new) {
        throw OptionError(key_, at->second + " and " + who + " would both be named '" + names[i] +
                                    "'; use {name} or {index} to tell them apart");
      }
    }
  }

 private:
  std::string key_;
  std::map<std::string, std::string> by_name_;
};

class NamedSystem final : public SpineSystem, public CrowdSolver {
 public:
  NamedSystem(std::unique_ptr<SpineSystem> system, const Naming& naming)
      : system_(std::move(system)),
        options_(system_->options()),
        channels_(system_->channels()),
        joint_names_(system_->joint_names()) {
    for (const Channel& c : channels_) {
      const std::string control = control_of(c.name);
      if (std::find(old_controls_.begin(), old_controls_.end(), control) == old_controls_.end()) {
        old_controls_.push_back(control);
      }
    }
    controls_ = old_controls_;
    if (!naming.control_names.empty()) {
      controls_ = names_from("control_names", naming.control_names, old_controls_);
    }
    if (!naming.joint_names.empty()) {
      joint_names_ = names_from("joint_names", naming.joint_names, system_->joint_names());
    }
    Taken taken(naming.control_names.empty() ? "joint_names" : "control_names");
    taken.add(old_controls_, controls_, "control");
    taken.add(system_->joint_names(), joint_names_, "joint");
    for (Channel& c : channels_) {
      const std::string control = control_of(c.name);
      c.name = renamed(control) + c.name.substr(control.size());
    }
    if (!naming.control_names.empty()) options_["control_names"] = naming.control_names;
    if (!naming.joint_names.empty()) options_["joint_names"] = naming.joint_names;
  }

  std::string_view name() const override { return system_->name(); }
  const std::map<std::string, OptionValue>& options() const override { return options_; }
  const std::vector<Channel>& channels() const override { return channels_; }
  const Names& joint_names() const override { return joint_names_; }
  const std::vector<int>& joint_parents() const override { return system_->joint_parents(); }
  const SpinePose& rest() const override { return system_->rest(); }
  const std::vector<double>& arc_fraction() const override { return system_->arc_fraction(); }
  SpinePose solve(std::span<const double> control) const override {
    return system_->solve(control);
  }
  void solve_into(std::span<const double> control, Detail detail, SpinePose& pose) const override {
    system_->solve_into(control, detail, pose);
  }
  void solve_crowd(const CrowdControls& control, PoseRange range, CrowdPose& out) const override {
    solver::solve_crowd(*system_, control, range, out);
  }
  std::vector<double> controls_for(const BodyPose& body, Mapping mapping) const override {
    return system_->controls_for(body, mapping);
  }
  std::string_view why_without(BodyChannel channel) const override {
    return system_->why_without(channel);
  }
  std::vector<glm::dvec3> intended_curve(std::span<const double> control,
                                         std::size_t count) const override {
    return system_->intended_curve(control, count);
  }
  bool read_pose_key(std::string_view key, const OptionValue& value,
                     std::span<double> control) const override {
    const auto at = std::find(controls_.begin(), controls_.end(), key);
    if (at == controls_.end()) return false;
    const std::string& old_key = old_controls_[std::size_t(at - controls_.begin())];
    try {
      return system_->read_pose_key(old_key, value, control);
    } catch (const OptionError& trouble) {
      throw OptionError(std::string(key), trouble.what());  // whoever adds the line knows this name
    }
  }

 private:
  const std::string& renamed(const std::string& control) const {
    const auto at = std::find(old_controls_.begin(), old_controls_.end(), control);
    return controls_[std::size_t(at - old_controls_.begin())];
  }

  std::unique_ptr<SpineSystem> system_;
  std::map<std::string, OptionValue> options_;
  std::vector<Channel> channels_;
  Names joint_names_;
  Names old_controls_, controls_;  // in step
};

}  // namespace

Names names_from(const std::string& key, std::string_view text, const Names& names) {
  const auto refuse = [&](const std::string& what) {
    throw OptionError(key, "option '" + key + "' is \"" + std::string(text) + "\": " + what);
  };
  Names result;
  for (std::size_t i = 0; i < names.size(); ++i) {
    std::string name;
    for (std::string_view rest = text; !rest.empty();) {
      const std::size_t brace = rest.find_first_of("{}");
      name += rest.substr(0, brace);
      if (brace == std::string_view::npos) break;
      rest.remove_prefix(brace);
      if (rest.starts_with("{name}")) {
        name += names[i];
      } else if (rest.starts_with("{index}")) {
        name += padded(i + 1, names.size());
      } else {
        refuse("'" + std::string(rest.substr(0, rest.find('}') + 1)) +
               "': unknown placeholder, expected {name} or {index}");
      }
      rest.remove_prefix(rest.find('}') + 1);
    }
    if (name.empty()) refuse("a name would be empty");
    if (!std::all_of(name.begin(), name.end(), may_stand)) {
      refuse("a name can hold no '.', blank or control character");
    }
    result.push_back(std::move(name));
  }
  return result;
}

std::unique_ptr<SpineSystem> name_system(std::unique_ptr<SpineSystem> system,
                                         const Naming& naming) {
  if (naming.control_names.empty() && naming.joint_names.empty()) return system;
  return std::make_unique<NamedSystem>(std::move(system), naming);
}

}  // namespace backbend::solver
