// libFuzzer's way into the one target that is linked with it.
#include <cstddef>

#include "tests/fuzz/target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  backbend::fuzz::targets().front().run({data, size});
  return 0;
}
