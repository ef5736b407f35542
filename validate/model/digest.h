#pragma once
#include <map>
#include <string>
#include <vector>

#include "validate/model/report.h"

namespace backbend::validate {

/// Looks up, for the findings of one report, what the report says elsewhere. Holds a reference: the
/// report must outlive it.
class Digest {
 public:
  explicit Digest(const Report& report);

  /// The role of the finding's rig; `proposed` for a rig the report does not list, so that nothing
  /// unknown is waved through as a reference.
  Role role_of(const Finding& finding) const;
  /// `mesh kink` for BB011; empty for a code the report has no row for.
  const std::string& check_name(const std::string& code) const;

  struct Counts {
    int fail = 0, waived = 0, stress = 0;      // findings of proposed rigs
    int not_measured = 0, not_applicable = 0;  // measurements of proposed rigs, from coverage
    int reference = 0, canary = 0;             // findings of rigs that do not decide
  };
  const Counts& counts() const { return counts_; }

  /// At most `count` findings to show first: failures of proposed rigs, then what those rigs show
  /// outside the required range or could not be measured, then reference rigs; within each, over
  /// all rigs, by how many times over the limit; one of each code and rig before a second of any.
  std::vector<const Finding*> worst(std::size_t count) const;

 private:
  const Report& report_;
  std::map<std::string, std::string> name_;
  Counts counts_;
};

/// `vertebra_5`, `between spine_02 and spine_03, left, mesh "body"`; `slice 18` or `vertex 1207`
/// where nothing better is known; empty where the finding has no place.
std::string place_text(const Finding& finding);
/// `171.4 deg`, `x 20`, `0.71 of rest`: a value as people say it, in the finding's unit.
std::string quantity_text(const Finding& finding, double value, int digits = 3);
/// `63 deg (limit 25)`; `not measured` where there is no value. A value beyond its limit never
/// reads as equal to it.
std::string value_text(const Finding& finding);
/// `97`: degrees that a channel is clean to; `120+` where nothing beyond was tested; `?`.
std::string clean_text(const Headroom& headroom);
/// `extension 120+, flexion 90+, side 45+, twist 62`
std::string headroom_text(const std::vector<Headroom>& headroom);
/// The check's name in the table, or `candy wrapper` where slices collapse in a twist alone.
std::string finding_name(const Finding& finding, const Digest& digest);
/// Where the bend comes from under a mapping: `all on the chest control`; empty for none.
std::string mapping_words(const std::string& mapping);
/// How many times over (or under) its limit a value lies; 0 where either is missing.
double times_over(const Finding& finding);

}  // namespace backbend::validate
