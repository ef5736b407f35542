#include "skin/character/joint_names.h"

#include <algorithm>
#include <array>
#include <vector>

namespace backbend::skin {
namespace {

bool is_upper(char c) { return c >= 'A' && c <= 'Z'; }
bool is_lower(char c) { return c >= 'a' && c <= 'z'; }
bool is_letter(char c) { return is_upper(c) || is_lower(c); }

/// A name with Latin letters without their accents, of UTF-8: `Tête` -> Tete. Those of one letter
/// (U+00C0 to U+00FF) become it, those that stand after their letter (U+0300 to U+036F) go.
std::string without_accents(std::string_view name) {
  constexpr std::string_view kPlain =
      "AAAAAAACEEEEIIIIDNOOOOO-OUUUUY--aaaaaaaceeeeiiiidnooooo-ouuuuy-y";
  std::string out;
  for (std::size_t i = 0; i < name.size(); ++i) {
    const auto byte = static_cast<unsigned char>(name[i]);
    const auto next = i + 1 < name.size() ? static_cast<unsigned char>(name[i + 1]) : 0U;
    const bool follows = next >= 0x80 && next <= 0xBF;
    if (byte == 0xC3 && follows) {
      out += kPlain[next - 0x80];
      ++i;
    } else if ((byte == 0xCC && follows) || (byte == 0xCD && follows && next <= 0xAF)) {
      ++i;
    } else {
      out += name[i];
    }
  }
  return out;
}

/// The words of a name in lower case, digits dropped: `J_Bip_L_UpperArm01` -> j bip l upper arm.
std::vector<std::string> words_of(std::string_view name) {
  if (const auto cut = name.find_last_of(":|"); cut != std::string_view::npos)
    name.remove_prefix(cut + 1);
  std::vector<std::string> words;
  bool open = false;
  for (std::size_t i = 0; i < name.size(); ++i) {
    const char c = name[i];
    if (!is_letter(c)) {
      open = false;
      continue;
    }
    const bool hump = is_upper(c) && i > 0 && is_lower(name[i - 1]);
    // `LHip`: the second capital starts a word when a small letter follows it.
    const bool after_capital = is_upper(c) && i > 0 && is_upper(name[i - 1]) &&
                               i + 1 < name.size() && is_lower(name[i + 1]);
    if (!open || hump || after_capital) words.emplace_back();
    words.back() += is_upper(c) ? static_cast<char>(c - 'A' + 'a') : c;
    open = true;
  }
  return words;
}

struct Word {
  std::string_view text;
  BodyPart part;
  bool inside;  // may stand inside a longer word: `lowerback`, `upperarm`
};

// In order of trust: a name with words of two parts is the earlier one (`FrontLeg` over `Front`,
// `HeadNeck` the neck above the torso words).
constexpr std::array kWords = {
    Word{"finger", BodyPart::finger, true},
    Word{"thumb", BodyPart::finger, true},

    Word{"pinky", BodyPart::finger, true},
    Word{"metacarpal", BodyPart::finger, true},
    Word{"jaw", BodyPart::face, true},
    Word{"mouth", BodyPart::face, true},
    Word{"tongue", BodyPart::face, true},
    Word{"eye", BodyPart::face, true},
    Word{"ear", BodyPart::face, false},
    Word{"brow", BodyPart::face, true},
    Word{"lip", BodyPart::face, false},
    Word{"teeth", BodyPart::face, true},
    Word{"nose", BodyPart::face, true},
    Word{"cheek", BodyPart::face, true},
    Word{"hair", BodyPart::face, true},
    Word{"breast", BodyPart::breast, true},
    Word{"pectoral", BodyPart::breast, true},
    Word{"tail", BodyPart::tail, true},
    Word{"fin", BodyPart::fin, false},
    Word{"wing", BodyPart::fin, true},
    Word{"foot", BodyPart::foot, true},
    Word{"feet", BodyPart::foot, true},
    Word{"toe", BodyPart::foot, true},
    Word{"ankle", BodyPart::foot, true},
    Word{"ball", BodyPart::foot, false},
    Word{"hoof", BodyPart::foot, true},
    Word{"hand", BodyPart::hand, true},
    Word{"wrist", BodyPart::hand, true},
    Word{"paw", BodyPart::hand, false},
    Word{"thigh", BodyPart::leg, true},
    Word{"knee", BodyPart::leg, true},
    Word{"calf", BodyPart::leg, true},
    Word{"shin", BodyPart::leg, false},
    Word{"leg", BodyPart::leg, true},
    Word{"femur", BodyPart::leg, true},
    Word{"tibia", BodyPart::leg, true},
    Word{"clavicle", BodyPart::clavicle, true},
    Word{"clav", BodyPart::clavicle, false},
    Word{"collar", BodyPart::clavicle, true},
    Word{"scapula", BodyPart::clavicle, true},
    Word{"shoulder", BodyPart::clavicle, true},
    Word{"forearm", BodyPart::arm, true},
    Word{"upperarm", BodyPart::arm, true},
    Word{"lowerarm", BodyPart::arm, true},
    Word{"arm", BodyPart::arm, false},
    Word{"elbow", BodyPart::arm, true},
    Word{"bicep", BodyPart::arm, true},
    Word{"humerus", BodyPart::arm, true},
    Word{"leftarm", BodyPart::arm, true},
    Word{"rightarm", BodyPart::arm, true},
    Word{"neck", BodyPart::neck, true},
    Word{"head", BodyPart::head, true},
    Word{"skull", BodyPart::head, true},
    Word{"pelvis", BodyPart::hip, true},
    Word{"hips", BodyPart::hip, true},
    Word{"hip", BodyPart::hip, false},
    Word{"spine", BodyPart::spine, true},
    Word{"torso", BodyPart::spine, true},
    Word{"chest", BodyPart::spine, true},
    Word{"abdomen", BodyPart::spine, true},
    Word{"back", BodyPart::spine, true},
    Word{"ribs", BodyPart::spine, true},
    Word{"ribcage", BodyPart::spine, true},
    Word{"thorax", BodyPart::spine, true},
    Word{"waist", BodyPart::spine, true},
    Word{"belly", BodyPart::spine, true},
    Word{"body", BodyPart::spine, false},
    Word{"root", BodyPart::root, false},
    Word{"armature", BodyPart::root, true},
    Word{"reference", BodyPart::root, false},
    Word{"world", BodyPart::root, false},
    Word{"global", BodyPart::root, false},
    // French, Spanish, Italian, Portuguese, German; none that is a word of English rigs, too.
    Word{"tete", BodyPart::head, false},
    Word{"cabeza", BodyPart::head, false},
    Word{"cabeca", BodyPart::head, false},
    Word{"testa", BodyPart::head, false},
    Word{"kopf", BodyPart::head, false},
    Word{"cou", BodyPart::neck, false},
    Word{"cuello", BodyPart::neck, false},
    Word{"collo", BodyPart::neck, false},
    Word{"pescoco", BodyPart::neck, false},
    Word{"hals", BodyPart::neck, false},
    Word{"bassin", BodyPart::hip, false},
    Word{"cadera", BodyPart::hip, false},
    Word{"bacino", BodyPart::hip, false},
    Word{"quadril", BodyPart::hip, false},
    Word{"becken", BodyPart::hip, false},
    Word{"epaule", BodyPart::clavicle, false},
    Word{"hombro", BodyPart::clavicle, false},
    Word{"spalla", BodyPart::clavicle, false},
    Word{"ombro", BodyPart::clavicle, false},
    Word{"schulter", BodyPart::clavicle, false},
    Word{"clavicule", BodyPart::clavicle, false},
    Word{"clavicula", BodyPart::clavicle, false},
    Word{"clavicola", BodyPart::clavicle, false},
    Word{"bras", BodyPart::arm, false},
    Word{"coude", BodyPart::arm, false},
    Word{"brazo", BodyPart::arm, false},
    Word{"braccio", BodyPart::arm, false},
    Word{"braco", BodyPart::arm, false},
    Word{"oberarm", BodyPart::arm, false},
    Word{"unterarm", BodyPart::arm, false},
    Word{"codo", BodyPart::arm, false},
    Word{"gomito", BodyPart::arm, false},
    Word{"cotovelo", BodyPart::arm, false},
    Word{"ellenbogen", BodyPart::arm, false},
    Word{"poignet", BodyPart::hand, false},
    Word{"mano", BodyPart::hand, false},
    Word{"jambe", BodyPart::leg, false},
    Word{"cuisse", BodyPart::leg, false},
    Word{"genou", BodyPart::leg, false},
    Word{"hanche", BodyPart::leg, false},
    Word{"pierna", BodyPart::leg, false},
    Word{"rodilla", BodyPart::leg, false},
    Word{"gamba", BodyPart::leg, false},
    Word{"perna", BodyPart::leg, false},
    Word{"bein", BodyPart::leg, false},
    Word{"knie", BodyPart::leg, false},
    Word{"muslo", BodyPart::leg, false},
    Word{"coscia", BodyPart::leg, false},
    Word{"ginocchio", BodyPart::leg, false},
    Word{"coxa", BodyPart::leg, false},
    Word{"joelho", BodyPart::leg, false},
    Word{"oberschenkel", BodyPart::leg, false},
    Word{"unterschenkel", BodyPart::leg, false},
    Word{"cheville", BodyPart::foot, false},
    Word{"pied", BodyPart::foot, false},
    Word{"piede", BodyPart::foot, false},
    Word{"caviglia", BodyPart::foot, false},
    Word{"tobillo", BodyPart::foot, false},
    Word{"tornozelo", BodyPart::foot, false},
    Word{"fuss", BodyPart::foot, false},
    // Last: `Spine_Middle` is not a finger.
    Word{"index", BodyPart::finger, true},
    Word{"middle", BodyPart::finger, false},
    Word{"ring", BodyPart::finger, false},
};

bool is_any(const std::string& word, std::initializer_list<std::string_view> list) {
  return std::find(list.begin(), list.end(), word) != list.end();
}

bool names_a_limb(std::string_view word) {
  constexpr std::array kLimbs = {"leg",  "shoulder", "foot",  "feet",     "paw",
                                 "knee", "thigh",    "hoof",  "toe",      "ankle",
                                 "hand", "wrist",    "elbow", "clavicle", "scapula"};
  return std::any_of(kLimbs.begin(), kLimbs.end(), [&](std::string_view limb) {
    return word.find(limb) != std::string_view::npos;
  });
}

/// What a name in one case says before a limb's word: `IKFRONTLEG`, `backshoulder`. Where capitals
/// part the words, they are words of their own.
void read_prefixes(std::string_view word, NameFacts& facts) {
  const auto cut = [&](std::string_view prefix) {
    if (!word.starts_with(prefix) || !names_a_limb(word.substr(prefix.size()))) return false;
    word.remove_prefix(prefix.size());
    return true;
  };
  facts.control |= cut("ik");
  facts.front |= cut("front") || cut("fore");
  facts.back |= cut("back") || cut("hind") || cut("rear");
}

}  // namespace

NameFacts read_joint_name(std::string_view name) {
  NameFacts facts;
  std::vector<std::string> words = words_of(without_accents(name));
  for (std::string& word : words) {
    if (is_any(word, {"l", "left", "lft"})) {
      facts.side = Side::left;
      word.clear();
    } else if (is_any(word, {"r", "right", "rgt"})) {
      facts.side = Side::right;
      word.clear();
    } else if (word.rfind("left", 0) == 0) {
      facts.side = Side::left;
      word.erase(0, 4);
    } else if (word.rfind("right", 0) == 0) {
      facts.side = Side::right;
      word.erase(0, 5);
    }
    facts.control |= is_any(word, {"ik", "pole", "target", "ctrl", "control", "mch", "goal"});
    facts.helper |= is_any(word, {"twist", "roll", "helper", "bendy"});
    facts.end |= is_any(word, {"end", "leaf", "tip", "nub"});
    facts.tip |= word == "tip";
    facts.front |= is_any(word, {"front", "fore"});
    facts.back |= is_any(word, {"back", "hind", "rear"});
    read_prefixes(word, facts);
    facts.without_side += word;
  }
  // Numbers tell joints of one side apart, so they belong to what a pair shares.
  for (const char c : name)
    if (c >= '0' && c <= '9') facts.without_side += c;

  for (const Word& entry : kWords) {
    const bool found = std::any_of(words.begin(), words.end(), [&](const std::string& word) {
      return entry.inside ? word.find(entry.text) != std::string::npos : word == entry.text;
    });
    if (!found) continue;
    facts.part = entry.part;
    break;
  }
  if (facts.part == BodyPart::hip && facts.side != Side::none) facts.part = BodyPart::leg;
  return facts;
}

}  // namespace backbend::skin
