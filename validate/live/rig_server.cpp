#include "validate/live/rig_server.h"

#include <algorithm>
#include <chrono>

#include "validate/files/output_folder.h"
#include "validate/tasks/progress.h"

namespace backbend::validate {
namespace {

using Outcome = ChildStream::Outcome;

// Programs take their time to start and to load a scene.
constexpr double kStartPatience = 5.0;  // of the timeout

/// The last line of what a program complained of, fit for a line of ours.
std::string last_line(const std::string& text) {
  std::size_t end = text.find_last_not_of(" \r\n\t");
  if (end == std::string::npos) return {};
  const std::size_t begin = text.rfind('\n', end);
  std::string line = text.substr(begin == std::string::npos ? 0 : begin + 1,
                                 end - (begin == std::string::npos ? 0 : begin + 1) + 1);
  if (line.size() > 300) line = line.substr(0, 300) + "...";
  return line;
}

/// What went wrong with a server, without its name.
struct Failure : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace

std::vector<double> RigServer::with_rest(std::span<const double> values, std::size_t poses,
                                         std::span<const int> channels) const {
  std::vector<double> all;
  all.reserve(poses * hello_.channels.size());
  for (std::size_t p = 0; p < poses; ++p) {
    const std::size_t first = all.size();
    for (const RigChannel& channel : hello_.channels) all.push_back(channel.rest);
    for (std::size_t c = 0; c < channels.size(); ++c)
      all[first + static_cast<std::size_t>(channels[c])] = values[p * channels.size() + c];
  }
  return all;
}

std::vector<glm::dmat4> RigServer::selected(std::span<const glm::dmat4> all, std::size_t poses,
                                            std::span<const int> joints) const {
  std::vector<glm::dmat4> wanted;
  wanted.reserve(poses * joints.size());
  for (std::size_t p = 0; p < poses; ++p)
    for (const int j : joints)
      wanted.push_back(all[p * hello_.joints.size() + static_cast<std::size_t>(j)]);
  return wanted;
}

ProgramServer::ProgramServer(std::string who, std::vector<std::string> argv, double timeout)
    : who_(std::move(who)), argv_(std::move(argv)), patience_{timeout, [] { poll_interrupt(); }} {
  try {
    start();
  } catch (const Failure& failure) {
    throw solver::RigError(who_ + ": " + failure.what());
  }
}

void ProgramServer::start() {
  child_ = std::make_unique<ChildStream>(argv_);
  const ChildStream::Patience patience{kStartPatience * patience_.seconds, patience_.watch};
  std::size_t chatter = 0;
  std::string line;
  while (true) {
    const Outcome outcome = child_->read_line(line, kMostHelloBytes, patience);
    if (outcome != Outcome::all) fail(outcome, "its hello");
    if (is_hello(line)) break;
    chatter += line.size() + 1;
    if (chatter > kMostChatter)
      throw Failure("no hello in the first " + std::to_string(kMostChatter) +
                    " bytes that it wrote; it does not speak backbend.rig/1");
  }
  try {
    hello_ = parse_hello(line);
  } catch (const ProtocolError& error) {
    throw Failure(error.what());
  }
}

void ProgramServer::fail(Outcome outcome, const std::string& what) {
  std::string text;
  if (outcome == Outcome::silent) {
    text = "it was silent for " + std::to_string(static_cast<int>(patience_.seconds)) +
           " seconds where " + what + " was due (option 'timeout')";
    child_->kill();
  } else if (outcome == Outcome::too_much) {
    text = "a line too long where " + what + " was due";
    child_->kill();
  } else {
    const int code = child_->exit_code();
    text = code > 128 ? "it was ended by signal " + std::to_string(code - 128)
                      : "it ended with exit code " + std::to_string(code);
    text += " where " + what + " was due";
  }
  const std::string said = last_line(child_->complaint());
  throw Failure(text + (said.empty() ? "" : "; it said: " + said));
}

void ProgramServer::write(std::span<const std::uint8_t> bytes) {
  const Outcome outcome = child_->write(bytes, patience_);
  if (outcome != Outcome::all) fail(outcome, "an answer");
}

void ProgramServer::write(std::string_view text) {
  write({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

std::string ProgramServer::read_line(const std::string& what, std::size_t most) {
  std::string line;
  const Outcome outcome = child_->read_line(line, most, patience_);
  if (outcome != Outcome::all) fail(outcome, what);
  return line;
}

void ProgramServer::select(std::vector<int> channels, std::vector<int> joints) {
  channels_ = std::move(channels);
  joints_ = std::move(joints);
  try {
    send_selection();
  } catch (const Failure& failure) {
    throw solver::RigError(who_ + ": " + failure.what());
  }
}

void ProgramServer::send_selection() {
  joint_name_.clear();
  if (!hello_.selects) {
    for (const RigJoint& joint : hello_.joints) joint_name_.push_back(joint.name);
    return;
  }
  std::vector<std::string> channels;
  for (const int c : channels_)
    channels.push_back(hello_.channels[static_cast<std::size_t>(c)].name);
  for (const int j : joints_)
    joint_name_.push_back(hello_.joints[static_cast<std::size_t>(j)].name);
  write(select_line(channels, joint_name_));
  try {
    check_selected(read_line("'selected'", kMostAnswerLine), channels_.size(), joints_.size());
  } catch (const ProtocolError& error) {
    throw Failure(error.what());
  }
}

RigServer::Answer ProgramServer::ask_once(std::span<const double> values, std::size_t poses,
                                          bool points) {
  write(ask_line(poses, points));
  if (hello_.selects) {
    write(pack_values(values));
  } else {
    write(pack_values(with_rest(values, poses, channels_)));
  }
  Answer answer;
  try {
    check_answer(read_line("an answer", kMostAnswerLine), poses);
    std::vector<std::uint8_t> bytes(poses * joint_name_.size() * 16 * sizeof(double));
    if (const Outcome outcome = child_->read(bytes, patience_); outcome != Outcome::all)
      fail(outcome, "the rest of an answer");
    answer.joints = unpack_joints(bytes, joint_name_);
    if (points) {
      bytes.resize(poses * hello_.points.size() * sizeof(glm::vec3));
      if (const Outcome outcome = child_->read(bytes, patience_); outcome != Outcome::all)
        fail(outcome, "the points of an answer");
      answer.points = unpack_points(bytes, hello_.points.size());
    }
  } catch (const ProtocolError& error) {
    throw Failure(error.what());
  }
  if (!hello_.selects) answer.joints = selected(answer.joints, poses, joints_);
  return answer;
}

std::size_t ProgramServer::batch(bool points) const {
  if (!points) return batch_;
  const std::size_t bytes = sizeof(glm::vec3) * std::max<std::size_t>(1, hello_.points.size());
  return std::clamp<std::size_t>(kMostPointBytes / bytes, 1, batch_with_points_);
}

RigServer::Answer ProgramServer::ask(std::span<const double> values, std::size_t poses,
                                     bool points) {
  // Whoever asks next hears the same.
  if (!given_up_.empty()) throw solver::RigError(given_up_);
  while (true) {
    try {
      const auto begin = std::chrono::steady_clock::now();
      Answer answer = ask_once(values, poses, points);
      const double seconds =
          std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
      const double fits = 0.1 * patience_.seconds * static_cast<double>(poses) / (seconds + 1e-6);
      std::size_t& batch = points ? batch_with_points_ : batch_;
      const double most =
          std::min({fits, 8.0 * static_cast<double>(batch), static_cast<double>(kMostPosesAsked)});
      batch = static_cast<std::size_t>(std::max(1.0, most));
      return answer;
    } catch (const Failure& failure) {
      after(failure.what());
    }
  }
}

void ProgramServer::after(const std::string& complaint) {
  if (restarted_) give_up(complaint + " (it had been started again once)");
  restarted_ = true;
  try {
    const RigHello before = hello_;
    start();
    const auto alike = [](const auto& a, const auto& b) {
      return std::ranges::equal(
          a, b, {}, [](const auto& x) { return x.name; }, [](const auto& x) { return x.name; });
    };
    if (!alike(before.channels, hello_.channels) || !alike(before.joints, hello_.joints) ||
        before.points.size() != hello_.points.size())
      throw Failure("started again, it has other channels, joints or points than before");
    send_selection();
  } catch (const Failure& failure) {
    give_up(complaint + "; started again: " + failure.what());
  } catch (const ReadError& error) {
    give_up(complaint + "; started again: " + error.what());
  }
}

void ProgramServer::give_up(const std::string& why) {
  child_.reset();
  given_up_ = who_ + ": " + why;
  throw solver::RigError(given_up_);
}

}  // namespace backbend::validate
