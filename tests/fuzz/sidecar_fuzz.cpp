#include "skin/anatomy/sidecar.h"

#include "skin/clip/clip.h"
#include "skin/gltf/gltf_reader.h"
#include "tests/fuzz/target.h"
#include "tests/skin/gltf_fixture.h"

namespace backbend::fuzz {
namespace {

const skin::Character& body() {
  static const skin::Character character = skin::read_character(
      skin::load_gltf(skin::ConvertedFile{"strip.glb", {}, skin::strip().glb()}));
  return character;
}

bool run(Input input) {
  try {
    const skin::Sidecar sidecar = skin::parse_sidecar(std::string(text_of(input)), "hero.toml");
    require(skin::parse_sidecar(skin::sidecar_text(sidecar), "again.toml") == sidecar,
            "a sidecar that is written reads back as it was");
    skin::Character character = body();
    skin::apply_sidecar(sidecar, character);
    skin::hints_with(sidecar, {});
    return true;
  } catch (const skin::CharacterError& error) {
    return refused(error);
  }
}

std::vector<Bytes> seeds() {
  return {bytes_of("schema = \"backbend.sidecar/1\"\n"), bytes_of(skin::sidecar_text([] {
            skin::Sidecar full;
            full.spine = {"hip", "chest"};
            full.chest = "chest";
            full.left_arm = {"a", "b"};
            full.right_arm = {"c"};
            full.up = "+Y";
            full.forward = "+Z";
            full.metres_per_unit = 0.01;
            full.namespaces = {"hero:"};
            full.envelope = "cartoon";
            full.controls = {{"extension", "chest_ctl", "X", -1}};
            return full;
          }()))};
}

const Registration registration{{"sidecar",
                                 run,
                                 seeds,
                                 {"schema",
                                  "backbend.sidecar/1",
                                  "spine",
                                  "chest",
                                  "left_arm",
                                  "right_arm",
                                  "up",
                                  "forward",
                                  "metres_per_unit",
                                  "leave_out",
                                  "namespaces",
                                  "envelope",
                                  "control",
                                  "channel",
                                  "axis",
                                  "sign",
                                  "extension",
                                  "flexion",
                                  "side",
                                  "twist",
                                  "\"+Y\"",
                                  "\"-Z\"",
                                  "inf",
                                  "1e-308"}}};

}  // namespace
}  // namespace backbend::fuzz
