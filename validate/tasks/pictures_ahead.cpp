#include "validate/tasks/pictures_ahead.h"

#include "render/image/picture_library.h"

namespace backbend::validate {

PicturesAhead::PicturesAhead()
    : loading_([] {
        render::picture_library();
        return true;
      }) {}

}  // namespace backbend::validate
