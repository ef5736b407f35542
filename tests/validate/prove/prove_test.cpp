#include <gtest/gtest.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <random>

#include "solver/math/rotation.h"
#include "tests/validate/prove/proof_refusal.h"
#include "validate/files/hash.h"
#include "validate/prove/certificate_check.h"
#include "validate/prove/claim_checker.h"
#include "validate/prove/proof_text.h"
#include "validate/prove/refute.h"

namespace backbend::validate {
namespace {

ProofQuestion question(const std::string& system, const std::string& box, double smallest = 1.0,
                       std::uint64_t boxes = 100000) {
  ProofQuestion q;
  q.rig.system = system;
  q.chain.joint = {{0, 0, 0}, {0, 2, 0}, {0, 4, 0}, {0, 6, 0}};
  const auto built = solver::build_system(q.rig, q.chain);
  q.box = read_box(box, *find_envelope("human"), *built);
  q.smallest = smallest;
  q.boxes = boxes;
  return q;
}

Certificate proved(const ProofQuestion& q, int threads = 2) {
  Certificate proof{q, {}};
  const auto system = solver::build_system(q.rig, q.chain);
  Progress progress(Progress::Style::none);
  oneapi::tbb::task_arena(threads).execute([&] { prove(q, *system, proof.tree, progress); });
  return proof;
}

using testing::refusal;

TEST(Prove, EvenIsCertifiedOnTheWholeHumanEnvelopeWithAGainOfOne) {
  const Certificate proof = proved(question("even", "envelope"));
  const ProofShares shares = shares_of(proof.tree, proof.question.box);
  EXPECT_EQ(shares.certified, 1.0);
  EXPECT_EQ(shares.open, 0.0);
  EXPECT_LE(proof.tree.gain_bound, 1.0 + 1e-11);
  EXPECT_GE(proof.tree.gain_bound, 1.0);
}

TEST(Prove, EvenIsNotCertifiedForAGainThatItsPosesBreak) {
  ProofQuestion q = question("even", "extension=-30:30,side=-20:20,twist=-30:30", 20.0);
  q.gain = 0.9;
  const Certificate proof = proved(q);
  const ProofShares shares = shares_of(proof.tree, q.box);
  EXPECT_EQ(shares.refuted, 1.0);
  EXPECT_EQ(shares.no_jump, 1.0);
  for (const Refutation& r : proof.tree.refutation) {
    EXPECT_EQ(r.check, "BB002");
    EXPECT_NEAR(r.value, 1.0, 1e-6);
  }
}

// The flips of docs/rigs/isner.md, pitched back in place.
TEST(Prove, TheSnakeAndTheCurveSpineAreCertifiedOnTheWholeHumanEnvelope) {
  for (const char* rig : {"snake", "curve"}) {
    const Certificate proof = proved(question(rig, "envelope"));
    EXPECT_EQ(shares_of(proof.tree, proof.question.box).certified, 1.0) << rig;
    // Twist alone rolls the bones, by fixed shares: it is not split.
    const bool splits_twist =
        std::any_of(proof.tree.node.begin(), proof.tree.node.end(),
                    [](const ProofNode& n) { return n.state == BoxState::split && n.axis == 2; });
    EXPECT_FALSE(splits_twist) << rig;
  }
}

TEST(Prove, WhatIsNotCertifiedOfIsnersPitchEnclosesItsFourFlipsClosely) {
  const Certificate proof = proved(question("isner", "extension=0:180,side=0,twist=0", 0.005));
  const double flips[] = {100.8696, 114.2744, 116.2357, 180.0};
  std::vector<double> found;
  for (const Refutation& r : proof.tree.refutation) {
    if (r.check != "BB001") continue;
    EXPECT_NEAR(r.value, 180.0, 1e-3);
    found.push_back(r.pose[0]);
  }
  std::sort(found.begin(), found.end());
  ASSERT_EQ(found.size(), std::size(flips));
  for (std::size_t i = 0; i < found.size(); ++i) EXPECT_NEAR(found[i], flips[i], 2e-3);
  each_leaf(proof.tree, proof.question.box, [&](const SubBox& box, const ProofNode& node) {
    for (const double flip : flips) {
      if (box.low[0] > flip || box.high[0] < flip) continue;
      EXPECT_NE(node.state, BoxState::certified) << "a flip at " << flip << " was certified";
    }
    if (node.state != BoxState::refuted) return;
    EXPECT_LT(box.high[0] - box.low[0], 0.01);
  });
}

// Bones that keep the roll of their parent do not follow the chest's twist.
TEST(Prove, AnAxisAlongWhichNothingTurnsIsNotSplit) {
  const Certificate proof =
      proved(question("spline_ik", "extension=20:40,side=10:20,twist=-60:60"));
  EXPECT_EQ(shares_of(proof.tree, proof.question.box).certified, 1.0);
  int split = 0;
  for (const ProofNode& node : proof.tree.node) {
    if (node.state != BoxState::split) continue;
    ++split;
    EXPECT_LT(node.axis, 2);
  }
  EXPECT_GT(split, 4);
}

TEST(Prove, GivesTheSameTreeForAnyNumberOfThreads) {
  const ProofQuestion q = question("isner", "extension=80:120,side=-10:10,twist=0", 0.7, 3000);
  const std::string one = certificate_text(proved(q, 1));
  EXPECT_EQ(one, certificate_text(proved(q, 2)));
  const ProofShares shares = shares_of(proved(q).tree, q.box);
  EXPECT_GT(shares.certified_boxes, 10u);
  EXPECT_GT(shares.refuted_boxes, 0u);
  EXPECT_NEAR(shares.certified + shares.refuted + shares.open, 1.0, 1e-12);
}

/// What was decided of every other box is taken away again.
TEST(Prove, GoesOnFromAnInterruptedSearchAsIfThereHadBeenNone) {
  const ProofQuestion q = question("isner", "extension=85:110,side=-8:8,twist=0", 0.7);
  const Certificate whole = proved(q);
  Certificate cut = whole;
  std::size_t pruned = 0;
  for (ProofNode& node : cut.tree.node) {
    if (node.state == BoxState::split || ++pruned % 2 == 0) continue;
    node.state = BoxState::pending;
    --cut.tree.looked_at;
  }
  ASSERT_FALSE(cut.tree.is_complete());
  cut = parse_certificate(certificate_text(cut), "cut");
  const auto system = solver::build_system(q.rig, q.chain);
  Progress progress(Progress::Style::none);
  prove(q, *system, cut.tree, progress);
  EXPECT_TRUE(cut.tree.is_complete());
  EXPECT_EQ(certificate_text(cut), certificate_text(whole));
}

/// Every system, by the plain solver. BACKBEND_PROOF_POSES=10000000 runs the battery of
/// docs/batteries.md: so many poses of each.
TEST(Prove, RandomPosesRefuteNoCertifiedBox) {
  struct Proved {
    const char* system;
    const char* box;
    double smallest, gain;
  };
  const char* part = "extension=20:60,side=-10:10,twist=-8:8";
  const Proved all[] = {{"isner", part, 0.5, 2.0},
                        {"isner", "envelope", 4.0, 8.0},
                        {"stretchy", "extension=20:30,side=-5:5,twist=-8:8", 0.3, 8.0},
                        {"curve", part, 1.0, 4.0},
                        {"curve", "envelope", 4.0, 8.0},
                        {"snake", "envelope", 1.0, 4.0},
                        {"spline_ik", "envelope", 1.0, 4.0},
                        {"matrix_blend", "envelope", 1.0, 4.0},
                        {"three_bone", "envelope", 1.0, 1.001},
                        {"neck", "envelope", 1.0, 1.001},
                        {"even", "envelope", 1.0, 1.001}};
  const char* asked = std::getenv("BACKBEND_PROOF_POSES");
  const long poses = asked ? std::atol(asked) : 2000;
  std::mt19937 random(1);
  for (const Proved& own : all) {
    ProofQuestion q = question(own.system, own.box, own.smallest, 20000);
    q.gain = own.gain;
    const Certificate proof = proved(q);
    const auto system = solver::build_system(q.rig, q.chain);
    std::vector<SubBox> certified;
    each_leaf(proof.tree, q.box, [&](const SubBox& box, const ProofNode& node) {
      if (node.state == BoxState::certified) certified.push_back(box);
    });
    ASSERT_GT(shares_of(proof.tree, q.box).certified, 0.1) << own.system;
    const Refuter plain(q, *system);
    for (long i = 0; i < poses; ++i) {
      const SubBox& box = certified[random() % certified.size()];
      Refutation claim;
      claim.axis = int(random() % 3);
      claim.check = "BB002";
      for (std::size_t j = 0; j < 3; ++j) {
        const double f = double(random()) / 4294967296.0;
        claim.pose[j] = box.low[j] + f * (0.999 * (box.high[j] - box.low[j]));
      }
      ASSERT_LE(plain.measure(claim), q.gain * (1.0 + 1e-6))
          << own.system << ' ' << pose_text(q.box, claim.pose);
    }
  }
}

TEST(Certificate, IsReadBackAsItWasWritten) {
  const Certificate proof = proved(question("isner", "extension=95:105,side=0,twist=0", 0.1));
  const std::string text = certificate_text(proof);
  EXPECT_EQ(certificate_text(parse_certificate(text, "c")), text);
}

std::string rehashed(nlohmann::ordered_json json) {
  json.erase("hash");
  json["hash"] = content_hash(json.dump());
  return json.dump();
}

TEST(Certificate, ThatIsCutOrChangedOrAnotherSchemaIsRefused) {
  const std::string text = certificate_text(proved(question("even", "envelope")));
  const auto why = [](const std::string& changed) {
    return refusal([&] { parse_certificate(changed, "c.json"); });
  };
  EXPECT_NE(why(text.substr(0, text.size() / 2)).find("cut short"), std::string::npos);
  EXPECT_NE(why("{}").find("no schema"), std::string::npos);
  std::string changed = text;
  changed.replace(changed.find("8.0"), 3, "2.0");
  EXPECT_NE(why(changed).find("hash does not fit"), std::string::npos);
  nlohmann::ordered_json json = nlohmann::ordered_json::parse(text);
  json["schema"] = "backbend.certificate/9";
  EXPECT_NE(why(rehashed(json)).find("certificate/9"), std::string::npos);
}

TEST(Certificate, OfARigInAFileIsRefusedUnread) {
  nlohmann::ordered_json json =
      nlohmann::ordered_json::parse(certificate_text(proved(question("even", "envelope"))));
  json["question"]["rig"] = "somewhere/else.toml";
  EXPECT_NE(refusal([&] { parse_certificate(rehashed(json), "c.json"); }).find("the rig is a file"),
            std::string::npos);
}

TEST(Certificate, WhoseBoxesDoNotFillTheWholeIsRefused) {
  const nlohmann::ordered_json json =
      nlohmann::ordered_json::parse(certificate_text(proved(question("even", "envelope"))));
  for (const char* tree : {"0C", "CC", "", "3CC", "Z", "0CR"}) {
    nlohmann::ordered_json forged = json;
    forged["tree"] = tree;
    EXPECT_NE(refusal([&] { parse_certificate(rehashed(forged), "c.json"); }), "") << tree;
  }
}

TEST(CertificateCheck, HoldsForWhatWasProved) {
  Progress progress(Progress::Style::none);
  for (const char* system : {"even", "three_bone", "neck", "matrix_blend"}) {
    const Certificate proof = proved(question(system, "envelope"));
    const CertificateCheck check = check_certificate(proof, "c", progress);
    EXPECT_EQ(check.certified, shares_of(proof.tree, proof.question.box).certified_boxes) << system;
    EXPECT_LE(check.gain_bound, 1.0 + 1e-11) << system;
  }
}

TEST(CertificateCheck, ConfirmsIsnersBoxesByItsOwnEvaluation) {
  Progress progress(Progress::Style::none);
  for (const char* box :
       {"extension=20:40,side=-5:15,twist=-20:0", "extension=90:120,side=0,twist=0"}) {
    const Certificate proof = proved(question("isner", box, 0.05));
    const CertificateCheck check = check_certificate(proof, "c", progress);
    EXPECT_GT(check.certified, 20u);
    EXPECT_LE(check.gain_bound, proof.tree.gain_bound * (1.0 + 1e-9));
    EXPECT_EQ(check.refuted, proof.tree.refutation.size());
  }
}

TEST(CertificateCheck, NoPoseOutrunsTheBlendCheckersBounds) {
  std::mt19937 random(8);
  const auto uniform = [&] { return 2.0 * double(random()) / 4294967296.0 - 1.0; };
  for (const double pivot : {0.0, 1.0, 3.0, 5.0}) {
    ProofQuestion q = question("matrix_blend", "extension=-170:170,side=-90:90,twist=-90:90");
    q.rig.options["bones"] = 6.0;
    q.rig.options["pivot_pos"] = pivot;
    const auto system = solver::build_system(q.rig, q.chain);
    const auto checker = blend_checker(q, *system);
    const Refuter plain(q, *system);
    double largest = 0.0;
    for (int i = 0; i < 300; ++i) {
      SubBox box;
      Refutation at;
      at.check = "BB002";
      at.axis = i % 3;
      const double reach[] = {160.0, 60.0, 60.0};
      for (std::size_t j = 0; j < 3; ++j) {
        at.pose[j] = reach[j] * uniform();
        box.low[j] = at.pose[j] - 0.1;
        box.high[j] = at.pose[j] + 0.1;
      }
      const double bound = checker->gain_over(box), gain = plain.measure(at);
      ASSERT_LE(gain, bound * (1.0 + 1e-6)) << pose_text(q.box, at.pose);
      largest = std::max(largest, gain / bound);
    }
    EXPECT_GT(largest, 0.9) << pivot;
  }
}

/// A checker's bounds hold for poses of the plain solver, to `extension`, and in more than
/// `least_sharp` of 400 boxes a pose comes to `near` of them.
void expect_bounds(const ProofQuestion& q, const solver::SpineSystem& system,
                   const ClaimChecker& checker, double extension, double near, int least_sharp) {
  std::mt19937 random(7);
  const auto uniform = [&] { return 2.0 * double(random()) / 4294967296.0 - 1.0; };
  const Refuter plain(q, system);
  int finite = 0, sharp = 0;
  for (int i = 0; i < 400; ++i) {
    SubBox box;
    const double width = i % 2 == 0 ? 0.1 : 1.0;
    const double reach[] = {extension, 60.0, 60.0};
    for (std::size_t j = 0; j < 3; ++j) {
      box.low[j] = reach[j] * uniform();
      box.high[j] = box.low[j] + width;
    }
    const double bound = checker.gain_over(box);
    if (!std::isfinite(bound)) continue;
    ++finite;
    double most = 0.0;
    for (int k = 0; k < 6; ++k) {
      Refutation at;
      at.check = "BB002";
      at.axis = k % 3;
      for (std::size_t j = 0; j < 3; ++j)
        at.pose[j] = 0.5 * (box.low[j] + box.high[j]) + 0.49 * width * uniform();
      most = std::max(most, plain.measure(at));
    }
    ASSERT_LE(most, bound * (1.0 + 1e-6)) << pose_text(q.box, box.low);
    sharp += most > near * bound;
  }
  EXPECT_GT(finite, 300);
  EXPECT_GT(sharp, least_sharp);
}

TEST(CertificateCheck, NoPoseOutrunsTheIsnerCheckersBounds) {
  for (const char* length : {"fixed", "stretchy"}) {
    for (const solver::Mapping mapping : {solver::Mapping::chest, solver::Mapping::spread}) {
      SCOPED_TRACE(length);
      ProofQuestion q = question("isner", "extension=-180:180,side=-90:90,twist=-90:90");
      q.rig.options["length"] = std::string(length);
      q.chain.joint = {{0, 0, 0}, {0, 2, 0.4}, {0.1, 4, -0.2}, {0, 6, 0}};
      q.mapping = mapping;
      const auto system = solver::build_system(q.rig, q.chain);
      expect_bounds(q, *system, *isner_checker(q, *system), 110.0, 0.9, 150);
    }
  }
}

TEST(CertificateCheck, NoPoseOutrunsTheBoundsOfSpinesOnCurves) {
  using Options = std::map<std::string, solver::OptionValue>;
  const std::vector<double> uneven{0.2, 0.7};
  const auto word = [](const char* text) { return std::string(text); };
  const std::vector<glm::dvec3> straight = {{0, 0, 0}, {0, 0.2, 0}, {0, 0.7, 0}, {0, 1, 0}},
                                bent = {{0, 0, 0}, {0, 1, 0.3}, {0.1, 2, -0.1}, {0, 3, 0.3}},
                                many = {
                                    {0, 0, 0}, {0, 1, 0.2}, {0, 2, 0.3}, {0, 3, 0.2}, {0, 4, 0}};
  struct Case {
    const char* system;
    Options options;
    const std::vector<glm::dvec3>& joint;
    solver::Mapping mapping;
  };
  using solver::Mapping;
  const Case cases[] = {
      {"spline_ik", {}, bent, Mapping::chest},
      {"spline_ik", {{"depth", uneven}}, many, Mapping::spread},
      {"stretchy", {{"form", word("carve")}}, bent, Mapping::chest},
      {"stretchy", {}, bent, Mapping::chest},
      {"stretchy", {{"depth", uneven}, {"bones", 7.0}}, many, Mapping::spread},
      {"curve", {}, straight, Mapping::chest},
      {"curve", {}, bent, Mapping::chest},
      {"curve", {{"bones", 6.0}, {"length", word("arc")}}, many, Mapping::spread},
      {"curve", {{"length", word("null_sum")}}, bent, Mapping::spread},
      {"curve", {{"length", word("rest")}}, straight, Mapping::spread},
      {"snake", {{"joints", 30.0}, {"controls", 8.0}}, bent, Mapping::chest},
      {"snake",
       {{"joints", 20.0}, {"twist_u", std::vector<double>{0.3, 0.6}}},
       many,
       Mapping::spread},
  };
  for (const Case& each : cases) {
    SCOPED_TRACE(std::string(each.system) + (each.mapping == Mapping::spread ? ", spread" : ""));
    ProofQuestion q = question(each.system, "extension=-170:170,side=-80:80,twist=-90:90");
    q.rig.options = each.options;
    q.chain.joint = each.joint;
    q.mapping = each.mapping;
    const auto system = solver::build_system(q.rig, q.chain);
    expect_bounds(q, *system, *claim_checker(q, *system), 100.0, 0.9, 150);
  }
}

TEST(CertificateCheck, ConfirmsSpinesOnCurvesByItsOwnEvaluation) {
  Progress progress(Progress::Style::none);
  for (const char* system : {"spline_ik", "curve", "snake"}) {
    for (const solver::Mapping mapping : {solver::Mapping::chest, solver::Mapping::spread}) {
      SCOPED_TRACE(system);
      ProofQuestion q = question(system, "extension=10:20,side=-4:4,twist=-20:0");
      q.chain.joint = {{0, 0, 0}, {0, 1, 0.2}, {0, 2, -0.1}, {0, 3, 0}};
      q.mapping = mapping;
      if (q.rig.system == "snake") q.rig.options["joints"] = 12.0;
      const Certificate proof = proved(q);
      const CertificateCheck check = check_certificate(proof, "c", progress);
      EXPECT_EQ(check.certified, shares_of(proof.tree, q.box).certified_boxes);
      EXPECT_LE(check.gain_bound, proof.tree.gain_bound);
      // A claim that a pose breaks.
      const auto built = solver::build_system(q.rig, q.chain);
      Refutation at;
      at.check = "BB002";
      at.pose = {18.0, 1.0, -10.0};
      double most = 0.0;
      for (at.axis = 0; at.axis < 3; ++at.axis)
        most = std::max(most, Refuter(q, *built).measure(at));
      Certificate forged = proof;
      forged.tree.gain_bound = 0.95 * most;
      EXPECT_NE(refusal([&] { check_certificate(forged, "c", progress); }).find("the check finds"),
                std::string::npos);
    }
  }
}

TEST(CertificateCheck, NamesWhatItDoesNotKnow) {
  const auto why = [](const char* name, const char* option, const solver::OptionValue& value) {
    ProofQuestion q = question(name, "envelope");
    q.rig.options[option] = value;
    const auto system = solver::build_system(q.rig, q.chain);
    return refusal([&] { claim_checker(q, *system); });
  };
  const auto word = [](const char* text) { return std::string(text); };
  EXPECT_EQ(why("stretchy", "form", word("carve")), "");
  EXPECT_EQ(why("stretchy", "bones", 8.0), "");
  EXPECT_NE(why("stretchy", "twist", word("spread")).find("twist"), std::string::npos);
  EXPECT_NE(why("stretchy", "stretchiness", 0.5).find("stretchiness"), std::string::npos);
  EXPECT_NE(why("stretchy", "no_squash", true).find("ratio"), std::string::npos);
  EXPECT_NE(why("stretchy", "lead", 0.5).find("lead"), std::string::npos);
  EXPECT_NE(why("curve", "length", word("close")).find("length"), std::string::npos);
  EXPECT_NE(why("curve", "roll", word("full")).find("roll"), std::string::npos);
  EXPECT_NE(why("curve", "follow", word("on_curve")).find("follow"), std::string::npos);
  EXPECT_NE(why("curve", "basis", word("interpolate")).find("basis"), std::string::npos);
  EXPECT_NE(why("snake", "closest", word("nearest")).find("closest"), std::string::npos);
  EXPECT_NE(why("snake", "lead", 0.5).find("lead"), std::string::npos);

  ProofQuestion q = question("curve", "envelope");
  q.chain.joint = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {1, 2, 0}};
  const auto leftward = solver::build_system(q.rig, q.chain);
  EXPECT_NE(refusal([&] { claim_checker(q, *leftward); }).find("left"), std::string::npos);
  for (const char* rig : {"curve", "isner", "snake", "stretchy", "matrix_blend"}) {
    ProofQuestion of_controls = question(rig, "envelope");
    of_controls.box.of_controls = true;
    const auto system = solver::build_system(of_controls.rig, of_controls.chain);
    EXPECT_NE(refusal([&] { claim_checker(of_controls, *system); }).find("own controls"),
              std::string::npos)
        << rig;
  }
}

/// Claims that are false, in certificates whose form is right.
TEST(CertificateCheck, FindsWhatDoesNotHold) {
  Progress progress(Progress::Style::none);
  const auto why = [&](const Certificate& forged) {
    return refusal([&] { check_certificate(forged, "c.json", progress); });
  };
  Certificate low = proved(question("even", "envelope"));
  low.tree.gain_bound = 0.5;
  EXPECT_NE(why(low).find("the check finds 1"), std::string::npos);

  ProofQuestion q = question("even", "extension=-30:30,side=0,twist=0", 100.0);
  q.gain = 0.9;
  Certificate slow = proved(q);
  ASSERT_EQ(slow.tree.refutation.size(), 1u);
  EXPECT_EQ(why(slow), "");
  Certificate other = slow;
  other.tree.refutation[0].value = 3.0;
  EXPECT_NE(why(other).find("the plain solver gives 1"), std::string::npos);
  other = slow;
  other.tree.refutation[0].pose[0] = 55.0;
  EXPECT_NE(why(other).find("not in its box"), std::string::npos);
  other = slow;
  other.tree.node[0].state = BoxState::pending;
  EXPECT_NE(why(other).find("--resume"), std::string::npos);
}

TEST(ProofText, JsonHasTheSpecifiedKeys) {
  const Certificate proof = proved(question("isner", "extension=95:105,side=0,twist=0", 0.05));
  const auto system = solver::build_system(proof.question.rig, proof.question.chain);
  const auto json = nlohmann::json::parse(proof_json(proof, *system));
  EXPECT_EQ(json["schema"], "backbend.proof/1");
  EXPECT_NEAR(json["certified"].get<double>() + json["open"].get<double>() +
                  json["refuted_share"].get<double>(),
              1.0, 1e-12);
  ASSERT_FALSE(json["refuted"].empty());
  EXPECT_EQ(json["refuted"][0]["check"], "BB001");
  EXPECT_NEAR(json["refuted"][0]["pose"]["extension"].get<double>(), 100.87, 0.01);
  EXPECT_NEAR(json["refuted"][0]["value"].get<double>(), 180.0, 0.01);
}

TEST(ProofBox, ThatIsEmptyInvertedOrNotFiniteIsRefused) {
  const auto why = [](const std::string& box) { return refusal([&] { question("even", box); }); };
  EXPECT_NE(why("extension=10:0").find("goes from 10 to 0"), std::string::npos);
  EXPECT_NE(why("extension=5").find("empty"), std::string::npos);
  EXPECT_NE(why("extension=0:inf").find("not finite"), std::string::npos);
  EXPECT_NE(why("twist=0:40000").find("36000"), std::string::npos);
  EXPECT_NE(why("extenson=0:10").find("'extension'"), std::string::npos);
  EXPECT_NE(why("extension=5:10,flexion=0:10").find("both begin at 0"), std::string::npos);
  EXPECT_NE(why("side=0:10,top.rz=0:1").find("cannot be mixed"), std::string::npos);
  EXPECT_NE(why("side=0:10,side=0:1").find("twice"), std::string::npos);
  EXPECT_NE(why("side=0:x").find("not a number"), std::string::npos);
  EXPECT_NE(why("nosuch").find("no box"), std::string::npos);
  EXPECT_EQ(why("top.rz=-150:150"), "");
}

TEST(ProofBox, TakesFlexionAsExtensionBelowZero) {
  EXPECT_EQ(question("even", "extension=0:60,flexion=0:90").box.text(),
            question("even", "extension=-90:60").box.text());
}

TEST(ProofBox, HalvesFillTheirBox) {
  SubBox box;
  box.low = {-1.0, 0.0, 2.0};
  box.high = {3.0, 0.0, 4.0};
  EXPECT_EQ(widest_axis(box, 0.5), 0);
  EXPECT_EQ(widest_axis(box, 5.0), -1);
  const auto half = halves(box, 0);
  EXPECT_EQ(half[0].high[0], half[1].low[0]);
  EXPECT_EQ(half[0].low[0], box.low[0]);
  EXPECT_EQ(half[1].high[0], box.high[0]);
}

}  // namespace
}  // namespace backbend::validate
