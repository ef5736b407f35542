#include "validate/verdicts/checks.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace backbend::validate {
namespace {

constexpr std::array kChecks = {
    Check{"BB000", "canary failed", Subject::tool,
          "canaries that did not show exactly the fault they carry, or whose repaired twin did",
          "count", 0.0, Sense::at_most, true,
          "a detector that misses a known fault has measured nothing this night", Owner::tool,
          "a change to a solver, a detector or a limit",
          "run `backbend calibrate`; compare with the last night whose canaries were found", "",
          "specification, section 8"},
    Check{"BB001", "flip", Subject::chain,
          "the largest turn of a joint that remains when the control interval is bisected to 2^-20 "
          "of the sweep",
          "deg", 1.0, Sense::at_most, true,
          "continuous motion halves at each bisection, so what remains is a jump of the rig "
          "itself; below 1 deg nobody sees it, and the figure stays far above rounding",
          Owner::solver,
          "an up vector that meets the tangent, an interpolation that changes hemisphere, a twist "
          "read back from a matrix",
          "carry the twist as a number instead of reading it from a frame; move the up vector off "
          "the bending plane; compare with `even`",
          "perceptual difference and silhouette change between the frames on both sides, against "
          "the sweep's own median",
          "bisection certificate; class 180 deg about the tangent: up vector", Witness::jump, 60.0},
    Check{"BB002", "near-flip", Subject::chain,
          "the fastest response of any joint: degrees of turn per degree of control", "deg/deg",
          8.0, Sense::at_most, true,
          "a healthy spine with linear weights stays below 2; 8 whips a quarter turn in 11 deg of "
          "control, which no animator can time",
          Owner::solver, "a pose that passes near a singular one",
          "look at the flip margin of the same sweep; keep the pose away from it or change the "
          "frame rule",
          "motion between adjacent frames against the sweep's median", "gain of adjacent poses"},
    Check{"BB003", "flip margin", Subject::chain,
          "the angle that a joint keeps from the nearest pose in which its frame is undefined",
          "deg", 5.0, Sense::at_least, false,
          "under 5 deg an offset that an animator adds without thought reaches the singular pose",
          Owner::solver, "an up vector that closes on the tangent",
          "lower the range of the control, or use a frame rule without a singular pose", "",
          "asin |up x tangent| of each joint, as its solver reports it"},
    Check{"BB010", "chain kink", Subject::chain,
          "the largest turn at one joint beyond what the intended curve turns over the same "
          "stretch, less that of the rest pose",
          "deg", 2.0, Sense::at_most, true,
          "a chain that follows its curve stays under 0.7 deg to a bend of 120; 2 deg in one joint "
          "are a corner in a line that no curve drew",
          Owner::solver,
          "bones longer than the stretch of curve they have to cover, goals that a chain "
          "overshoots, a corner in the path",
          "let the bone length follow the posed curve's length; walk joints onto the curve instead "
          "of aiming them at it",
          "curvature from position and normal layers, less rest", "intent-referenced turning",
          Witness::kink},
    Check{
        "BB011", "mesh kink", Subject::mesh,
        "the second difference, over one spine bone, of the turning of slice centres beyond what "
        "the intended motion turns them",
        "deg", 25.0, Sense::at_most, true,
        "five human bodies under an even bend reach 24 deg at the ends of the human envelope, all "
        "of it from weights on four to six joints; decides only where the even bend is better",
        Owner::weights, "weights that change over too short a stretch, one joint that takes all",
        "spread the weights over the neighbouring joints; add a joint; compare with proxy "
        "weights",
        "curvature from position and normal layers, and of the silhouette, less rest",
        "slice centres, second difference", Witness::kink, 32.0},
    Check{"BB012", "surface fold", Subject::mesh,
          "the share of the torso's surface lines that runs backwards along the spine", "%", 2.0,
          Sense::at_most, true,
          "the concave side of a bend may crease in a few rows; 2 % of all lines is a visible fold",
          Owner::weights, "more bend on the concave side than the surface has length",
          "spread the bend; where the pose is too much for the body's thickness, nothing needs "
          "mending",
          "pixels whose normal faces away", "order of slices along material surface lines"},
    Check{"BB013", "uneven bend", Subject::chain,
          "the largest joint angle over the mean joint angle, rest subtracted", "ratio", 4.0,
          Sense::at_most, false,
          "1 is a perfect arc and 1.5 a spine that eases in and out; where one joint does the work "
          "of four, it reads as a hinge",
          Owner::solver, "a control whose bend falls on one or two joints",
          "spread each control's bend along the spine (`even` does)", "",
          "max / mean of joint angles"},
    Check{"BB014", "chain twist jump", Subject::chain,
          "how far one joint is rolled against both its neighbours beyond any smooth twist", "deg",
          3.0, Sense::at_most, true,
          "smooth twists of 90 deg over ten bones stay below 1; a vertebra rolled by 3 deg wrings "
          "the skin around it",
          Owner::solver, "one joint whose up vector or roll differs from its neighbours'",
          "look at that joint's frame; a flipped vertebra shows here as 90 to 180",
          "curvature of surface lines from the normal layer",
          "fifth difference of twists between neighbouring joints"},
    Check{
        "BB015", "comb jump", Subject::mesh,
        "the largest jump, from one spine bone's length to the next, of the curvature comb of the "
        "torso's mid lines (belly and back), more than at rest",
        "deg", 130.0, Sense::at_most, false,
        "humans under an even bend reach 27 to 127 at the ends of their envelope and a round belly "
        "that "
        "folds 256, so it is shown, to compare rigs on one body, and does not decide",
        Owner::weights,
        "a crease across the belly or the back: weights of neighbouring vertebrae that "
        "meet in a line",
        "smooth the weights there along the spine", "", "curvature combs of fairing"},
    Check{"BB020", "arm drift, rotation", Subject::chain,
          "how far the arms have turned against the chest control, twist and aim together", "deg",
          0.5, Sense::at_most, true,
          "half a degree moves a hand by half a centimetre; contact and props show it",
          Owner::solver,
          "arms hung from the end of a chain that carries the minimal swing while the control "
          "carries an Euler one",
          "hang the arms from the top control; distribute the true twist of the control",
          "centroid of the arm mattes after the chest's own motion is removed",
          "hidden Euler twist 2 atan(tan(y/2) tan(z/2)), holonomy, aim gap", Witness::arms},
    Check{"BB021", "arm drift, translation", Subject::chain,
          "how far the arm roots have moved from where the chest control carries them",
          "% of spine", 2.0, Sense::at_most, true,
          "1 cm on a human: the shoulder leaves the place the animator put it", Owner::solver,
          "a chain shorter or longer than its curve, or one that ends short of its tip",
          "solve the bone length so that the chain meets its tip; hang the arms from the top "
          "control",
          "95 % Hausdorff distance of the arm mattes after the chest's motion is removed",
          "distance of arm roots in the chest's frame", Witness::arms},
    Check{"BB022", "arm drift on the mesh", Subject::mesh,
          "the largest motion of shoulder or hand in the chest's frame while only the spine moves",
          "% of height", 1.0, Sense::at_most, true,
          "a hand that slides 1.8 cm on a human leaves its prop", Owner::solver,
          "drift of the arm roots, enlarged by the arm's length", "see BB020 and BB021",
          "95 % Hausdorff distance of the hand mattes after the chest's motion is removed",
          "vertices of the arm regions in the chest's frame", Witness::arms, 2.0},
    Check{"BB030", "cross-section collapse", Subject::mesh,
          "the smallest area of a material slice of the torso, over its area at rest", "ratio",
          0.75, Sense::at_least, true,
          "linear blending across a twist of 60 deg leaves cos^2(30) = 0.75", Owner::weights,
          "twist concentrated between two joints whose weights meet over a short stretch",
          "more joints share the twist; wider weights; dual quaternions if the engine has them",
          "silhouette overlap with the ideal pose", "area cos^2(twist/2) under linear blending",
          Witness::slices},
    Check{"BB031", "volume", Subject::mesh, "change of the closed mesh's volume against rest", "%",
          10.0, Sense::at_most, true,
          "healthy bodies at the ends of the human envelope change by up to 8 %, which linear "
          "blending takes from the belly; nearly blind to local damage, so it only backs up others",
          Owner::weights, "weights that do not sum to one, collapse at joints",
          "check weight sums first; then the slice areas", "", "divergence theorem"},
    Check{"BB032", "strain amplification", Subject::mesh,
          "the strain that 99.9 % of the torso's area stays below, over what an ideal bend of the "
          "same pose puts at each place",
          "ratio", 20.0, Sense::at_most, false,
          "13 k vertex humans at the ends of the human envelope reach 13, but captured arms 25.8 "
          "beside a spine that hardly bends, and a flip of 180 deg only 5.9: the bend that it is "
          "divided by grows with the fault, so it is shown and does not decide",
          Owner::weights, "hard weight borders, weights cut to too few joints",
          "smooth the weights around the reported vertex", "perceptual difference at the place",
          "posed gradient against that of an ideal bent and twisted beam"},
    Check{
        "BB033", "inverted triangles", Subject::mesh,
        "area of triangles that face against their own normals as their joints turn them, "
        "more than at rest",
        "%", 1.0, Sense::at_most, true,
        "armpits of healthy bodies turn over up to 0.4 %, of coarse and fat ones 0.6 %; a flipped "
        "spine 2 %",
        Owner::weights, "surface turned inside out by far weights or too sharp a bend",
        "look at the place; where the pose is infeasible, nothing needs mending",
        "pixels that see a triangle from behind",
        "face normal against what its corners' joints make of the one at bind"},
    Check{
        "BB034", "self-intersection", Subject::mesh,
        "area of the triangles that run through others and did not at rest, neighbours not counted",
        "%", 2.0, Sense::at_most, true,
        "healthy bodies at the ends of the human envelope reach 0.9 %, our own human 1.3 % at side "
        "48; a spine that folds its body over itself 2 to 20 %",
        Owner::weights, "a belly or back that folds, far weights that pull skin through skin",
        "look at the place; where the pose is infeasible, nothing needs mending",
        "pixels whose normal faces away", "closed triangles against each other, in whole numbers"},
    Check{"BB035", "dihedral change", Subject::mesh,
          "the largest change of the angle between two neighbouring triangles", "deg", 90.0,
          Sense::at_most, false,
          "beyond a right angle the surface has creased at one edge; single edges in armpits do on "
          "every body, so it is shown and does not decide",
          Owner::weights, "hard weight borders, single wrong vertices", "smooth the weights there",
          "curvature from position and normal layers, less rest", "discrete shells"},
    Check{
        "BB036", "mesh twist jump", Subject::mesh,
        "the second difference, over one spine bone, of the twist of the slices", "deg", 15.0,
        Sense::at_most, true,
        "human bodies under an even twist of 60 deg stay below 9; one joint that flips shows as 50 "
        "to 180",
        Owner::solver, "one joint that rolls against its neighbours",
        "look at the joints' twists; a flip of one vertebra shows here as up to 180",
        "curvature of surface lines from the normal layer",
        "parallel transport of each slice's own direction"},
    Check{"BB037", "surface jump", Subject::mesh,
          "the farthest that a vertex of a rig's own points moves within half a degree of control, "
          "beside what linear blending of the same joints does",
          "% of spine", 0.5, Sense::at_most, true,
          "correctives that follow the bend move by 0.1 in half a degree (60 mm over 60 deg on a "
          "human); 0.5 is 2.5 mm at once, which a close-up shows",
          Owner::rig, "a driver of a shape key with a step, a lattice or muscle that switches",
          "look at the driver's curve around the named angle",
          "motion layer between both sides of the jump",
          "offsets from linear blending, bisected as flips are", Witness::jump},
    Check{"BB040", "lost twist", Subject::chain,
          "difference between the twist that the controls ask for and the twist that the chain "
          "carries",
          "deg", 5.0, Sense::at_most, true, "5 deg of chest twist is the least that animators key",
          Owner::solver, "a control whose twist feeds nothing, or a bend that leaks into twist",
          "distribute the twist of every control, not of one", "",
          "sum of control twists against twist along the chain"},
    Check{"BB041", "end gap", Subject::chain,
          "distance of the chain's last joint from where the chest control stands", "% of spine",
          2.0, Sense::at_most, true,
          "1 cm on a human: the neck leaves the place the animator put it", Owner::solver,
          "bone lengths that do not fit the posed curve", "solve the length so that the end meets",
          "", "distance of end joint and chest control"},
    Check{"BB042", "predictability", Subject::chain,
          "angle between the axis the control turns about and the axis the chest turns about",
          "deg", 20.0, Sense::at_most, false,
          "beyond 20 deg an animator corrects two channels to get one", Owner::solver,
          "frames that swing on their own while the control turns",
          "compare with `even`, whose end turns exactly as its control", "",
          "axes of adjacent relative turns"},
    Check{"BB043", "mirror asymmetry", Subject::chain,
          "largest difference between a pose and the mirror of the mirrored pose", "% of spine",
          0.1, Sense::at_most, true,
          "a symmetric rig mirrors to rounding; 0.1 % is half a millimetre on a human",
          Owner::solver, "one side's sign, order of rotations, an up vector off the middle plane",
          "mirror one control at a time and see which one differs", "",
          "mirrored controls, mirrored result"},
    Check{"BB044", "return to rest", Subject::chain,
          "what is left of a pose when every control is back at rest", "% of spine", 0.001,
          Sense::at_most, true, "a pose is a function of its controls alone: rounding, no more",
          Owner::solver, "state kept between frames, evaluation order",
          "solve the same pose twice, in another order", "", "hysteresis"},
    Check{"BB045", "range of motion", Subject::chain,
          "the joint that goes furthest beyond what a human segment can do, as a multiple of it",
          "ratio", 1.0, Sense::at_most, false,
          "advisory: in vitro ranges of T1-L5; cartoons and creatures have other spines",
          Owner::pose, "a bend concentrated on few vertebrae, or a pose beyond a human's",
          "spread the bend; set the character's envelope", "",
          "Wilke 2017 (thoracic), Yamamoto 1989 (lumbar)"},
    Check{"BB046", "uneven twist", Subject::chain,
          "the largest twist between neighbouring joints over the mean one", "ratio", 4.0,
          Sense::at_most, false,
          "1 is linear; where one joint twists as four, linear blending wrings it", Owner::solver,
          "twist fed to one joint, or to one end", "distribute the twist along the chain", "",
          "max / mean of relative twists, by arc length"},
    Check{"BB047", "length change", Subject::chain,
          "change of the chain's length against rest, beyond what its stretch option asks for",
          "% of spine", 5.0, Sense::at_most, true,
          "5 % of a human spine is 2.5 cm: skin slides and proportions change", Owner::solver,
          "bones that take their length from a curve that bending shortens",
          "hold the length; see `stretchiness`", "silhouette height against the ideal pose",
          "sum of bone lengths"},
    Check{"BB048", "pose infeasible", Subject::mesh,
          "curvature of the intended bend times the body's half depth on the inner side", "ratio",
          1.0, Sense::at_most, false,
          "at 1 the inner surface has no length left: it must fold whatever the rig does",
          Owner::pose, "more bend than this body's thickness allows",
          "no fault: lower the angle, spread it over more of the spine, or accept the fold", "",
          "inner stretch 1 - curvature x depth"},
    Check{"BB049", "control response", Subject::chain,
          "the share of a body channel's angle that arrives at the chest about the channel's axis, "
          "where a clip records its controls or a rig of your own is asked",
          "ratio", 0.5, Sense::at_least, true,
          "rigs carry all of an angle to the chest; half says that the control is another, turns "
          "about another axis or the other way round (-1), and every angle in the report is wrong",
          Owner::input,
          "a mapping with the wrong control, axis or sign; a twist that is not carried",
          "look at the sweep in the artist's program, and correct the mapping's control and sign",
          "", "turn from hips to chest against recorded controls"},
    Check{"BB050", "non-finite", Subject::chain, "values that are not finite numbers", "count", 0.0,
          Sense::at_most, true, "nothing else can be measured on such a pose", Owner::solver,
          "division by zero or the root of a negative number at a degenerate pose",
          "guard the degenerate case with a documented fallback", "", "isfinite"},
    Check{"BB051", "unreadable character", Subject::input,
          "characters of a suite that could not be read or have no spine", "count", 0.0,
          Sense::at_most, true, "a character that was not read was not measured", Owner::input,
          "a damaged or missing file, a format that the importer refuses, joints without a spine",
          "read the finding's message; try `backbend inspect` on the file", "",
          "the reader's own error"},
    Check{"BB052", "rig without answers", Subject::input,
          "rigs of your own whose program could not be asked, or gave up", "count", 0.0,
          Sense::at_most, true, "a rig that was not asked was not measured", Owner::rig,
          "a program that ends, hangs or answers wrongly twice; a file, mapping or rest pose that "
          "does not fit the character",
          "read the finding's message; run the same rig alone with `backbend check`", "",
          "the protocol's own checks"},
    Check{"BB060", "weight sums", Subject::input,
          "largest deviation of a vertex's weights from a sum of one, beyond what their storage "
          "rounds",
          "%", 0.1, Sense::at_most, true,
          "weights that sum to 0.999 shrink the body by 0.1 %; four weights in 8 bits may round by "
          "0.8 %, which is taken off first",
          Owner::input, "export without normalising, influences cut off",
          "normalise the weights before export", "", "sum over all weight sets"},
    Check{"BB061", "unweighted vertices", Subject::input, "vertices without any weight", "count",
          0.0, Sense::at_most, true, "such a vertex stays behind while the body moves",
          Owner::input, "vertices added after binding", "bind them", "", "weight count"},
    Check{"BB062", "stray vertices", Subject::input,
          "vertices bound to joints that none of their neighbours shares", "count", 0.0,
          Sense::at_most, true,
          "weights vary smoothly over a surface; a vertex alone with its joint is torn out of it",
          Owner::input, "a wrong paint stroke, mirrored weights that matched the wrong vertex",
          "take the weights of the neighbours", "", "weights against neighbours' weights"},
    Check{"BB063", "wrong side", Subject::input,
          "the largest weight of a joint on the other side of the body, away from the middle and "
          "from its own area",
          "% of weight", 7.0, Sense::at_most, true,
          "healthy bodies of eleven kinds have none, smoothed and cut down up to 6 % at a few "
          "places; "
          "7 % of an arm that is raised by 1 m pull the other side along by 7 cm",
          Owner::weights, "weights mirrored onto the wrong vertices, a brush that went through",
          "take that joint off the named side; mirror the weights of the healthy one", "",
          "weights against the middle plane and the joints' areas"},
    Check{
        "BB064", "far influence", Subject::input,
        "the largest weight of a joint far from its own area that does not fade towards it: more "
        "than 15 % of the body's size away and three joints or more along the skeleton, or more "
        "than 8 % and two joints where the weight rises again",
        "% of weight", 5.0, Sense::at_most, true,
        "healthy bodies have none that does not fade, smoothed and cut down up to 4.4 %; 5 % of a "
        "hand that moves by 1 m draw the skin out by 5 cm",
        Owner::weights, "bleed of automatic weights, a flood that reached too far",
        "take that joint off the named part, and give its weight to the joints there", "",
        "distance to the area and along the skeleton"},
    Check{
        "BB065", "asymmetric weights", Subject::input,
        "the share of a joint's weight that its mirror image has and it lacks, of spine, clavicles "
        "and upper arms of a body and a skeleton that mirror themselves",
        "% of weight", 20.0, Sense::at_most, true,
        "healthy painted bodies reach 10 % (a snake's chest), with more joints or smoothed 17 %, "
        "humans 1 %; beyond, one side bends otherwise than the other",
        Owner::weights, "one side painted on, weights not mirrored afterwards",
        "mirror the better side's weights to the other", "",
        "sum of what is missing over mirrored places, against the image's whole"},
    Check{
        "BB066", "order along the spine", Subject::input,
        "how far the middle of a spine joint's weights stands beyond that of the joint after it; "
        "or, "
        "where a joint between has no weight left, how far from a joint its weights begin",
        "% of spine", 6.0, Sense::at_most, true,
        "joints that follow each other move areas that follow each other: healthy bodies keep the "
        "order, and joints that nearly share a place may slip by 5.5 %; swapped or smeared "
        "vertebrae by 8 and more",
        Owner::weights, "weights of two vertebrae swapped, groups that lost their names",
        "look at the two joints' weights; swap them back", "", "weighted middles along the spine"},
    Check{"BB067", "seam", Subject::input,
          "the largest difference between the weights of vertices at one place", "% of weight",
          20.0, Sense::at_most, true,
          "copies of one vertex should move alike; painted animals differ by up to 15 % at a few "
          "places where the gap hides, beyond 20 % it gapes",
          Owner::weights, "parts weighted one by one, limits of influences cut differently",
          "copy the weights of one side of the seam to the other", "", "weights of one place"},
    Check{"BB068", "bind pose off", Subject::input,
          "how far the surface stands from where it would be, were a joint bound where the joints "
          "around it were",
          "% of height", 0.1, Sense::at_most, true,
          "stored matrices round to 0.001 %; 0.1 % is 2 mm on a human, which a close-up shows",
          Owner::input, "a joint moved after binding, a bind pose set with a joint posed",
          "reset the bind pose of the named joint, or bind again", "",
          "inverse bind matrices against their neighbours'"},
    Check{
        "BB069", "hard border", Subject::input,
        "of the edges of the mesh between two vertebrae's areas, the share that leads from one's "
        "weight to the other's with no blend, on a body whose other vertebrae blend",
        "% of edges", 50.0, Sense::at_most, true,
        "bodies of eleven kinds, smoothed, decimated, cut down or with more joints, blend on half "
        "of such edges and more; a ring of one joint each has none that blends",
        Owner::weights, "two groups assigned instead of painted, weights rounded or cut to one",
        "smooth the weights along the border of the two joints", "",
        "shares of two weights along edges"},
    Check{"BB070", "image and geometry disagree", Subject::tool,
          "findings on which picture and geometry contradict each other beyond their calibrated "
          "errors",
          "count", 0.0, Sense::at_most, false,
          "one of the two is wrong, which is a fault of this program", Owner::tool,
          "a camera that cannot see the place, a detector outside its calibrated range",
          "open the finding's pictures; report it", "", "specification, section 8"},
    Check{"BB071", "joint aside", Subject::input,
          "how far a joint of the spine stands at rest from the middle between the body's left and "
          "right surface there",
          "% of half width", 30.0, Sense::at_most, true,
          "healthy bodies stay below 10 %, one that is twisted at rest reaches 26; beyond 30 the "
          "body swings to one side when it twists",
          Owner::skeleton,
          "a joint drawn beside the body, a body moved after its skeleton was made",
          "move the named joint to the middle of the body, and bind again", "",
          "cross-sections at rest"},
    Check{"BB072", "joint past its neighbour", Subject::input,
          "how far the spine's chain goes back where it turns by 120 degrees and more at a joint",
          "% of spine", 3.0, Sense::at_most, true,
          "no spine that was tried turns back at all; shorter bones are left to rounding",
          Owner::skeleton, "a joint moved past the next or the one before",
          "put the joints in their order along the spine, and bind again", "",
          "directions of bones at rest"},
    Check{"BB073", "joint outside", Subject::input,
          "how far a joint of the spine stands at rest outside the body's surface, as a share of "
          "the radius of the cross-section there",
          "% of radius", 25.0, Sense::at_most, true,
          "all joints of the bodies of eleven kinds that were tried stand inside; a quarter is 3 "
          "cm on a human, beyond which the body bends about a place in the air",
          Owner::skeleton,
          "joints drawn in front of the body or behind it, a body moved after its skeleton was "
          "made",
          "move the named joint into the body, and bind again", "", "cross-sections at rest"},
    Check{"BB074", "limbs beside their bones", Subject::input,
          "how far the limbs' bones lie at rest from the middle of what they move towards its "
          "surface, where one shift takes all of them there",
          "% of half width", 100.0, Sense::at_most, true,
          "at 100 the bones lie on the skin, beyond it outside; a shift that limbs of sound bodies "
          "agree on stays below 60, even of wings and fins",
          Owner::skeleton, "a body moved after its skeleton was made, another body's skeleton",
          "move body or skeleton by the shift that is named, and bind again", "",
          "places of vertices around bones at rest"},
    Check{
        "BB075", "weights off their bones", Subject::input,
        "how far the weights of the vertebrae stand, by their median, beyond their own bones along "
        "the spine",
        "% of spine", 4.0, Sense::at_most, true,
        "the middle of a vertebra's weight lies on its own bone in sound bodies; with each "
        "vertebra's weights on the next one it is 4.4 and more beyond in spines of four to ten "
        "joints",
        Owner::weights, "groups that took the next joint's name, a joint added below the spine",
        "give each vertebra the weights around its own bone, or bind again", "",
        "weighted middles along the spine"},
};

constexpr bool codes_rise() {
  for (std::size_t i = 1; i < kChecks.size(); ++i)
    if (kChecks[i - 1].code >= kChecks[i].code) return false;
  return true;
}
static_assert(codes_rise(), "find_check() searches by halves");

/// Rounded to the four digits that reports print: a value that is printed as `15` passes a limit of
/// 15.
double as_printed(double value) {
  if (value == 0.0) return value;
  const double places = 3.0 - std::floor(std::log10(std::abs(value)));
  if (std::abs(places) > 22.0) return value;  // no power of ten beyond that is exact
  const double scale = std::pow(10.0, std::abs(places));
  return places >= 0.0 ? std::round(value * scale) / scale : std::round(value / scale) * scale;
}

}  // namespace

std::span<const Check> all_checks() { return kChecks; }

const Check* find_check(std::string_view code) {
  const auto found = std::ranges::lower_bound(kChecks, code, {}, &Check::code);
  return found != kChecks.end() && found->code == code ? &*found : nullptr;
}

Verdict judge(const Check& check, double exact, double limit) {
  if (!std::isfinite(exact) || !std::isfinite(limit)) return Verdict::not_measured;
  const double measured = as_printed(exact);
  const bool good = check.sense == Sense::at_most ? measured <= limit : measured >= limit;
  return good ? Verdict::pass : Verdict::fail;
}

double excess(const Check& check, double value, double limit) {
  constexpr double kFloor = 1e-9;
  return check.sense == Sense::at_most ? value / std::max(limit, kFloor)
                                       : limit / std::max(value, kFloor);
}

std::string_view name_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::pass:
      return "pass";
    case Verdict::fail:
      return "fail";
    case Verdict::waived:
      return "waived";
    case Verdict::stress:
      return "stress";
    case Verdict::not_measured:
      return "not_measured";
    case Verdict::not_applicable:
      return "not_applicable";
  }
  return "not_measured";
}

std::string_view name_of(Owner owner) {
  switch (owner) {
    case Owner::none:
      return "";
    case Owner::solver:
      return "SOLVER";
    case Owner::rig:
      return "RIG";
    case Owner::motion:
      return "MOTION";
    case Owner::weights:
      return "WEIGHTS";
    case Owner::skeleton:
      return "SKELETON";
    case Owner::pose:
      return "POSE";
    case Owner::input:
      return "INPUT";
    case Owner::tool:
      return "TOOL";
  }
  return "";
}

std::string_view name_of(Sense sense) { return sense == Sense::at_most ? "at most" : "at least"; }

std::string_view name_of(Subject subject) {
  switch (subject) {
    case Subject::chain:
      return "chain";
    case Subject::mesh:
      return "mesh";
    case Subject::input:
      return "input";
    case Subject::tool:
      return "tool";
  }
  return "";
}

}  // namespace backbend::validate
