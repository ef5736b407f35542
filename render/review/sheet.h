#pragma once
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "render/image/picture.h"

namespace backbend::render {

/// One picture of a sheet with the words under it; a highlighted one gets a coloured frame.
struct SheetCell {
  Picture picture;
  std::string label;
  bool highlighted = false;
};

/// Pictures in rows of `columns`, each in a cell as large as the largest of them, labels beneath
/// and `title` above (none where empty). Throws RenderError without cells or columns.
Picture contact_sheet(std::span<const SheetCell> cells, int columns, std::string_view title);

/// Two pictures of one scene next to each other at the same scale, each named in its upper corner.
Picture side_by_side(const Picture& left, std::string_view left_name, const Picture& right,
                     std::string_view right_name);

/// Writes three texts into a dark strip along the lower edge: what it is, where in the motion, what
/// was worst. The strip covers the picture; keep a clean copy. Returns the strip's height.
int burn_in(Picture& picture, std::string_view left, std::string_view middle,
            std::string_view right);

/// Draws the heat scale into the lower left: bar, both ends and the middle in numbers, `label` with
/// its unit, and the colour of what was not measured. `above_bottom` pixels are left free below it.
void draw_legend(Picture& picture, float low, float high, std::string_view label,
                 int above_bottom = 0);

/// The picture shrunk to fit into `width` x `height`, keeping its proportions; never enlarged. Each
/// new pixel is the mean of the light, not of the code values, that falls on it.
Picture shrink(const Picture& picture, int width, int height);

}  // namespace backbend::render
