#include "solver/rig/system_controller.h"

#include <algorithm>
#include <cmath>
#include <queue>

#include "solver/rig/nearest_name.h"

namespace backbend::solver {
namespace {

bool all_finite(std::span<const double> value) {
  return std::all_of(value.begin(), value.end(), [](double v) { return std::isfinite(v); });
}

}  // namespace

SystemElement weighted_element(std::string name, std::vector<std::string> inputs,
                               std::vector<std::vector<double>> weight) {
  const std::size_t width = weight.size();
  const std::size_t count = width == 0 ? 0 : weight.front().size();
  for (const auto& row : weight) {
    if (row.size() != count || !all_finite(row)) {
      throw RigError("element '" + name + "': its rows of weights differ in length or hold a " +
                     "number that is not finite");
    }
  }
  if (count == 0) throw RigError("element '" + name + "': no weights");
  auto share = [weight = std::move(weight), name](SystemElement::Input input,
                                                  std::span<double> output) {
    std::size_t given = 0;
    for (const auto& numbers : input) given += numbers.size();
    if (given != weight.front().size()) {
      throw RigError("element '" + name + "': " + std::to_string(given) + " numbers come in, " +
                     std::to_string(weight.front().size()) + " weights a row");
    }
    for (std::size_t i = 0; i < output.size(); ++i) {
      double sum = 0.0;
      std::size_t k = 0;
      for (const auto& numbers : input) {
        for (const double number : numbers) sum += weight[i][k++] * number;
      }
      output[i] = sum;
    }
  };
  return {std::move(name), std::move(inputs), width, std::move(share)};
}

SystemController::SystemController(std::vector<SystemControl> controls,
                                   std::vector<SystemElement> elements) {
  for (SystemControl& control : controls) {
    if (control.rest.empty() || !all_finite(control.rest)) {
      throw RigError("control '" + control.name + "': its rest must be one finite number or more");
    }
    add({std::move(control.name), {}, {}, {}, std::move(control.rest), {}});
  }
  for (SystemElement& element : elements) {
    if (!element.evaluate || element.width == 0) {
      throw RigError("element '" + element.name + "': it gives no numbers");
    }
    add({std::move(element.name),
         std::move(element.inputs),
         {},
         {},
         std::vector<double>(element.width, 0.0),
         std::move(element.evaluate)});
  }
  // By name: nothing below depends on the order in which they were declared.
  std::sort(node_.begin(), node_.end(),
            [](const Node& a, const Node& b) { return a.name < b.name; });
  link();
  sort();
}

void SystemController::add(Node node) {
  for (const Node& other : node_) {
    if (other.name == node.name) throw RigError("'" + node.name + "' is declared twice");
  }
  node_.push_back(std::move(node));
}

void SystemController::link() {
  for (std::size_t i = 0; i < node_.size(); ++i) {
    for (const std::string& input : node_[i].input_names) {
      const std::size_t found = find(input);
      if (found == node_.size()) {
        std::vector<std::string> known;
        for (const Node& node : node_) known.push_back(node.name);
        throw RigError("element '" + node_[i].name + "': unknown input '" + input + "'" +
                       suggestion(input, known));
      }
      node_[i].inputs.push_back(found);
      node_[found].dependents.push_back(i);
    }
  }
}

/// Kahn's algorithm; of those that are ready, the first by name.
void SystemController::sort() {
  std::vector<std::size_t> waiting(node_.size());
  std::priority_queue<std::size_t, std::vector<std::size_t>, std::greater<>> ready;
  for (std::size_t i = 0; i < node_.size(); ++i) {
    waiting[i] = node_[i].inputs.size();
    if (waiting[i] == 0) ready.push(i);
  }
  while (!ready.empty()) {
    const std::size_t next = ready.top();
    ready.pop();
    order_.push_back(next);
    for (const std::size_t dependent : node_[next].dependents) {
      if (--waiting[dependent] == 0) ready.push(dependent);
    }
  }
  if (order_.size() < node_.size()) refuse_cycle(waiting);
}

/// Whoever still waits has an input that waits too, so walking along those must come round.
void SystemController::refuse_cycle(const std::vector<std::size_t>& waiting) const {
  std::vector<std::size_t> path;
  auto at = std::size_t(
      std::find_if(waiting.begin(), waiting.end(), [](std::size_t inputs) { return inputs > 0; }) -
      waiting.begin());
  while (std::find(path.begin(), path.end(), at) == path.end()) {
    path.push_back(at);
    for (const std::size_t input : node_[at].inputs) {
      if (waiting[input] > 0) {
        at = input;
        break;
      }
    }
  }
  path.erase(path.begin(), std::find(path.begin(), path.end(), at));
  // Read from the first by name, so that the message is one whatever was found first.
  std::rotate(path.begin(), std::min_element(path.begin(), path.end()), path.end());
  std::string line;
  for (const std::size_t i : path) line += "'" + node_[i].name + "' <- ";
  throw RigError("elements depend on each other in a circle: " + line + "'" +
                 node_[path.front()].name + "'");
}

std::size_t SystemController::find(std::string_view name) const {
  const auto at = std::lower_bound(
      node_.begin(), node_.end(), name,
      [](const Node& node, std::string_view wanted) { return node.name < wanted; });
  return at != node_.end() && at->name == name ? std::size_t(at - node_.begin()) : node_.size();
}

SystemController::State SystemController::start() const {
  State state;
  for (const Node& node : node_) {
    state.value_.push_back(node.rest);
    state.stale_.push_back(bool(node.evaluate));
  }
  return state;
}

void SystemController::set(State& state, std::string_view control,
                           std::span<const double> value) const {
  const std::size_t at = find(control);
  if (at == node_.size() || node_[at].evaluate) {
    std::vector<std::string> known;
    for (const Node& node : node_) {
      if (!node.evaluate) known.push_back(node.name);
    }
    throw RigError("unknown control '" + std::string(control) + "'" + suggestion(control, known));
  }
  std::vector<double>& held = state.value_[at];
  if (value.size() != held.size()) {
    throw RigError("control '" + node_[at].name + "' takes " + std::to_string(held.size()) +
                   " numbers, not " + std::to_string(value.size()));
  }
  if (!all_finite(value)) {
    throw RigError("control '" + node_[at].name + "' was given a number that is not finite");
  }
  if (std::equal(value.begin(), value.end(), held.begin())) return;
  held.assign(value.begin(), value.end());
  for (const std::size_t dependent : node_[at].dependents) state.stale_[dependent] = true;
}

std::size_t SystemController::update(State& state) const {
  std::size_t evaluated = 0;
  std::vector<std::span<const double>> input;
  std::vector<double> output;
  for (const std::size_t at : order_) {
    if (!state.stale_[at]) continue;
    const Node& node = node_[at];
    input.clear();
    for (const std::size_t i : node.inputs) input.emplace_back(state.value_[i]);
    output.assign(node.rest.size(), 0.0);
    node.evaluate(input, output);
    ++evaluated;
    if (!all_finite(output)) {
      throw RigError("element '" + node.name + "' gave a number that is not finite");
    }
    state.stale_[at] = false;
    if (output == state.value_[at]) continue;
    state.value_[at] = output;
    for (const std::size_t dependent : node.dependents) state.stale_[dependent] = true;
  }
  return evaluated;
}

std::span<const double> SystemController::value(const State& state, std::string_view name) const {
  const std::size_t at = find(name);
  if (at == node_.size()) {
    std::vector<std::string> known;
    for (const Node& node : node_) known.push_back(node.name);
    throw RigError("unknown control or element '" + std::string(name) + "'" +
                   suggestion(name, known));
  }
  return state.value_[at];
}

std::vector<std::string> SystemController::explain() const {
  std::vector<std::string> lines;
  for (const std::size_t at : order_) {
    if (!node_[at].evaluate) continue;
    std::string line = node_[at].name + " <-";
    for (const std::string& input : node_[at].input_names) {
      line += (line.ends_with("<-") ? " " : ", ") + input;
    }
    lines.push_back(std::move(line));
  }
  return lines;
}

}  // namespace backbend::solver
