#pragma once
#include <oneapi/tbb/task_group.h>

namespace backbend::validate {

/// Loads the library of pictures on a thread that has nothing else to do, for a job that will write
/// pictures: that takes as long as measuring a small character. What is wrong with it is said where
/// it is used. Ends with the loading.
class PicturesAhead {
 public:
  PicturesAhead();
  ~PicturesAhead() noexcept;  // the loading was waited for, so the group has nothing to throw
  PicturesAhead(const PicturesAhead&) = delete;
  PicturesAhead& operator=(const PicturesAhead&) = delete;

 private:
  oneapi::tbb::task_group loading_;
};

}  // namespace backbend::validate
