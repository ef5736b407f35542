#include "validate/tasks/pictures_ahead.h"

#include <exception>

#include "render/image/picture_library.h"

namespace backbend::validate {

PicturesAhead::PicturesAhead() {
  loading_.run([] {
    try {
      render::picture_library();
    } catch (const std::exception&) {
      // Whoever needs it meets the same and says so.
    }
  });
}

PicturesAhead::~PicturesAhead() noexcept { loading_.wait(); }

}  // namespace backbend::validate
