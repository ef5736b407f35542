#include <algorithm>
#include <charconv>
#include <cmath>

#include "solver/math/rotation.h"
#include "solver/rig/nearest_name.h"
#include "solver/rig/option_reader.h"
#include "solver/rig/solve_file.h"

namespace backbend::solver {
namespace {

constexpr double kMostValues = 1e6;

bool read_number(std::string_view text, double& value) {
  const auto result = std::from_chars(text.data(), text.data() + text.size(), value);
  return result.ec == std::errc{} && result.ptr == text.data() + text.size() &&
         std::isfinite(value);
}

}  // namespace

std::vector<double> parse_range(std::string_view text, const std::string& start) {
  double part[3];
  std::size_t count = 0;
  bool good = true;
  for (std::string_view rest = text; good && count < 3; ++count) {
    const std::size_t colon = count < 2 ? rest.find(':') : rest.size();
    good = colon != std::string_view::npos && read_number(rest.substr(0, colon), part[count]);
    if (good && count < 2) rest.remove_prefix(colon + 1);
  }
  if (!good) {
    throw RigError(start + "expected control.channel=from:to:step, such as top.rz=0:-150:-5");
  }
  const auto [from, to, step] = part;
  const double steps = (to - from) / step;
  if (step == 0.0 || steps < 0.0) {
    throw RigError(start + "a step of " + number_text(step) + " does not lead from " +
                   number_text(from) + " to " + number_text(to));
  }
  if (!(steps < kMostValues)) throw RigError(start + "more than a million values");
  const auto last = std::size_t(std::floor(steps + 1e-9));
  std::vector<double> value;
  for (std::size_t i = 0; i <= last; ++i) {
    const bool end = i == last && std::abs(steps - double(last)) <= 1e-9;
    value.push_back(end ? to : from + double(i) * step);  // no sum: no drift
  }
  return value;
}

ControlSweep parse_sweep(const SpineSystem& system, std::string_view text) {
  const std::string start = "sweep '" + std::string(text.substr(0, 200)) + "': ";
  const std::size_t equals = std::min(text.find('='), text.size());
  ControlSweep sweep;
  sweep.written = parse_range(text.substr(std::min(equals + 1, text.size())), start);

  const std::string name(text.substr(0, equals));
  const auto& channels = system.channels();
  while (sweep.channel < channels.size() && channels[sweep.channel].name != name) ++sweep.channel;
  if (sweep.channel == channels.size()) {
    std::vector<std::string> known;
    for (const Channel& c : channels) known.push_back(c.name);
    throw RigError(start + "unknown channel '" + name + "'" + suggestion(name, known));
  }
  const bool angle = channels[sweep.channel].kind == Channel::Kind::rotation;
  for (const double written : sweep.written) {
    sweep.value.push_back(angle ? radians(written) : written);
  }
  return sweep;
}

}  // namespace backbend::solver
