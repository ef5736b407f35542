#pragma once
#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "solver/rig/spine_system.h"

namespace backbend::solver {

/// A control of a system controller: what is set from outside.
struct SystemControl {
  std::string name;
  std::vector<double> rest;  // its value until it is set; one number or more
};

/// One thing that a system controller drives: `width` numbers, computed from the inputs that it
/// declares (controls or other elements, by name) and from nothing else: evaluate() is handed
/// those, in the declared order, and must be a pure function of them.
struct SystemElement {
  using Input = std::span<const std::span<const double>>;
  std::string name;
  std::vector<std::string> inputs;
  std::size_t width = 1;
  std::function<void(Input input, std::span<double> output)> evaluate;
};

/// output[i] = sum over all numbers of all inputs, in order, of weight[i][k] x number k: how a few
/// controls share themselves out over any count of joints. Throws RigError for rows of unequal
/// length or none.
SystemElement weighted_element(std::string name, std::vector<std::string> inputs,
                               std::vector<std::vector<double>> weight);

/// One controller for a whole set of elements, whatever their number: who depends on whom is
/// declared, so the order of evaluation follows from the declarations and not from the order in
/// which things were made, linked or loaded. Immutable; the values live in a State, so many figures
/// share one controller.
///
/// Source: the conclusion of the seed's neck tool (research/seeds.md R111-R118, wish W9).
class SystemController {
 public:
  /// Throws RigError, naming who, for a name given twice, an input that does not exist (with the
  /// nearest name), an element without function or width, and a cycle with every element on it.
  SystemController(std::vector<SystemControl> controls, std::vector<SystemElement> elements);

  /// Values of all controls and elements, and which of them are out of date.
  class State {
    friend class SystemController;
    std::vector<std::vector<double>> value_;
    std::vector<bool> stale_;
  };

  /// Every control at rest, nothing evaluated yet.
  State start() const;
  /// Sets a control; a value that it already has changes nothing. Throws RigError for an unknown
  /// control, another count of numbers, or a number that is not finite; `state` is then as before.
  void set(State& state, std::string_view control, std::span<const double> value) const;
  /// Evaluates what is out of date, each element once and after all its inputs; an element whose
  /// inputs have come out as they were is left alone. Returns how many were evaluated.
  ///
  /// Throws RigError naming an element that gave a number that is not finite; it stays out of date
  /// and keeps its earlier value, so the next update with good controls is good.
  std::size_t update(State& state) const;
  /// A control's value, or an element's as of the last update. Throws RigError for unknown names.
  std::span<const double> value(const State& state, std::string_view name) const;

  /// "element <- input, input" in the order of evaluation: inputs first, equals by name.
  std::vector<std::string> explain() const;

 private:
  struct Node {
    std::string name;
    std::vector<std::string> input_names;
    std::vector<std::size_t> inputs;                                        // into node_
    std::vector<std::size_t> dependents;                                    // into node_
    std::vector<double> rest;                                               // of its width
    std::function<void(SystemElement::Input, std::span<double>)> evaluate;  // none: a control
  };

  void add(Node node);
  void link();
  void sort();
  [[noreturn]] void refuse_cycle(const std::vector<std::size_t>& waiting) const;
  std::size_t find(std::string_view name) const;

  std::vector<Node> node_;  // by name
  std::vector<std::size_t> order_;
};

}  // namespace backbend::solver
