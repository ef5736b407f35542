#pragma once
#include <limits>

#include "validate/verdicts/checks.h"

namespace backbend::validate {

/// What is known about a value on the mesh beside the value itself. NaN: not measured.
struct MeshContext {
  double value = 0.0;  // of the rig under judgement
  double ideal = 0.0;  // of the ideal bend (`even`) with the same ends and the same weights
  double proxy = 0.0;  // of the same rig with clean proxy weights
  double ideal_proxy = std::numeric_limits<double>::quiet_NaN();  // of the ideal bend with those
  double infeasible = 0.0;       // curvature times depth at the place: kInfeasible
  bool judging_weights = false;  // the character is on trial: what the ideal shows too decides
  int bones = 0;                 // of the character's driven spine; 0: not known
  double longest_bone = 0.0;     // ... and its longest one, as a share of that spine's length
  double rows_per_bone = std::numeric_limits<double>::infinity();  // vertices along the torso
  bool in_pieces = false;   // no triangle joins the torso's pieces, each on its own joint
  bool own_shares = false;  // the rig is the studio's, and shares the bend as its maker likes
};

/// Whose a mesh finding is, and whether it decides the exit code.
struct Booking {
  Verdict verdict = Verdict::not_measured;
  Owner owner = Owner::none;
  bool decides = false;
};

/// Weights may be so much worse than clean ones, as a factor of what those give, before they are to
/// blame. Healthy humans stay below 1.3, whichever side of the limit clean weights are on, a child
/// with a heavy belly at 1.54; weights moved by one vertebra double it.
inline constexpr double kWorseThanClean = 1.6;

/// A studio's rig may be so much worse than an equal share of the same turn, as a factor of what
/// that exceeds rest by: uneven shares give the joint that turns most a third more.
inline constexpr double kUnevenShares = 1.35;

/// Curvature times half depth from which on the surface must fold, whatever the rig does.
inline constexpr double kInfeasible = 1.0;

/// ... and from which on what the ideal bend shows as well is the pose's and not the weights': of
/// kinks less, for what is left of the inner side's length then folds at any small unevenness. A
/// child with a heavy belly has a kink of 73 degrees at 0.9, clean weights 38.
double infeasible_from(const Check& check);

/// The limit beyond which the weights decide of a value on the mesh that the ideal bend shows as
/// well. Limits were measured on whole bodies; cut to 2000 vertices, smoothed, or with three joints
/// a vertex, healthy weights exceed some of them (docs/calibration.md), and nothing but a picture
/// tells that from a fault. `limit` is that of the pose.
double weights_limit(const Check& check, double limit);

/// Checks that compare slices over one spine bone with those on both sides need three bones: on a
/// shorter spine the window is the spine, and what they measure is where its joints are. Nor can
/// two joints share a twist so that no slice collapses and no triangle turns over.
inline constexpr int kLeastBonesForSlices = 3;

/// ... and so is a spine of which one bone is more than this share: the joint at its end turns by
/// as much of the bend.
inline constexpr double kLongestBoneForSlices = 0.5;

/// ... and a surface with fewer vertices along each bone shows its own facets, not the bend.
inline constexpr double kLeastRowsForSlices = 2.5;

/// A value on the chain that the ideal bend of the same rest shape shows as well (a tenth of the
/// limit apart counts as equal): a corner or an S in the rest spine, no fault of the rig. True for
/// the checks that compare neighbouring bones, BB010 and BB014, and no other.
bool is_rest_shape(const Check& check, double limit, double value, double ideal);

/// Books a value on the mesh. Within its limit it is a pass. Beyond it:
/// - in a pose that this body is too thick for, the pose's, and never a rig's fault; so is a kink
///   that the ideal bend shows as well in one that it is nearly too thick for (infeasible_from());
/// - where the ideal bend is as bad (a tenth of the limit apart counts as equal; for a studio's own
///   rig a factor of kUnevenShares, whether the ideal fails or not), and clean proxy
///   weights under the ideal bend are nearly as bad (by a tenth of the limit, or by less than
///   kWorseThanClean), the skeleton's: it has too few joints for the range.
///   So are slices of a spine of fewer than kLeastBonesForSlices bones or with a bone above
///   kLongestBoneForSlices, or of a surface of fewer than kLeastRowsForSlices rows a bone, or of a
///   torso of separate pieces, a robot's, that are to turn against each other. That never decides;
/// - self-intersection that clean proxy weights under the ideal bend show beyond the limit, too, is
///   the pose's: this body is in its own way;
/// - where the ideal bend is as bad and clean weights are far better, the weights'; that decides
///   only where weights are what is judged, and beyond weights_limit();
/// - where the ideal is better, it decides, and is the solver's; unless the ideal is still beyond
///   the limit and clean proxy weights are not, which makes it the weights'. Where both cure it,
///   these weights are good enough for a better rig.
/// A value or limit that is not finite is not measured; without a finite ideal nobody can be
/// blamed, and the finding stands as the check's usual owner's, deciding.
Booking book_mesh_finding(const Check& check, double limit, const MeshContext& context);

/// Whether a finding that decides is one that other weights may cure: booked to them, or sums,
/// unweighted and stray vertices of the file.
bool is_of_weights(const Finding& finding);

/// How many joints would carry what `joints` cannot, where clean weights and the ideal bend give
/// `value`: kinks and twist jumps are shared out among the joints; a slice under linear blending
/// keeps cos^2 of half the twist between two of them. 0: that check has no such rule.
int joints_needed(const Check& check, double limit, double value, int joints);

}  // namespace backbend::validate
