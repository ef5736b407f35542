#pragma once
#include <cmath>
#include <memory>

#include "validate/selftest/selftest.h"
#include "validate/stage/stage.h"

namespace backbend::validate {

/// Collects the cases of one property.
class Tally {
 public:
  Tally(std::string layer, std::string name, std::string subject, double bound, std::string unit) {
    property_.layer = std::move(layer);
    property_.name = std::move(name);
    property_.subject = std::move(subject);
    property_.bound = bound;
    property_.unit = std::move(unit);
  }
  /// A case that missed by `amount`. What is not finite stays the worst.
  void add(double amount, const std::string& where) {
    ++property_.cases;
    if (std::isnan(property_.worst) || (amount <= property_.worst && property_.cases > 1)) return;
    property_.worst = amount;
    property_.where = where;
  }
  const Property& property() const { return property_; }

 private:
  Property property_;
};

/// `again` is the same character on a stage of its own, where the rig is built or started again.
std::vector<Property> solver_properties(const Stage& stage, const Stage& again, const RigPlan& rig,
                                        std::size_t cases);
std::vector<Property> skin_properties(const Stage& stage, const RigPlan& rig, std::size_t cases);
std::vector<Property> render_properties(const Stage& stage, const RigPlan& rig);

}  // namespace backbend::validate
