#include "cli/prove_command.h"

#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "skin/anatomy/body_kind.h"
#include "validate/files/output_folder.h"
#include "validate/prove/bounds_record.h"
#include "validate/prove/certificate_check.h"
#include "validate/prove/metric_proof_text.h"
#include "validate/prove/proof_text.h"
#include "validate/stage/stage.h"
#include "validate/sweeps/external_spec.h"
#include "validate/text/escape.h"
#include "validate/verdicts/exit_code.h"

namespace backbend::cli {

using namespace backbend::validate;

namespace {

struct ProveOptions {
  std::string rig = "even", box = "envelope", mapping = "chest", character, output, check;
  skin::AnatomyHints hints;
  double gain = 8.0;
  std::optional<double> smallest;
  std::vector<std::string> bounds;
  std::uint64_t boxes = 1000000;
  bool resume = false;
};

/// A straight spine of three bones, for rigs that no character was named for.
solver::RestChain straight_chain() { return {{{0, 0, 0}, {0, 2, 0}, {0, 4, 0}, {0, 6, 0}}}; }

int exit_code_of(const Certificate& proof) {
  const ProofShares shares = shares_of(proof.tree, proof.question.box);
  if (shares.refuted_boxes > 0) return kExitFindings;
  return shares.open_boxes > 0 ? kExitNotMeasured : kExitOk;
}

/// What all questions need: the rig, on the spine of a character or on a straight one.
struct RigOnSpine {
  solver::SystemSpec rig;
  std::unique_ptr<Stage> stage;  // null: no character was named
  solver::RestChain chain = straight_chain();
  Envelope envelope = *find_envelope("human");
};

RigOnSpine rig_of(const ProveOptions& options) {
  RigOnSpine subject;
  subject.rig = read_rig(options.rig).spec;
  if (is_external(subject.rig))
    throw ProofError("a rig of your own cannot be proved, only searched: backbend hunt");
  if (options.character.empty()) return subject;
  const bool neck = subject.rig.system == "neck";
  subject.stage = std::make_unique<Stage>(load_character(options.character), options.hints,
                                          neck ? DrivenChain::neck : DrivenChain::spine);
  const Stage& stage = *subject.stage;
  subject.chain.joint = stage.rest_chain().joint;
  subject.chain.left = stage.rest_chain().left;
  subject.envelope = envelope_for(skin::body_kind(stage.character(), stage.anatomy()).kind, neck);
  return subject;
}

/// The file that --resume goes on from.
const std::string& record_of(const ProveOptions& options) {
  if (options.output.empty())
    throw CLI::ValidationError("--resume continues the search whose file -o names");
  return options.output;
}

/// A long search must not end at a folder that cannot be written.
void prepare_output(const ProveOptions& options) {
  if (options.output.empty()) return;
  const std::filesystem::path folder = std::filesystem::path(options.output).parent_path();
  OutputFolder(folder.empty() ? "." : folder).prepare();
}

void say_how_to_resume(const ProveOptions& options) {
  std::fprintf(stderr, "backbend: what is decided is in %s; --resume goes on from there\n",
               options.output.c_str());
}

/// `--bound`: limits of checks over the box. `-o` names a record of what is decided, for --resume;
/// --check does not verify it.
int run_bounds(const ProveOptions& options, const Common& common) {
  const RigOnSpine subject = rig_of(options);
  const auto system = solver::build_system(subject.rig, subject.chain);
  MetricQuestion q;
  q.system = system.get();
  q.stage = subject.stage.get();
  q.mapping = *find_mapping(options.mapping);
  q.box = read_box(options.box, subject.envelope, *system);
  q.smallest = options.smallest.value_or(q.smallest);
  for (const std::string& bound : options.bounds) q.claim.push_back(read_claim(bound));
  const std::string rig = rig_text(subject.rig);
  const std::string question = bounds_question(q, rig, subject.chain);
  MetricParts parts =
      options.resume ? read_bounds_record(record_of(options), q, question) : parts_not_looked_at(q);
  prepare_output(options);
  Progress progress(common.progress_style());
  MetricProof proof;
  try {
    proof = prove_metrics(q, parts, progress);
  } catch (const Interrupted&) {
    if (!options.output.empty()) {
      write_bounds_record(options.output, question, parts);
      say_how_to_resume(options);
    }
    throw;
  }
  if (!options.output.empty()) write_bounds_record(options.output, question, parts);
  std::fputs((common.json ? metric_proof_json(q, proof, rig)
                          : metric_proof_text(q, proof, rig, style_of_stdout()))
                 .c_str(),
             stdout);
  double refuted = 0.0, open = 0.0;
  for (const ClaimResult& claim : proof.claim) {
    refuted += claim.refuted;
    open += claim.open;
  }
  return refuted > 0.0 ? kExitFindings : open > 0.0 ? kExitNotMeasured : kExitOk;
}

int run_proof(const ProveOptions& options, const Common& common) {
  Certificate proof;
  ProofQuestion& q = proof.question;
  const RigOnSpine subject = rig_of(options);
  q.rig = subject.rig;
  q.chain = subject.chain;
  q.mapping = *find_mapping(options.mapping);
  const auto system = solver::build_system(q.rig, q.chain);
  q.box = read_box(options.box, subject.envelope, *system);
  q.gain = options.gain;
  q.smallest = options.smallest.value_or(box_solver_of(*system).smallest_box());
  q.boxes = options.boxes;
  if (options.resume) {
    const Certificate before = read_certificate(record_of(options));
    if (const std::string what = difference(q, before.question); !what.empty()) {
      throw ProofError(options.output + ": of another question: its " + what + " is not the same");
    }
    proof.tree = before.tree;
  }
  prepare_output(options);
  Progress progress(common.progress_style());
  try {
    prove(q, *system, proof.tree, progress);
  } catch (const Interrupted&) {
    if (!options.output.empty()) {
      write_certificate(options.output, proof);
      say_how_to_resume(options);
    }
    throw;
  }
  if (!options.output.empty()) write_certificate(options.output, proof);
  std::fputs(
      (common.json ? proof_json(proof, *system) : proof_text(proof, *system, style_of_stdout()))
          .c_str(),
      stdout);
  if (!options.output.empty() && !common.quiet) {
    std::fprintf(stderr, "wrote %s; next: backbend prove --check %s\n", options.output.c_str(),
                 options.output.c_str());
  }
  return exit_code_of(proof);
}

/// `--check`: nothing of the certificate is believed. Where a rig, a box or a character is named,
/// too, it must be theirs.
int run_check(const ProveOptions& options, const Common& common, bool names_rig) {
  const Certificate certificate = read_certificate(options.check);
  if (names_rig && rig_text(read_rig(options.rig).spec) != rig_text(certificate.question.rig)) {
    throw ProofError(options.check + ": a certificate of " + rig_text(certificate.question.rig) +
                     ", not of " + options.rig);
  }
  Progress progress(common.progress_style());
  const CertificateCheck check = check_certificate(certificate, options.check, progress);
  const ProofShares shares = shares_of(certificate.tree, certificate.question.box);
  if (common.json) {
    const nlohmann::ordered_json json = {
        {"schema", "backbend.proof_check/1"},
        {"rig", rig_text(certificate.question.rig)},
        {"holds", true},
        {"certified", shares.certified},
        {"refuted_share", shares.refuted},
        {"open", shares.open},
        {"gain_bound", check.gain_bound},
        {"boxes",
         {{"certified", check.certified}, {"refuted", check.refuted}, {"open", check.open}}}};
    std::printf("%s\n", json.dump(1).c_str());
  } else {
    std::printf("%s holds: %s, %llu certified, %llu refuted and %llu open boxes fill %s\n",
                visible(options.check).c_str(), rig_text(certificate.question.rig).c_str(),
                static_cast<unsigned long long>(check.certified),
                static_cast<unsigned long long>(check.refuted),
                static_cast<unsigned long long>(check.open),
                certificate.question.box.text().c_str());
    std::printf("gain at most %s on %s %% of it, by the checker's own bounds\n",
                bound_text(check.gain_bound).c_str(),
                number_text(100.0 * shares.certified, 4).c_str());
  }
  return kExitOk;
}

}  // namespace

void add_prove(const Registry& registry) {
  auto options = std::make_shared<ProveOptions>();
  CLI::App* command = registry.add(
      "prove",
      "prove that a rig neither jumps nor whips at any pose of a box, or show where it does",
      [options, &common = registry.common, &app = registry.app] {
        if (!options->bounds.empty()) return run_bounds(*options, common);
        if (options->check.empty()) return run_proof(*options, common);
        return run_check(*options, common, app.get_subcommand("prove")->count("rig") > 0);
      });
  command->add_option("rig", options->rig,
                      "rig: a system, a system with options, or a rig file [even]");
  command->add_option("--box", options->box,
                      "poses: envelope, stress, sweep, a TOML file with [box], or channels like "
                      "extension=0:180,side=0 in degrees [envelope]");
  add_mapping_option(command, options->mapping);
  command
      ->add_option("--gain", options->gain,
                   "the most that a joint may turn, degrees per degree of a channel [8]")
      ->check(CLI::Range(1e-3, 1e6));
  command
      ->add_option("--smallest", options->smallest,
                   "width of the smallest boxes, degrees [1; 0.3 for stretchy; with --bound 2]")
      ->check(CLI::Range(1e-6, 360.0));
  command->add_option("--boxes", options->boxes, "the most boxes to look at [1000000]")
      ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{100000000}));
  command->add_option(
      "-o,--output", options->output,
      "write a certificate that --check verifies; with --bound a record of the search");
  command->add_option("--check", options->check, "verify a certificate instead of making one");
  command->add_flag("--resume", options->resume, "continue the search whose file -o names");
  command->add_option("--character", options->character,
                      "character whose spine is driven [a straight spine]");
  add_anatomy_options(command, options->hints);
  CLI::Option* bound = command->add_option(
      "--bound", options->bounds,
      "prove instead that a check's limit holds over the box: BB010, BB020, BB021, BB041, "
      "BB047; with a character BB030 (cross-sections), BB033 (inverted triangles); "
      "CODE=LIMIT sets another limit; may be repeated");
  for (const char* other : {"--check", "--gain", "--boxes"})
    bound->excludes(command->get_option(other));
}

}  // namespace backbend::cli
