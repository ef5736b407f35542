#pragma once
#include <string>

#include "skin/body/body.h"

namespace backbend::skin {

/// A small figure that is made in a tenth of a second: trunk of four joints, two legs, two arms.
/// `replace` is put in the place of `what` in its description first.
std::string figure_text(const std::string& what = "", const std::string& replace = "");
/// That text read as a description. Throws what read_body_description() throws.
BodyDescription read_text(const std::string& text);
BodyDescription figure();

}  // namespace backbend::skin
