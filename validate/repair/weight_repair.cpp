#include "validate/repair/weight_repair.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <optional>
#include <set>
#include <utility>

#include "skin/anatomy/body_kind.h"
#include "skin/anatomy/import_checks.h"
#include "skin/anatomy/sidecar.h"
#include "skin/gltf/gltf_weights.h"
#include "skin/weights/weight_graph.h"
#include "validate/files/import.h"
#include "validate/repair/repair_sheet.h"
#include "validate/repair/weight_edits.h"
#include "validate/verdicts/booking.h"
#include "validate/verdicts/checks.h"

namespace backbend::validate {
namespace {

using Index = std::size_t;

constexpr int kRounds = 4;
constexpr double kEqual = 0.1;      // of a limit: apart by less counts as equal, as in booking
constexpr double kBetter = 0.999;   // of the score, at most, for a change to be one
constexpr double kMostOne = 10.0;   // times its limit: more of one finding does not count
constexpr Index kScattered = 1000;  // poses between the sweeps, at which no change may fail anew

/// A file ready to be repaired: as a person confirmed it, and what leads back to the file.
struct RepairInput {
  skin::GltfDocument document;
  skin::WeightedGltf file;
  skin::Character character;           // without the parts that the sidecar leaves out
  std::vector<std::uint32_t> in_file;  // of each of its vertices: the file's
  ReadingContext context;
  skin::AnatomyHints hints;  // with the sidecar's
};

std::vector<std::uint32_t> vertices_in_file(const skin::Character& whole,
                                            const skin::Character& part) {
  std::vector<std::uint32_t> out(part.vertex_count());
  if (part.vertex_count() == whole.vertex_count()) {
    std::iota(out.begin(), out.end(), 0u);
    return out;
  }
  // Parts keep their order and their names.
  Index next = 0;
  for (const skin::Part& kept : part.parts) {
    while (whole.parts[next].name != kept.name ||
           whole.parts[next].vertex_count != kept.vertex_count)
      ++next;
    for (std::uint32_t k = 0; k < kept.vertex_count; ++k)
      out[kept.first_vertex + k] = whole.parts[next].first_vertex + k;
    ++next;
  }
  return out;
}

/// The character of a document with what its sidecar says, and its anatomy and limits.
RepairInput input_of(const std::filesystem::path& file, skin::GltfDocument document,
                     skin::AnatomyHints hints) {
  const std::optional<skin::Sidecar> sidecar = skin::read_sidecar(file);
  RepairInput out{std::move(document), {}, {}, {}, {}, {}};
  out.file = skin::read_weighted(out.document);
  out.character = out.file.character;
  if (sidecar) {
    skin::apply_sidecar(*sidecar, out.character);
    hints = skin::hints_with(*sidecar, std::move(hints));
  }
  skin::require_possible_import(out.character);
  out.context.anatomy = skin::find_anatomy(out.character, hints);
  if (sidecar)
    if (const auto difference = skin::contradiction(*sidecar, out.context.anatomy))
      throw skin::CharacterError(skin::sidecar_path(file).string() + ": " + *difference);
  out.in_file = vertices_in_file(out.file.character, out.character);
  const auto own =
      sidecar && !sidecar->envelope.empty() ? find_envelope(sidecar->envelope) : std::nullopt;
  out.context.envelope =
      own ? *own : envelope_for(skin::body_kind(out.character, out.context.anatomy).kind, false);
  out.context.words = file.string();
  out.hints = std::move(hints);
  return out;
}

WritableWeights writable_of(const RepairInput& input) {
  WritableWeights out;
  std::vector<int> of_file(input.file.character.vertex_count(), -1);
  // As many joints as the character has on any vertex: what engines were told to expect.
  Index most = 1;
  for (const skin::Influences& each : input.file.character.influences)
    most = std::max(most, static_cast<Index>(std::ranges::count_if(
                              each.weight, [](float w) { return w > 0.0f; })));
  for (const skin::WeightSource& source : input.file.sources) {
    std::vector<std::uint16_t> joints(source.joint.begin(), source.joint.end());
    std::ranges::sort(joints);
    std::fill_n(of_file.begin() + source.first_vertex, source.vertex_count,
                static_cast<int>(out.joints.size()));
    out.joints.push_back(std::move(joints));
    out.most.push_back(std::min(most, 4 * source.joints.size()));
  }
  for (const std::uint32_t v : input.in_file) out.group.push_back(of_file[v]);
  return out;
}

/// Which finding it is, whatever its size.
std::string key_of(const Finding& finding) {
  const bool counts = finding.code == "BB060" || finding.code == "BB061" || finding.code == "BB062";
  return finding.code + " " + (counts ? "" : finding.sweep.empty() ? finding.joint : finding.sweep);
}

/// The weights' findings of some codes, of all where `codes` is null: the sum of how many times
/// over its limit each is.
double score_of(const WeightReading& reading, const std::set<std::string>* codes = nullptr) {
  double sum = 0.0;
  for (const Finding& finding : reading.findings)
    if (is_of_weights(finding) && (codes == nullptr || codes->count(finding.code) > 0))
      sum += std::min(kMostOne, excess(*find_check(finding.code), finding.value, finding.limit));
  return sum;
}

double excess_of(const WeightReading& reading, const std::string& code) {
  const auto found = reading.excess.find(code);
  return found == reading.excess.end() ? 0.0 : found->second;
}

/// How many times its limit a value may be before the weights have to answer for it.
double decides_from(const std::string& code) {
  const Check& check = *find_check(code);
  if (check.subject != Subject::mesh) return 1.0;
  return excess(check, weights_limit(check, check.limit), check.limit);
}

/// What got worse by more than a tenth of its limit, or a finding that was not there; empty:
/// nothing. `deciding`: only what decides counts, not what is booked to skeleton or pose.
std::string what_is_worse(const WeightReading& before, const WeightReading& now, bool deciding) {
  std::set<std::string> known, fails;
  for (const Finding& finding : before.findings)
    if (finding.verdict == Verdict::fail) known.insert(key_of(finding));
  for (const Finding& finding : now.findings) {
    if (finding.verdict != Verdict::fail) continue;
    fails.insert(finding.code);
    if (known.count(key_of(finding)) == 0)
      return "it makes " + finding.code + " " + std::string(find_check(finding.code)->name) +
             (finding.sweep.empty() ? "" : " at " + finding.pose);
  }
  for (const auto& [code, factor] : now.excess) {
    if (deciding && fails.count(code) == 0) continue;
    const double old = excess_of(before, code);
    if (factor > decides_from(code) && factor > old + kEqual)
      return code + " " + std::string(find_check(code)->name) + " goes from " +
             number_text(old, 2) + " to " + number_text(factor, 2) + " times its limit";
  }
  return "";
}

class Repairer {
 public:
  Repairer(RepairInput& input, Progress& progress, WeightRepair& out)
      : input_(input),
        progress_(progress),
        out_(out),
        now_(input.character),
        writable_(writable_of(input)),
        reading_(measure(now_)) {}

  const WeightReading& reading() const { return reading_; }
  const skin::Character& character() const { return now_; }
  bool sums_corrected() const { return sums_corrected_; }

  void repair() {
    correct_sums();
    for (int round = 0; round < kRounds && score_of(reading_) > 0.0; ++round) {
      bool better = false;
      for (const auto group :
           {&Repairer::unknown, &Repairer::other_side, &Repairer::far, &Repairer::seams,
            &Repairer::asymmetry, &Repairer::order, &Repairer::borders, &Repairer::slices})
        better = (this->*group)() || better;
      if (!better) break;
    }
  }

 private:
  WeightReading measure(const skin::Character& character) {
    ++out_.measurements;
    return read_weights(character, input_.context, progress_);
  }

  std::vector<skin::WeightFault> failing(const skin::WeightAnswer& answer, std::string_view code) {
    std::vector<skin::WeightFault> out;
    const Check& check = *find_check(code);
    const double limit = input_.context.limits.of(code).value;
    for (const skin::WeightFault& fault : answer.faults)
      if (judge(check, 100.0 * fault.value, limit) == Verdict::fail) out.push_back(fault);
    return out;
  }

  /// Sums that are off were divided out when the file was read: written as they are now, they are
  /// whole.
  void correct_sums() {
    if (!(excess_of(reading_, "BB060") > 1.0)) return;
    now_.worst_weight_sum = 1.0;
    now_.worst_weight_vertex = -1;
    now_.renormalised_vertices = 0;
    out_.steps.push_back({"divided weights by their sums at " +
                              std::to_string(input_.file.off_sum.size()) + " vertices",
                          true, ""});
    sums_corrected_ = true;
    reading_ = measure(now_);
  }

  /// Takes the first edit that removes all findings of `codes` and makes nothing worse, else the
  /// best of those that help. `plain`: faults of the file itself, for which, as a last resort, an
  /// edit is taken that makes only findings of skeleton or pose worse. True if an edit was taken.
  bool take_best(const std::vector<WeightEdit>& edits, const std::set<std::string>& codes,
                 bool plain = false) {
    struct Tried {
      skin::Character character;
      WeightReading reading;
      Index step = 0;
    };
    std::optional<Tried> best, fallback, last;
    for (const WeightEdit& edit : edits) {
      poll_interrupt();
      if (!tried_.insert(edit.what + std::to_string(score_of(reading_))).second) continue;
      skin::Character changed = now_;
      changed.influences = edit.influences;
      std::erase_if(changed.unweighted, [&](std::uint32_t v) {
        return changed.influences[v].joint != now_.influences[v].joint ||
               changed.influences[v].weight != now_.influences[v].weight;
      });
      WeightReading reading = measure(changed);
      RepairStep step{edit.what, false, what_is_worse(reading_, reading, false)};
      const double before = score_of(reading_), after = score_of(reading);
      const bool better = after <= kBetter * before;
      if (step.why_not.empty() && !better) step.why_not = "no finding goes";
      const bool helps = step.why_not.empty();
      out_.steps.push_back(std::move(step));
      auto& slot = helps ? best : fallback;
      if (!helps && (!plain || !better || !what_is_worse(reading_, reading, true).empty()))
        continue;
      if (slot && after >= score_of(slot->reading)) continue;
      const std::string fails = fails_between(changed);
      if (!fails.empty()) {
        out_.steps.back().why_not = fails;
        // An unweighted vertex stays behind and so passes these poses; that is no reason to keep
        // it.
        if (codes.contains("BB061") && better && (!last || after < score_of(last->reading)))
          last = Tried{std::move(changed), std::move(reading), out_.steps.size() - 1};
        continue;
      }
      const bool cures = score_of(reading, &codes) == 0.0;
      slot = Tried{std::move(changed), std::move(reading), out_.steps.size() - 1};
      if (helps && cures) break;
    }
    const bool takes_fallback = !best && (fallback || last);
    if (takes_fallback) best = std::move(fallback ? fallback : last);
    if (!best) return false;
    RepairStep& step = out_.steps[best->step];
    step.taken = true;
    for (RepairStep& other : out_.steps)
      if (!other.taken && other.why_not.empty()) other.why_not = "another does better";
    // What it costs stays beside it.
    if (takes_fallback) step.costs = std::exchange(step.why_not, "");
    now_ = std::move(best->character);
    reading_ = std::move(best->reading);
    find_spine_again();
    return true;
  }

  /// What a change makes fail at poses between the sweeps that the character as it came does not
  /// fail there, both with the spine that the change gives; empty: nothing.
  std::string fails_between(const skin::Character& changed) {
    ReadingContext context = input_.context;
    context.anatomy = skin::find_anatomy(changed, input_.hints);
    const std::vector<PoseDegrees> poses = scattered_poses(context.envelope, kScattered);
    const skin::Anatomy& anatomy = context.anatomy;
    if (failing_before_.empty() || anatomy.spine != spine_before_ ||
        anatomy.chest_index != chest_before_) {
      failing_before_ = failing_at(input_.character, context, poses);
      spine_before_ = anatomy.spine;
      chest_before_ = anatomy.chest_index;
    }
    const std::vector<std::set<std::string>> failing = failing_at(changed, context, poses);
    for (Index i = 0; i < poses.size(); ++i)
      for (const std::string& code : failing[i])
        if (!failing_before_[i].contains(code))
          return "it makes " + code + " " + std::string(find_check(code)->name) + " at " +
                 poses[i].text();
    return {};
  }

  /// Which chain is the spine depends on the weights, too: `check` will find it by the new ones.
  void find_spine_again() {
    skin::Anatomy anatomy = skin::find_anatomy(now_, input_.hints);
    skin::Anatomy& known = input_.context.anatomy;
    if (anatomy.spine == known.spine && anatomy.chest_index == known.chest_index) return;
    known = std::move(anatomy);
    reading_ = measure(now_);
  }

  WeightEdits edits() const { return {now_, input_.context.anatomy, writable_}; }

  bool unknown() {
    std::vector<std::uint32_t> vertices = now_.unweighted;
    if (excess_of(reading_, "BB062") > 0.0)
      vertices.insert(vertices.end(), reading_.input.hygiene.strays.begin(),
                      reading_.input.hygiene.strays.end());
    if (vertices.empty()) return false;
    return take_best(edits().unknown(vertices), {"BB061", "BB062"}, true);
  }
  bool other_side() {
    const auto faults = failing(reading_.input.faults.wrong_side, "BB063");
    return !faults.empty() && take_best(edits().foreign(faults, true), {"BB063"}, true);
  }
  bool far() {
    const auto faults = failing(reading_.input.faults.far, "BB064");
    return !faults.empty() && take_best(edits().foreign(faults, false), {"BB064"}, true);
  }
  bool seams() {
    const auto faults = failing(reading_.input.faults.seams, "BB067");
    return !faults.empty() && take_best(edits().seams(faults), {"BB067"}, true);
  }
  bool asymmetry() {
    const auto faults = failing(reading_.input.faults.asymmetry, "BB065");
    return !faults.empty() && take_best(edits().asymmetry(faults), {"BB065"});
  }
  bool order() {
    const auto faults = failing(reading_.input.faults.order, "BB066");
    return !faults.empty() && take_best(edits().order(faults), {"BB066"});
  }

  bool borders() {
    const auto faults = failing(reading_.input.faults.borders, "BB069");
    return !faults.empty() && take_best(edits().borders(faults), {"BB069"});
  }

  /// What the mesh shows under the ideal bend, worst first, a stretch of the spine at a time.
  bool slices() {
    bool better = false;
    std::set<int> done;  // tenths of the spine
    for (bool again = true; again;) {
      again = false;
      for (const Finding& finding : reading_.findings) {
        if (!is_of_weights(finding) || find_check(finding.code)->subject != Subject::mesh) continue;
        double s = std::numeric_limits<double>::quiet_NaN();
        if (finding.slice >= 0)
          s = reading_.slice_at[static_cast<Index>(finding.slice)];
        else if (finding.vertex >= 0)
          s = reading_.coordinate[static_cast<Index>(finding.vertex)];
        if (!std::isfinite(s) || !done.insert(static_cast<int>(std::lround(10.0 * s))).second)
          continue;
        const double bone =
            1.0 / static_cast<double>(std::max<Index>(1, input_.context.anatomy.chest_index));
        again = take_best(edits().stretch(s - 0.5 * bone, s + 0.5 * bone), {finding.code});
        better = better || again;
        if (again) break;
      }
    }
    return better;
  }

  RepairInput& input_;
  Progress& progress_;
  WeightRepair& out_;
  skin::Character now_;
  const WritableWeights writable_;
  WeightReading reading_;
  std::set<std::string> tried_;
  // Of the character as it came: what fails at the scattered poses, and with which spine.
  std::vector<std::set<std::string>> failing_before_;
  std::vector<int> spine_before_;
  Index chest_before_ = 0;
  bool sums_corrected_ = false;
};

bool differ(const skin::Influences& a, const skin::Influences& b) {
  return a.joint != b.joint || a.weight != b.weight;
}

void count_checks(const WeightReading& before, const WeightReading& after, WeightRepair& out) {
  std::map<std::string, RepairedCheck> checks;
  const auto count = [&](const WeightReading& reading, std::size_t RepairedCheck::*member,
                         std::vector<Finding>& list) {
    for (const Finding& finding : reading.findings)
      if (is_of_weights(finding)) {
        ++(checks[finding.code].*member);
        list.push_back(finding);
      }
  };
  count(before, &RepairedCheck::before, out.before);
  count(after, &RepairedCheck::after, out.after);
  // What became visibly worse is shown though it does not decide.
  for (const auto& [code, factor] : after.excess)
    if (factor > 1.0 && factor > excess_of(before, code) + kEqual) checks[code];
  for (auto& [code, each] : checks) {
    const Check& check = *find_check(code);
    each.code = code;
    each.name = check.name;
    each.unit = check.unit;
    each.worst_before = excess_of(before, code);
    each.worst_after = excess_of(after, code);
    out.checks.push_back(each);
  }
  for (const Finding& finding : after.findings)
    if (!is_of_weights(finding)) out.others.push_back(finding);
}

}  // namespace

WeightRepair repair_weights(const std::filesystem::path& file, const skin::AnatomyHints& hints,
                            Progress& progress, bool with_sheet) {
  if (is_imported(file))
    throw skin::CharacterError(
        file.string() +
        ": only glTF (.glb, .gltf) without compression can be repaired; other formats lose the "
        "numbers of their vertices on the way here: export the character so");
  if (file.extension() == ".toml")
    throw skin::CharacterError(file.string() +
                               ": a body description has no weights; make the body first "
                               "(backbend body) and repair that");
  RepairInput input = input_of(file, skin::load_gltf(file), hints);
  WeightRepair out;
  Repairer repairer(input, progress, out);
  const WeightReading before = repairer.reading();
  out.character = input.file.character;
  out.envelope = input.context.envelope.name;
  out.poses = before.poses;
  out.influences = input.file.character.influences;
  out.touched.assign(out.influences.size(), false);
  repairer.repair();

  const skin::Character& repaired = repairer.character();
  for (Index v = 0; v < repaired.vertex_count(); ++v) {
    if (!differ(repaired.influences[v], input.character.influences[v])) continue;
    const Index to = input.in_file[v];
    out.influences[to] = repaired.influences[v];
    out.touched[to] = true;
    const double change = skin::share_moved(skin::shares_of(repaired.influences[v]),
                                            skin::shares_of(input.character.influences[v]));
    if (change > out.largest_change) {
      out.largest_change = change;
      out.largest_vertex = static_cast<std::uint32_t>(to);
    }
  }
  if (repairer.sums_corrected()) {
    for (const std::uint32_t v : input.file.off_sum) out.touched[v] = true;
    const double change = std::min(1.0, std::abs(1.0 - input.file.character.worst_weight_sum));
    if (change > out.largest_change) {
      out.largest_change = change;
      out.largest_vertex = static_cast<std::uint32_t>(input.file.character.worst_weight_vertex);
    }
  }
  out.touched_count = static_cast<Index>(std::count(out.touched.begin(), out.touched.end(), true));
  if (out.touched_count == 0) {
    count_checks(before, before, out);
    return out;
  }
  out.glb = skin::encode_with_weights(input.document, input.file, out.influences, out.touched);
  const RepairInput written = input_of(file, skin::load_gltf({file, out.glb, out.glb}), hints);
  ++out.measurements;
  count_checks(before, read_weights(written.character, written.context, progress), out);
  if (with_sheet)
    out.sheet = repair_sheet({input.character, written.character, written.context.anatomy,
                              input.context.envelope, out.before},
                             progress);
  return out;
}

}  // namespace backbend::validate
