#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <type_traits>
#include <vector>

namespace backbend::solver {

/// A list whose first N elements need no heap: curves of a few pieces are drawn a million times a
/// second. Plain data only.
template <class T, std::size_t N>
class InlineVector {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  InlineVector() = default;
  InlineVector(const InlineVector& other) { *this = other; }
  InlineVector& operator=(const InlineVector& other) {
    size_ = other.size_;
    heap_ = other.heap_;
    if (heap_.empty()) std::copy_n(other.here_.begin(), size_, here_.begin());
    return *this;
  }

  std::size_t size() const { return size_; }
  T* data() { return heap_.empty() ? here_.data() : heap_.data(); }
  const T* data() const { return heap_.empty() ? here_.data() : heap_.data(); }
  T& operator[](std::size_t i) { return data()[i]; }
  const T& operator[](std::size_t i) const { return data()[i]; }
  const T* begin() const { return data(); }
  const T* end() const { return data() + size_; }
  const T& front() const { return data()[0]; }
  const T& back() const { return data()[size_ - 1]; }
  std::span<const T> all() const { return {data(), size_}; }

  void clear() {
    size_ = 0;
    heap_.clear();
  }
  /// Adds an element whose value is for the caller to write.
  T& grow() {
    if (size_ < N && heap_.empty()) return here_[size_++];
    if (heap_.empty()) heap_.assign(here_.begin(), here_.begin() + std::ptrdiff_t(size_));
    heap_.emplace_back();
    ++size_;
    return heap_.back();
  }

 private:
  std::size_t size_ = 0;
  std::array<T, N> here_;  // not initialised beyond size_
  std::vector<T> heap_;    // all of them, once they do not fit
};

}  // namespace backbend::solver
