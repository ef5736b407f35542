#pragma once
// A small figure to bend, prepared for measuring.
#include "skin/body/body.h"
#include "tests/skin/body_figure.h"
#include "validate/metrics/surface/body_metrics.h"
#include "validate/stage/stage.h"

namespace backbend::validate::testing {

struct FigureStage {
  FigureStage() : stage(skin::make_body(skin::figure()), hints()) {}
  static skin::AnatomyHints hints() {
    skin::AnatomyHints out;
    out.hip = "hips";
    out.chest = "chest";
    return out;
  }
  Stage stage;
  BodyMetrics body{stage.character(), stage.anatomy(), stage.driver()};
};

}  // namespace backbend::validate::testing
