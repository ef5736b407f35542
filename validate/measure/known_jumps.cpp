#include "validate/measure/known_jumps.h"

#include <type_traits>
#include <utility>
#include <variant>

#include "validate/sweeps/external_spec.h"

namespace backbend::validate {
namespace {

/// All that a search depends on, as bytes.
class Key {
 public:
  Key& add(const std::string& text) {
    add(text.size());
    bytes_ += text;
    return *this;
  }
  template <class Value>
  requires std::is_trivially_copyable_v<Value> Key& add(const Value& value) {
    static_assert(std::has_unique_object_representations_v<Value> ||
                  std::is_floating_point_v<Value> || std::is_same_v<Value, glm::dvec3> ||
                  std::is_same_v<Value, glm::dmat4>);
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
    return *this;
  }
  template <class Item>
  Key& add(const std::vector<Item>& list) {
    add(list.size());
    for (const Item& item : list) add(item);
    return *this;
  }
  Key& add(const PoseDegrees& pose) {
    for (const std::string_view channel : kChannels) add(*pose.find(channel));
    return *this;
  }
  Key& add(const solver::RestChain& chain) {
    add(chain.joint).add(chain.left).add(chain.curve).add(chain.frame.size());
    for (const solver::RestFrame& frame : chain.frame) add(frame.name).add(frame.rig_from_joint);
    return add(chain.path.point).add(chain.path.up);
  }
  Key& add(const solver::SystemSpec& spec) {
    add(spec.system).add(spec.options.size());
    for (const auto& [name, value] : spec.options) {
      add(name).add(value.index());
      std::visit([&](const auto& each) { add(each); }, value);
    }
    return *this;
  }
  Key& add(const Sweep& sweep) {
    add(sweep.from_deg).add(sweep.to_deg).add(sweep.step_deg);
    add(sweep.per_degree).add(sweep.start).add(sweep.through.size());
    for (const Waypoint& point : sweep.through) add(point.control_deg).add(point.pose);
    return *this;
  }
  std::string take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

Key key_of(const Stage& stage, const RigPlan& plan, solver::Mapping mapping) {
  return std::move(Key().add(stage.rest_chain()).add(plan.spec).add(mapping));
}

}  // namespace

template <class Found, class Search>
Found KnownJumps::known(Store<Found>& store, std::string key, const Search& search) {
  {
    const std::lock_guard lock(mutex_);
    const auto kept = store.find(key);
    if (kept != store.end()) {
      kept->second.asked = run_;
      return kept->second.found;
    }
  }
  Found found = search();
  const std::lock_guard lock(mutex_);
  store.insert_or_assign(std::move(key), Kept<Found>{found, run_});
  return found;
}

FlipReport KnownJumps::flips(const Stage& stage, const RigRecord& rig, const Sweep& sweep) {
  if (is_external(rig.plan.spec)) return search_flips(rig, sweep);
  return known(flips_, key_of(stage, rig.plan, rig.mapping).add(sweep).take(),
               [&] { return search_flips(rig, sweep); });
}

FoundJumps KnownJumps::compound(const Stage& stage, const RigPlan& plan,
                                const solver::SpineSystem& system, solver::Mapping mapping,
                                const Envelope& box, Progress& progress) {
  const auto search = [&] { return search_compound(system, mapping, box, &progress); };
  if (is_external(plan.spec)) return search();
  Key key = key_of(stage, plan, mapping);
  key.add(box.extension).add(box.flexion).add(box.side).add(box.twist);
  return known(compound_, key.take(), search);
}

void KnownJumps::forget_unused() {
  const std::lock_guard lock(mutex_);
  const auto unused = [&](const auto& each) { return each.second.asked != run_; };
  std::erase_if(flips_, unused);
  std::erase_if(compound_, unused);
  ++run_;
}

}  // namespace backbend::validate
