#include "validate/measure/measure_job.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <atomic>

#include "validate/measure/records.h"
#include "validate/metrics/chain/rig_probe.h"

namespace backbend::validate {
namespace {

/// Some poses of a sweep, or the search for its jumps.
struct Item {
  std::size_t record = 0, sweep = 0;
  std::size_t first = 0, count = 0;  // count 0: the search
  std::string unit;
  bool done = false;
};

std::vector<Item> items_of(const std::string& character, const std::vector<RigRecord>& records) {
  std::vector<Item> items;
  for (std::size_t r = 0; r < records.size(); ++r) {
    for (std::size_t s = 0; s < records[r].sweeps.size(); ++s) {
      const SweepRecord& sweep = records[r].sweeps[s];
      for (std::size_t first = 0; first < sweep.poses.size(); first += kPosesOfUnit) {
        items.push_back({r, s, first, std::min(kPosesOfUnit, sweep.poses.size() - first),
                         unit_name("poses", character, records[r], sweep.sweep.name, first)});
      }
      items.push_back({r, s, 0, 0, unit_name("jumps", character, records[r], sweep.sweep.name, 0)});
    }
  }
  return items;
}

}  // namespace

std::string unit_name(const std::string& kind, const std::string& character, const RigRecord& rig,
                      const std::string& sweep, std::size_t number) {
  return kind + " " + character + " " + rig.plan.name + " " +
         std::string(mapping_name(rig.mapping)) + " " + sweep + " " + std::to_string(number);
}

bool measure_records(const Stage& stage, const BodyMetrics& body, const std::string& character,
                     std::vector<RigRecord>& records, Ledger& ledger, Progress& progress,
                     KnownJumps* known) {
  std::vector<Item> items = items_of(character, records);
  std::vector<RigAtRest> at_rest;
  for (const RigRecord& rig : records) at_rest.push_back(rig_at_rest(*rig.system));
  std::atomic<bool> complete = true;

  const auto do_item = [&](Item& item) {
    poll_interrupt();
    RigRecord& rig = records[item.record];
    SweepRecord& sweep = rig.sweeps[item.sweep];
    const std::span<PoseRecord> poses = std::span(sweep.poses).subspan(item.first, item.count);
    item.done = true;
    if (const auto found = ledger.find(item.unit)) {
      if (item.count == 0) {
        sweep.flips = unpack_flips(*found);
      } else {
        unpack_poses(*found, poses);
        progress.step(item.count);
      }
    } else if (ledger.mode() == Ledger::Mode::merge) {
      ledger.miss(item.unit);
      complete = false;
    } else if (item.count == 0) {
      sweep.flips =
          known != nullptr ? known->flips(stage, rig, sweep.sweep) : search_flips(rig, sweep.sweep);
      ledger.keep(item.unit, pack_flips(sweep.flips));
    } else {
      measure_poses(stage, body, rig, at_rest[item.record], poses, progress);
      ledger.keep(item.unit, pack_poses(poses));
    }
  };
  for (const bool own : {true, false}) {
    oneapi::tbb::parallel_for(std::size_t{0}, items.size(), [&](std::size_t i) {
      if (!items[i].done && ledger.makes(i) == own) do_item(items[i]);
    });
  }
  if (!complete) return false;
  // What poses take from the search and from each other: last, so that no stored pose comes over
  // it, and everywhere, for it takes no time.
  oneapi::tbb::parallel_for(std::size_t{0}, records.size(), [&](std::size_t r) {
    measure_behaviour(stage, records[r]);
    for (SweepRecord& sweep : records[r].sweeps) take_flips(sweep, std::move(sweep.flips));
  });
  return true;
}

}  // namespace backbend::validate
