#include "validate/night/image_pass.h"

#include <gtest/gtest.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <utility>

#include "validate/calibrate/calibration_body.h"
#include "validate/measure/measure_job.h"
#include "validate/sweeps/suite.h"

namespace backbend::validate {
namespace {

/// A round body under the Isner spine, bent backwards past its first flip.
class LookingAtIsner : public testing::Test {
 protected:
  LookingAtIsner()
      : body_(tube_body(24)),
        record_(measure_chain_only(body_->stage(), read_rig("isner"), solver::Mapping::chest,
                                   {channel_sweep("extension", 0, 130, 5)},
                                   *find_envelope("sweep"))),
        context_{body_->stage(), limits_, envelope_, "tube.glb"},
        cameras_(body_->stage(), render::bounds_of(body_->stage().rest().position)),
        pass_(cameras_, "tube", ledger_),
        findings_(judge_rig(record_, context_)) {
    std::erase_if(findings_, [](const Finding& each) { return each.code != "BB001"; });
  }
  void look_with(ImagePass& pass, std::vector<Finding>& findings) {
    pass.look({&record_, 1}, {&findings, 1}, progress_);
  }
  std::vector<Finding> look() {
    look_with(pass_, findings_);
    return pass_.contradictions(record_, findings_, context_);
  }

  std::unique_ptr<CalibrationBody> body_;
  RigRecord record_;
  LimitSet limits_;
  Envelope envelope_ = *find_envelope("sweep");
  JudgeContext context_;
  Ledger ledger_;
  PhotographerPool cameras_;
  ImagePass pass_;
  Progress progress_{Progress::Style::none};
  std::vector<Finding> findings_;
};

TEST_F(LookingAtIsner, PicturesShowTheFlipsThatGeometryFoundAndNoOthers) {
  ASSERT_GE(findings_.size(), 2u);
  EXPECT_TRUE(look().empty());
  for (const Finding& flip : findings_) EXPECT_TRUE(flip.image.visible) << flip.detail;
}

TEST_F(LookingAtIsner, SeesTheSameWithAnyNumberOfThreads) {
  ASSERT_GT(record_.sweeps[0].poses.size(), kPosesOfUnit);  // in several units, then
  const auto seen_by = [&](int threads) {
    ImagePass pass(cameras_, "tube", ledger_);
    std::vector<Finding> findings = findings_;
    oneapi::tbb::task_arena(threads).execute([&] { look_with(pass, findings); });
    RigResult result;
    result.sweeps.push_back({});
    result.sweeps[0].sweep = "extension";
    pass.add_series(record_, result);
    std::vector<double> values;
    for (const auto& [name, series] : result.sweeps[0].metric)
      values.insert(values.end(), series.begin(), series.end());
    for (const Finding& finding : findings) values.push_back(finding.image.value);
    return values;
  };
  const std::vector<double> one = seen_by(1);
  ASSERT_EQ(one.size(), 3 * record_.sweeps[0].poses.size() + findings_.size());
  EXPECT_EQ(seen_by(4), one);
}

TEST_F(LookingAtIsner, AJumpThatGeometryDeniesIsSeenAllTheSame) {
  findings_.clear();
  FlipReport& flips = record_.sweeps[0].flips;
  ASSERT_TRUE(flips.certified);
  const std::vector<Jump> jumps = std::exchange(flips.jumps, {});
  std::ranges::fill(flips.interval_gain, 1.0);
  const std::vector<Finding> found = look();
  ASSERT_FALSE(found.empty());
  EXPECT_EQ(found[0].code, "BB070");
  EXPECT_EQ(found[0].owner, Owner::tool);
  EXPECT_EQ(found[0].verdict, Verdict::stress);
  EXPECT_EQ(found[0].geometry.count("picture_only"), 1u);
  for (const Finding& each : found)
    EXPECT_TRUE(std::ranges::any_of(jumps, [&](const Jump& jump) {
      const double at = 130.0 * jump.t;  // between two poses, whose motions before and after differ
      return each.control_deg > at && each.control_deg < at + 10.0;
    })) << each.control_deg;
}

TEST_F(LookingAtIsner, ALargeFlipThatNoPictureShowsIsAContradiction) {
  look_with(pass_, findings_);
  findings_.resize(1);
  findings_[0].image.visible = false;
  findings_[0].value = 90.0;
  const std::vector<Finding> found = pass_.contradictions(record_, findings_, context_);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NE(found[0].detail.find("BB001 measures 90 deg and no picture shows it"),
            std::string::npos)
      << found[0].detail;
  findings_[0].value = 2.0;  // smaller than what pictures can be held to
  EXPECT_TRUE(pass_.contradictions(record_, findings_, context_).empty());
}

/// What pictures say of one kink on the round body, bent forwards by 60 degrees.
ImageWitness witness_of_kink(const char* rig, Owner owner) {
  const auto body = tube_body(8);
  const RigRecord record =
      measure_chain_only(body->stage(), read_rig(rig), solver::Mapping::chest,
                         {channel_sweep("flexion", 0, 90, 30)}, *find_envelope("sweep"));
  Finding kink;
  kink.code = "BB011";
  kink.rig = record.plan.name;
  kink.at.sweep = 0;
  kink.control_deg = 60.0;
  kink.at.pose = 2;
  kink.owner = owner;
  std::vector<Finding> findings{kink};
  Ledger ledger;
  PhotographerPool cameras(body->stage(), render::bounds_of(body->stage().rest().position));
  ImagePass pass(cameras, "tube", ledger);
  Progress progress(Progress::Style::none);
  pass.look({&record, 1}, {&findings, 1}, progress);
  return findings[0].image;
}

TEST(KinkWitness, OfAnotherRigIsTheIdealBendSeenFromTheSideThatShowsIt) {
  const ImageWitness witness = witness_of_kink("three_bone", Owner::solver);
  EXPECT_TRUE(witness.measured);
  EXPECT_EQ(witness.camera, "profile");
  EXPECT_NE(witness.note.find("'even'"), std::string::npos) << witness.note;
  EXPECT_GT(witness.value, 1.0) << "three bones cut the corners of an even bend";
}

TEST(KinkWitness, OfTheIdealBendIsNeverItself) {
  ImageWitness witness = witness_of_kink("even", Owner::weights);
  EXPECT_TRUE(witness.measured);
  EXPECT_EQ(witness.note.find("'even'"), std::string::npos) << witness.note;
  EXPECT_NE(witness.note.find("clean proxy weights"), std::string::npos) << witness.note;
  witness = witness_of_kink("even", Owner::skeleton);
  EXPECT_FALSE(witness.measured);
  EXPECT_NE(witness.note.find("not applicable"), std::string::npos) << witness.note;
}

}  // namespace
}  // namespace backbend::validate
