#pragma once
#include <oneapi/tbb/task_group.h>

#include <exception>
#include <functional>
#include <optional>
#include <utility>

namespace backbend::validate {

/// Something that a thread with nothing else to do computes while its owner goes on. With one
/// thread it is computed when it is asked for. Ends with the computing.
template <class Value>
class Ahead {
 public:
  explicit Ahead(std::function<Value()> compute) {
    computing_.run([this, compute = std::move(compute)] {
      try {
        value_ = compute();
      } catch (...) {
        thrown_ = std::current_exception();
      }
    });
  }
  ~Ahead() noexcept { computing_.wait(); }  // its work throws nothing
  Ahead(const Ahead&) = delete;
  Ahead& operator=(const Ahead&) = delete;

  /// Waits; rethrows what computing threw.
  const Value& get() {
    computing_.wait();
    if (thrown_) std::rethrow_exception(thrown_);
    return *value_;
  }

 private:
  oneapi::tbb::task_group computing_;
  std::optional<Value> value_;
  std::exception_ptr thrown_;
};

}  // namespace backbend::validate
