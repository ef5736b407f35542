#include "validate/prove/metric_proof.h"

#include <gtest/gtest.h>
#include <oneapi/tbb/task_arena.h>

#include <cstdlib>
#include <fstream>
#include <memory>
#include <random>

#include "solver/math/rotation.h"
#include "tests/skin/gltf_fixture.h"
#include "tests/temporary_folder.h"
#include "tests/validate/figure_stage.h"
#include "tests/validate/prove/proof_refusal.h"
#include "tests/validate/prove/uniform.h"
#include "validate/files/output_folder.h"
#include "validate/prove/bounds_record.h"
#include "validate/prove/chain_bounds.h"
#include "validate/prove/metric_proof_text.h"
#include "validate/prove/proof.h"
#include "validate/prove/surface_bounds.h"
#include "validate/sweeps/suite.h"

namespace backbend::validate {
namespace {

using testing::refusal;
using testing::uniform;

/// A figure, and rigs on its spine.
struct Scene : testing::FigureStage {
  std::unique_ptr<solver::SpineSystem> rig(const std::string& text) const {
    return stage.build(read_rig(text).spec);
  }
  MetricQuestion question(const solver::SpineSystem& system, const std::string& box,
                          std::initializer_list<const char*> claims) const {
    MetricQuestion q;
    q.system = &system;
    q.stage = &stage;
    q.box = read_box(box, *find_envelope("human"), system);
    for (const char* claim : claims) q.claim.push_back(read_claim(claim));
    return q;
  }
};

MetricProof proved(const MetricQuestion& q, int threads = 2) {
  Progress progress(Progress::Style::none);
  MetricProof proof;
  MetricParts parts = parts_not_looked_at(q);
  oneapi::tbb::task_arena(threads).execute([&] { proof = prove_metrics(q, parts, progress); });
  return proof;
}

/// What every claim rests on: no pose of a box is worse than the box's bounds.
/// BACKBEND_PROOF_POSES=100000 runs the battery of docs/batteries.md.
TEST(MetricProof, NoPoseOfABoxIsWorseThanItsBounds) {
  const Scene scene;
  const SurfaceBounds surface(scene.stage, scene.body);
  std::mt19937 random(6);
  const char* asked = std::getenv("BACKBEND_PROOF_POSES");
  const std::size_t boxes = asked ? std::size_t(std::atol(asked)) / 12 : 25;
  std::size_t told = 0, near = 0, proved_some = 0;
  for (const char* name : {"even", "three_bone", "matrix_blend", "isner"}) {
    const auto system = scene.rig(name);
    const RigAtRest rest = rig_at_rest(*system);
    const solver::BoxSolver& solver = box_solver_of(*system);
    const ProofBox whole = read_box("envelope", *find_envelope("human"), *system);
    const PoseOfBox controls(whole, *system, solver::Mapping::chest);
    for (std::size_t i = 0; i < boxes; ++i) {
      SubBox part;
      const double width = i % 2 == 0 ? 1.0 : 4.0;
      for (std::size_t j = 0; j < part.low.size(); ++j) {
        part.low[j] = 45.0 * uniform(random);
        part.high[j] = part.low[j] + width;
      }
      solver::BoxPlaces places;
      solver.place_box(controls_over(whole, *system, solver, solver::Mapping::chest, part), places);
      const RelativeMotions motions(scene.stage.driver().motions_over(*system, places),
                                    surface.pairs());
      std::vector<std::uint32_t> triangle = surface.triangles(), slice = surface.slices();
      const std::size_t all = triangle.size();
      const double inverted = surface.keep_unproved(motions, triangle);
      const double area = surface.keep_small(motions, 0.0, slice).taken_out;
      proved_some += triangle.size() < all / 2;
      for (int sample = 0; sample < 3; ++sample) {
        std::array<double, kProofAxes> pose{};
        for (std::size_t j = 0; j < pose.size(); ++j)
          pose[j] = part.low[j] + width * (0.5 + 0.5 * uniform(random));
        const std::vector<double> control = controls.at(pose);
        const PosedCharacter posed = scene.stage.pose(*system, control);
        const BodyMeasures measured =
            scene.body.measure(rest, control, posed.spine, posed.mesh, solver::radians(pose[2]),
                               false, Crossing::left_out, posed.world_from_node);
        EXPECT_LE(measured.surface.inverted_area, inverted + 1e-9) << name;
        if (std::isfinite(area)) {
          EXPECT_GE(measured.slices.least_area_ratio, area - 1e-5) << name;
          near += measured.slices.least_area_ratio < area + 0.05;
        }
        const auto bounded = [&](const char* check, double value) {
          EXPECT_LE(value, most_of_chain(check, *system, places) + 1e-6) << name << " " << check;
        };
        bounded("BB020", measured.chain.arms.rotation_deg);
        bounded("BB021", 100.0 * measured.chain.arms.shift);
        bounded("BB041", 100.0 * measured.chain.end_gap);
        bounded("BB047", 100.0 * measured.chain.length_change);
        ++told;
      }
    }
  }
  EXPECT_EQ(told, 12 * boxes);
  EXPECT_GT(near, told / 3);  // bounds that say something
  EXPECT_GT(proved_some, 3 * boxes);
}

TEST(MetricProof, AHealthyRigIsCertifiedOverTheWholeBox) {
  const Scene scene;
  const auto system = scene.rig("even");
  const MetricProof proof = proved(scene.question(
      *system, "extension=-60:40,side=-30:30,twist=-20:20", {"BB020", "BB030", "BB033", "BB047"}));
  for (const ClaimResult& claim : proof.claim) {
    EXPECT_EQ(claim.certified, 1.0);
    EXPECT_EQ(claim.refuted + claim.open, 0.0);
    EXPECT_FALSE(claim.measured);
  }
  EXPECT_TRUE(proof.undecided.empty());
}

/// The whole is its parts, whatever each came to, and what is refuted breaks its limit when it is
/// measured again.
TEST(MetricProof, ALimitThatPosesBreakIsRefutedWhereTheyDo) {
  const Scene scene;
  const auto system = scene.rig("isner");
  const MetricQuestion q =
      scene.question(*system, "extension=0:60,side=-10:10", {"BB020", "BB030=0.97"});
  const MetricProof proof = proved(q);
  for (std::size_t i = 0; i < q.claim.size(); ++i) {
    const ClaimResult& claim = proof.claim[i];
    EXPECT_NEAR(claim.certified + claim.refuted + claim.open, 1.0, 1e-12);
    EXPECT_GT(claim.refuted, 0.1);
    EXPECT_TRUE(claim.measured);
    EXPECT_EQ(judge(*q.claim[i].check, claim.worst, q.claim[i].limit), Verdict::fail);
    double refuted = 0.0;
    for (const UndecidedBox& box : proof.undecided)
      if (box.state[i] == ClaimState::refuted) refuted += share_of(box.box, q.box);
    EXPECT_NEAR(refuted, claim.refuted, 1e-12);
  }
  const PoseOfBox controls(q.box, *system, q.mapping);
  const solver::SpinePose pose = system->solve(controls.at(proof.claim[0].pose));
  EXPECT_NEAR(solver::degrees(solver::angle_between(pose.arms.turn, pose.chest.turn)),
              proof.claim[0].worst, 1e-6);
  const std::string text = metric_proof_text(q, proof, "isner", TerminalStyle{});
  EXPECT_NE(text.find("BB030 cross-section collapse, at least 0.97"), std::string::npos) << text;
  EXPECT_NE(text.find("x refuted"), std::string::npos) << text;
}

/// What is proved of a whole box holds for the slices that were told apart early, too, and one
/// limit says nothing of a stricter one.
TEST(MetricProof, TheProvedAreaHoldsForAllSlicesAndEachLimitForItself) {
  const Scene scene;
  const auto system = scene.rig("even");
  const char* box = "extension=-80:50,side=-30:30,twist=-40:40";
  MetricQuestion q = scene.question(*system, box, {"BB030=0.5", "BB030=0.8", "BB030=0.99"});
  q.smallest = 12.0;
  const MetricProof proof = proved(q);
  const RigAtRest rest = rig_at_rest(*system);
  const PoseOfBox controls(q.box, *system, q.mapping);
  std::mt19937 random(18);
  double least = 1.0;
  for (int i = 0; i < 200; ++i) {
    std::array<double, kProofAxes> pose{};
    for (std::size_t j = 0; j < pose.size(); ++j) {
      // The ends of the box are where slices are smallest.
      const double share = std::clamp(0.5 + 0.7 * uniform(random), 0.0, 1.0);
      pose[j] = q.box.axis[j].low + q.box.axis[j].width() * share;
    }
    const std::vector<double> control = controls.at(pose);
    const PosedCharacter posed = scene.stage.pose(*system, control);
    least = std::min(least, scene.body
                                .measure(rest, control, posed.spine, posed.mesh,
                                         solver::radians(pose[2]), false, Crossing::left_out)
                                .slices.least_area_ratio);
  }
  EXPECT_EQ(proof.claim[0].certified, 1.0);
  EXPECT_GE(least, proof.claim[0].bound);
  EXPECT_GE(proof.claim[0].bound, 0.5);
  // Alone, each comes to the same.
  for (std::size_t i = 0; i < q.claim.size(); ++i) {
    MetricQuestion one = q;
    one.claim = {q.claim[i]};
    const ClaimResult alone = proved(one).claim[0];
    EXPECT_EQ(alone.certified, proof.claim[i].certified) << i;
    EXPECT_EQ(alone.bound, proof.claim[i].bound) << i;
    EXPECT_EQ(alone.refuted, proof.claim[i].refuted) << i;
  }
  EXPECT_LT(least, 0.99);
  EXPECT_GT(proof.claim[2].refuted, 0.0);
}

TEST(MetricProof, TheResultDoesNotDependOnTheNumberOfThreads) {
  const Scene scene;
  const auto system = scene.rig("isner");
  const MetricQuestion q = scene.question(*system, "extension=20:40,side=-10:10", {"BB020=8"});
  EXPECT_EQ(metric_proof_json(q, proved(q, 1), "isner"),
            metric_proof_json(q, proved(q, 2), "isner"));
}

TEST(MetricProof, GoesOnFromItsRecordAsIfItHadNotStopped) {
  const TemporaryFolder folder;
  const Scene scene;
  const auto system = scene.rig("isner");
  const MetricQuestion q =
      scene.question(*system, "extension=20:40,side=-10:10", {"BB020=8", "BB041=0.001"});
  const std::string text = bounds_question(q, "isner", scene.stage.rest_chain());
  Progress progress(Progress::Style::none);
  MetricParts whole = parts_not_looked_at(q);
  const std::string told = metric_proof_json(q, prove_metrics(q, whole, progress), "isner");
  ASSERT_GT(whole.size(), 10u);
  MetricParts some = whole;
  for (std::size_t i = 0; i < some.size(); i += 2) some[i].reset();
  const std::filesystem::path file = folder / "search.json";
  write_bounds_record(file, text, some);
  MetricParts read = read_bounds_record(file, q, text);
  ASSERT_EQ(read.size(), some.size());
  EXPECT_FALSE(read[0]);
  ASSERT_TRUE(read[1]);
  EXPECT_EQ(read[1]->looked_at, whole[1]->looked_at);
  EXPECT_EQ(metric_proof_json(q, prove_metrics(q, read, progress), "isner"), told);

  // What is not the record of this search is refused by what is wrong with it.
  const MetricQuestion other = scene.question(*system, "extension=20:41,side=-10:10", {"BB020=8"});
  const auto refused = [&](const MetricQuestion& asked) {
    return refusal([&] {
      read_bounds_record(file, asked, bounds_question(asked, "isner", scene.stage.rest_chain()));
    });
  };
  EXPECT_NE(refused(other).find("its box is not the same"), std::string::npos);
  const std::string good = read_text(file);
  const auto changed = [&](const std::string& with) {
    std::ofstream(file) << with;
    return refused(q);
  };
  EXPECT_NE(changed(good.substr(0, good.size() / 2)).find("cut short"), std::string::npos);
  std::string forged = good;
  forged.replace(forged.find("\"looked_at\":") + 12, 1, "9");
  EXPECT_NE(changed(forged).find("hash"), std::string::npos);
  EXPECT_NE(changed("{\"schema\": \"backbend.certificate/1\"}").find("schema"), std::string::npos);
  write_bounds_record(file, text, MetricParts(3));
  EXPECT_NE(refused(q).find("search.json: its parts do not fill the box"), std::string::npos);
}

TEST(MetricProof, TrianglesOfOneMotionAloneAreNotLookedAt) {
  const Scene scene;
  const SurfaceBounds surface(scene.stage, scene.body);
  const auto system = scene.rig("even");
  const solver::BoxSolver& solver = box_solver_of(*system);
  EXPECT_LT(surface.triangles().size(), scene.stage.character().triangles.size());
  EXPECT_GT(surface.triangles().size(), 0u);
  EXPECT_FALSE(surface.slices().empty());
  // A box of the rest pose alone proves them all, with the rings as large as they are.
  const ProofBox whole = read_box("envelope", *find_envelope("human"), *system);
  solver::BoxPlaces places;
  solver.place_box(controls_over(whole, *system, solver, solver::Mapping::chest, SubBox{}), places);
  const RelativeMotions motions(scene.stage.driver().motions_over(*system, places),
                                surface.pairs());
  std::vector<std::uint32_t> triangle = surface.triangles(), slice = surface.slices();
  EXPECT_EQ(surface.keep_unproved(motions, triangle), 0.0);
  EXPECT_TRUE(triangle.empty());
  EXPECT_NEAR(surface.keep_small(motions, 0.5, slice).taken_out, 1.0, 1e-5);
  EXPECT_TRUE(slice.empty());
}

TEST(MetricProof, WhatCannotBeAskedIsRefusedByName) {
  EXPECT_NE(refusal([] { read_claim("BB011"); }).find("BB010, BB020, BB021"), std::string::npos);
  EXPECT_NE(refusal([] { read_claim("BB030=high"); }).find("'BB030=high'"), std::string::npos);
  const MetricClaim claim = read_claim("BB030=0.8");
  EXPECT_EQ(claim.limit, 0.8);
  EXPECT_EQ(read_claim("BB030").limit, find_check("BB030")->limit);
  const Scene scene;
  Progress progress(Progress::Style::none);
  const auto system = scene.rig("even");
  MetricQuestion q = scene.question(*system, "envelope", {"BB033"});
  q.stage = nullptr;
  MetricParts parts = parts_not_looked_at(q);
  EXPECT_NE(refusal([&] { prove_metrics(q, parts, progress); }).find("--character"),
            std::string::npos);
  const auto snake = scene.rig("snake");
  const MetricQuestion other = scene.question(*snake, "envelope", {"BB010", "BB033"});
  EXPECT_NE(refusal([&] { prove_metrics(other, parts, progress); }).find("snake"),
            std::string::npos);
}

TEST(MetricProof, KinksAreBoundedWithoutTheJointsPlaces) {
  const Scene scene;
  for (const char* name :
       {"even", "isner", "spline_ik", "stretchy", "snake", "neck", "matrix_blend:pivot_pos=0"}) {
    SCOPED_TRACE(name);
    const auto system = scene.rig(name);
    MetricQuestion q =
        scene.question(*system, "extension=-40:50,side=-30:30,twist=-60:60", {"BB010"});
    const MetricProof proof = proved(q);
    EXPECT_EQ(proof.claim[0].certified, 1.0);
    EXPECT_GT(proof.claim[0].bound, 0.0);
    EXPECT_LE(proof.claim[0].bound, 2.0);
    // Twist leaves these curves as they are: no part is split along it.
    EXPECT_LT(proof.looked_at, 3000u);
    // The same beside a claim about places, where those are known.
    if (!box_solver_of(*system).why_no_places().empty()) continue;
    q = scene.question(*system, "extension=20:20.4,side=-0.2:0.2", {"BB010", "BB047=50"});
    const MetricProof both = proved(q);
    EXPECT_EQ(both.claim[0].certified, 1.0);
    EXPECT_EQ(both.claim[1].certified, 1.0);
  }
}

TEST(MetricProof, OfASnakeTheHeadIsChestAndArmsAndItsBonesKeepTheirLengths) {
  const Scene scene;
  const auto snake = scene.rig("snake");
  const MetricProof proof = proved(
      scene.question(*snake, "stress", {"BB020=0.0", "BB021=0.0", "BB041=0.0", "BB047=0.000001"}));
  for (const ClaimResult& claim : proof.claim) EXPECT_EQ(claim.certified, 1.0);
}

/// Every pose of such a box is bad, so nothing is gained by smaller ones.
TEST(MetricProof, WhatIsBrokenAllOverABoxIsNotSplit) {
  const Scene scene;
  const auto system = scene.rig("three_bone");
  const char* box = "extension=-60:-40,side=10:30,twist=-10:10";
  const MetricProof proof = proved(scene.question(*system, box, {"BB010"}));
  EXPECT_EQ(proof.claim[0].refuted, 1.0);
  EXPECT_GT(proof.claim[0].worst, 20.0);
  EXPECT_LE(proof.looked_at, 256u);
  // Beside a claim that holds at some of its poses it is.
  const MetricProof both = proved(scene.question(*system, box, {"BB010", "BB041=0.0"}));
  EXPECT_EQ(both.claim[0].refuted, 1.0);
  EXPECT_EQ(both.claim[1].certified, 1.0);
  MetricQuestion q = scene.question(*system, box, {"BB010=27"});
  q.smallest = 0.5;
  const MetricProof near = proved(q);
  EXPECT_GT(near.looked_at, 256u);
  EXPECT_GT(near.claim[0].refuted, 0.1);
  EXPECT_GT(near.claim[0].certified, 0.1);
}

TEST(MetricProof, AKinkBeyondItsLimitIsRefutedByAPose) {
  const Scene scene;
  const auto system = scene.rig("spline_ik");
  const MetricProof proof =
      proved(scene.question(*system, "extension=-90:-80,side=-45:-40", {"BB010=0.4"}));
  EXPECT_GT(proof.claim[0].refuted, 0.5);
  EXPECT_GT(proof.claim[0].worst, 0.6);
  EXPECT_LT(proof.claim[0].pose[0], -80.0);
}

}  // namespace
}  // namespace backbend::validate
