#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "validate/live/rig_server.h"

namespace backbend::validate {

/// A rig that is evaluated in this process, by code that the caller brought: one written in Python.
///
/// It says what a server of `backbend.rig/1` says, in the same forms (rig_protocol.h), without the
/// streams between. Asked by one thread at a time, which may be any.
class InProcessRig {
 public:
  virtual ~InProcessRig() = default;

  /// The line of JSON that introduces it. Its `select` counts as false.
  virtual std::string hello() const = 0;
  struct Answer {
    std::vector<std::uint8_t> joints;  // sixteen float64 of each joint of the hello, pose by pose
    std::vector<std::uint8_t> points;  // three float32 of each point, pose by pose, where asked for
  };
  /// `poses` poses for values of all channels of the hello, as on the wire. Throws std::exception
  /// whose what() says what went wrong, without the rig's name; Interrupted.
  virtual Answer ask(std::span<const double> values, std::size_t poses, bool points) = 0;
};

/// Makes a rig known to this process for as long as this lives.
class KnownRig {
 public:
  /// `name`: as people know it, without `#`.
  KnownRig(const std::string& name, std::shared_ptr<InProcessRig> rig);
  ~KnownRig();
  KnownRig(const KnownRig&) = delete;
  KnownRig& operator=(const KnownRig&) = delete;

  /// What stands for it wherever a rig is taken: `external`, program `python`, and the name with a
  /// number that no other rig of this process has, so that what is kept of one never serves
  /// another.
  solver::SystemSpec spec() const;

 private:
  std::string name_;
};

/// The known rig of this name as a server. `who` names it in what is said. Throws solver::RigError
/// where none is known, or its hello is not one.
std::unique_ptr<RigServer> in_process_server(const std::string& who, const std::string& name);

}  // namespace backbend::validate
