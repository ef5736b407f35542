#pragma once
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "validate/files/child_stream.h"
#include "validate/live/rig_protocol.h"

namespace backbend::validate {

/// A rig that answers in the terms of `backbend.rig/1` (rig_protocol.h). Not for several threads at
/// once.
class RigServer {
 public:
  virtual ~RigServer() = default;

  const RigHello& hello() const { return hello_; }
  /// Says which channels and joints are wanted from now on, as indices into the hello's: a server
  /// that can does only those, of another one the rest is left at rest and passed over.
  virtual void select(std::vector<int> channels, std::vector<int> joints) = 0;
  struct Answer {
    std::vector<glm::dmat4> joints;  // of the selected joints, pose by pose
    std::vector<glm::vec3> points;   // of the hello's points, pose by pose; empty: not asked for
  };
  /// Poses for values of the selected channels (as on the wire), pose by pose. At most
  /// kMostPosesAsked poses. Throws solver::RigError with one line that says who and what went
  /// wrong; Interrupted.
  virtual Answer ask(std::span<const double> values, std::size_t poses, bool points = false) = 0;
  /// How many poses are asked for at once; with points as many as fit in 64 MB.
  virtual std::size_t batch(bool points = false) const = 0;

 protected:
  /// Values of the selected channels as those of all that the hello has, the others at rest.
  std::vector<double> with_rest(std::span<const double> values, std::size_t poses,
                                std::span<const int> channels) const;
  /// Of the joints of all that the hello has, pose by pose, the selected ones.
  std::vector<glm::dmat4> selected(std::span<const glm::dmat4> all, std::size_t poses,
                                   std::span<const int> joints) const;

  RigHello hello_;
};

/// One running program that speaks `backbend.rig/1`.
///
/// One that hangs, dies, answers short, not finite or in other words is started again once and
/// asked the same again; then it is given up.
class ProgramServer final : public RigServer {
 public:
  /// Starts it and hears its hello. `who` names the rig in what is said. Throws solver::RigError.
  ProgramServer(std::string who, std::vector<std::string> argv, double timeout);

  void select(std::vector<int> channels, std::vector<int> joints) override;
  Answer ask(std::span<const double> values, std::size_t poses, bool points = false) override;
  /// As many as take a tenth of the timeout at the pace of the answers so far.
  std::size_t batch(bool points = false) const override;

 private:
  void start();
  void send_selection();
  Answer ask_once(std::span<const double> values, std::size_t poses, bool points);
  void write(std::string_view text);
  void write(std::span<const std::uint8_t> bytes);
  std::string read_line(const std::string& what, std::size_t most);
  [[noreturn]] void fail(ChildStream::Outcome outcome, const std::string& what);
  [[noreturn]] void give_up(const std::string& why);
  /// Gives up after a failed attempt, or starts anew where that may be done.
  void after(const std::string& complaint);

  std::string who_;
  std::vector<std::string> argv_;
  ChildStream::Patience patience_;
  std::unique_ptr<ChildStream> child_;
  std::vector<int> channels_, joints_;
  std::vector<std::string> joint_name_;  // of what an answer holds
  std::size_t batch_ = 1, batch_with_points_ = 1;
  bool restarted_ = false;
  std::string given_up_;  // why; empty: it is not
};

}  // namespace backbend::validate
