#pragma once
#include "validate/tasks/ahead.h"

namespace backbend::validate {

/// Loads the library of pictures on a thread that has nothing else to do, for a job that will write
/// pictures: that takes as long as measuring a small character. What is wrong with it is said where
/// it is used. Ends with the loading.
class PicturesAhead {
 public:
  PicturesAhead();

 private:
  Ahead<bool> loading_;  // nobody asks for it
};

}  // namespace backbend::validate
