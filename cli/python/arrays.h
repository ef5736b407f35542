#pragma once
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <glm/mat4x4.hpp>
#include <memory>
#include <string>
#include <vector>

namespace backbend::python {

namespace py = pybind11;

inline py::ssize_t length(std::size_t n) { return static_cast<py::ssize_t>(n); }

/// An array of numbers from Python, copied: dimensions, and the values in C order, all finite.
struct Numbers {
  std::vector<py::ssize_t> shape;
  std::vector<double> value;
};

/// Reads an array or a sequence of any real type, order and strides. `expected` has a length for
/// each dimension, -1 for any; `words` says so for a person: `N x 9 channels`. Throws TypeError for
/// anything but real numbers, ValueError for another shape or a number that is not finite,
/// naming `what` and the place.
Numbers read_numbers(py::handle from, const std::string& what, const std::string& words,
                     const std::vector<py::ssize_t>& expected);

/// The same for one row or many rows: a single row counts as one. `width`: of a row; -1: any.
Numbers read_rows(py::handle from, const std::string& what, const std::string& words,
                  py::ssize_t width);

/// An array over memory that `owner` keeps alive; strides in bytes, empty for C order.
template <typename T>
py::array view_of(const T* data, std::vector<py::ssize_t> shape, std::shared_ptr<const void> owner,
                  std::vector<py::ssize_t> strides = {}, bool writable = false) {
  auto* kept = new std::shared_ptr<const void>(std::move(owner));
  py::capsule base(kept, [](void* p) { delete static_cast<std::shared_ptr<const void>*>(p); });
  py::array array(py::dtype::of<T>(), std::move(shape), std::move(strides), data, base);
  if (!writable)
    py::detail::array_proxy(array.ptr())->flags &= ~py::detail::npy_api::NPY_ARRAY_WRITEABLE_;
  return array;
}

/// An array that owns what it shows.
template <typename T>
py::array array_of(std::vector<T> values, std::vector<py::ssize_t> shape) {
  auto owner = std::make_shared<const std::vector<T>>(std::move(values));
  const T* data = owner->data();
  return view_of<T>(data, std::move(shape), std::move(owner), {}, true);
}

/// N x K x 4 x 4 rows-first matrices of Python as ours, which stand column by column.
std::vector<glm::dmat4> matrices_of(const Numbers& numbers);
/// Reads N x `each` x 4 x 4 matrices, or one pose's `each` x 4 x 4. Throws as read_numbers() does.
std::vector<glm::dmat4> read_matrices(py::handle from, const std::string& what, py::ssize_t each);
/// Our matrices as an array of N x K x 4 x 4 over their own memory.
py::array matrices_view(const std::shared_ptr<std::vector<glm::dmat4>>& matrices, py::ssize_t poses,
                        py::ssize_t each);

/// A text of Python as bytes: UTF-8, and what stands for other bytes in names of files
/// (surrogateescape). Throws ValueError naming `what` for half a character; TypeError for no text.
std::string text_from(py::handle text, const std::string& what);

/// Named values as an object of the package's own: `Poses`, `Series`, `Record`.
py::object record(const char* kind, const py::dict& values);

}  // namespace backbend::python
