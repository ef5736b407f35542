#include "validate/tune/trade_search.h"

#include <nlopt.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <map>
#include <memory>
#include <new>

namespace backbend::validate {
namespace {

using Index = std::size_t;

constexpr double kGlobalShare = 0.4;     // of the evaluations: for the whole cube
constexpr double kPriceOfChange = 0.02;  // gain that a unit of change must bring, in the whole cube
constexpr double kPenalty = 0.1;         // gain lost for each unit of change beyond a level
constexpr double kFirstStep = 0.2;       // of an axis, around the best place
constexpr int kMostRepeats = 50;         // calls for each evaluation: known places cost nothing
constexpr double kImpossible = 1e3;      // worse than any place that can be had

class Searcher {
 public:
  explicit Searcher(const TradeSettings& settings) : settings_(settings) {}

  std::vector<TradePoint> run() {
    look(settings_.origin);
    const auto global =
        static_cast<Index>(kGlobalShare * static_cast<double>(settings_.evaluations));
    optimise(NLOPT_GN_DIRECT_L, settings_.origin, global,
             [](const TradeValue& value) { return value.gain - kPriceOfChange * value.change; });
    for (Index i = 0; i < settings_.levels.size(); ++i) {
      const Index left =
          settings_.evaluations - std::min(points_.size() + failed_, settings_.evaluations);
      const Index until = settings_.evaluations - left + left / (settings_.levels.size() - i);
      const double level = settings_.levels[i];
      const auto score = [level](const TradeValue& value) {
        return value.gain - kPenalty * std::max(0.0, value.change - level);
      };
      step_from_best(until, score);
      optimise(NLOPT_LN_SBPLX, best(score), until, score);
    }
    return std::move(points_);
  }

 private:
  using Score = std::function<double(const TradeValue&)>;

  Index spent() const { return points_.size() + failed_; }

  /// Nothing where the place cannot be had, or was not looked at before and `until` is reached.
  std::optional<TradeValue> look(const std::vector<double>& at) {
    const std::string key = settings_.key(at);
    if (const auto known = known_.find(key); known != known_.end()) return known->second;
    const std::optional<TradeValue> value = settings_.look(at);
    known_.emplace(key, value);
    if (value)
      points_.push_back({at, *value});
    else
      ++failed_;
    return value;
  }

  std::vector<double> best(const Score& score) const {
    const auto found = std::ranges::max_element(
        points_, {}, [&](const TradePoint& point) { return score(point.value); });
    return found == points_.end() ? settings_.origin : found->at;
  }

  /// Axes with few values: one value up or down, as long as that helps.
  void step_from_best(Index until, const Score& score) {
    for (bool again = true; again && spent() < until;) {
      again = false;
      const std::vector<double> from = best(score);
      const auto start = look(from);
      if (!start) return;
      for (Index axis = 0; axis < from.size() && !again; ++axis) {
        const auto count = static_cast<double>(settings_.values[axis]);
        if (count == 0.0) continue;
        for (const double step : {-1.0 / count, 1.0 / count}) {
          std::vector<double> at = from;
          at[axis] = std::clamp(at[axis] + step, 0.0, 1.0);
          if (spent() >= until) return;
          const auto value = look(at);
          again = again || (value && score(*value) > score(*start));
        }
      }
    }
  }

  struct Call {
    Searcher* searcher;
    nlopt_opt optimiser;
    Index until;
    const Score* score;
    std::exception_ptr trouble;
  };

  /// What NLopt calls. Nothing may be thrown through its C code.
  static double call(unsigned count, const double* at, double*, void* data) {
    auto& call = *static_cast<Call*>(data);
    Searcher& self = *call.searcher;
    if (self.spent() >= call.until) {
      nlopt_force_stop(call.optimiser);
      return kImpossible;
    }
    try {
      const auto value = self.look(std::vector<double>(at, at + count));
      return value ? -(*call.score)(*value) : kImpossible;
    } catch (...) {
      call.trouble = std::current_exception();
      nlopt_force_stop(call.optimiser);
      return kImpossible;
    }
  }

  void optimise(nlopt_algorithm algorithm, std::vector<double> from, Index until,
                const Score& score) {
    if (spent() >= until) return;
    const std::unique_ptr<nlopt_opt_s, void (*)(nlopt_opt)> optimiser(
        nlopt_create(algorithm, static_cast<unsigned>(from.size())), nlopt_destroy);
    if (!optimiser) throw std::bad_alloc();
    Call data{this, optimiser.get(), until, &score, nullptr};
    nlopt_set_lower_bounds1(optimiser.get(), 0.0);
    nlopt_set_upper_bounds1(optimiser.get(), 1.0);
    nlopt_set_initial_step1(optimiser.get(), kFirstStep);
    nlopt_set_xtol_abs1(optimiser.get(), 1e-3);  // as fine as options are
    nlopt_set_maxeval(optimiser.get(), kMostRepeats * static_cast<int>(until - spent()));
    nlopt_set_min_objective(optimiser.get(), call, &data);
    double least = 0.0;
    nlopt_optimize(optimiser.get(), from.data(), &least);  // every place is kept by look()
    if (data.trouble) std::rethrow_exception(data.trouble);
  }

  const TradeSettings& settings_;
  std::vector<TradePoint> points_;
  Index failed_ = 0;
  std::map<std::string, std::optional<TradeValue>> known_;
};

}  // namespace

std::vector<TradePoint> search_trade(const TradeSettings& settings) {
  return Searcher(settings).run();
}

std::vector<TradePoint> front_of(const std::vector<TradePoint>& points,
                                 const std::vector<double>& levels, double least) {
  std::vector<double> most = levels;
  most.push_back(std::numeric_limits<double>::infinity());
  std::vector<TradePoint> out;
  for (const double level : most) {
    const TradePoint* best = nullptr;
    for (const TradePoint& point : points) {
      if (point.value.change > level) continue;
      // Of equals the one that changes less, then the one found first.
      if (best == nullptr || point.value.gain > best->value.gain ||
          (point.value.gain == best->value.gain && point.value.change < best->value.change))
        best = &point;
    }
    if (best == nullptr) continue;
    if (out.empty() || best->value.gain >= out.back().value.gain + least) out.push_back(*best);
  }
  return out;
}

}  // namespace backbend::validate
