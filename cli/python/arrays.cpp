#include "cli/python/arrays.h"

#include <cmath>
#include <cstring>
#include <optional>

namespace backbend::python {
namespace {

constexpr int kAligned = py::detail::npy_api::NPY_ARRAY_ALIGNED_;
using Plain = py::array_t<double, py::array::c_style | py::array::forcecast | kAligned>;

std::string shape_text(const std::vector<py::ssize_t>& shape) {
  std::string text;
  for (const py::ssize_t length : shape)
    text += (text.empty() ? "" : " x ") + std::to_string(length);
  return text.empty() ? "a single number" : text;
}

/// `[3, 1]`: the place of a value in C order.
std::string place_text(std::size_t at, const std::vector<py::ssize_t>& shape) {
  std::string text;
  for (std::size_t d = shape.size(); d-- > 0;) {
    const auto length = static_cast<std::size_t>(shape[d]);
    text = std::to_string(at % length) + (text.empty() ? "" : ", ") + text;
    at /= length;
  }
  return "[" + text + "]";
}

/// Any array or sequence as NumPy has it, of real numbers.
py::array real_array(py::handle from, const std::string& what) {
  const std::string expected = what + ": expected an array of real numbers";
  py::array any;
  try {
    any = py::array(py::reinterpret_borrow<py::object>(from));
  } catch (const py::error_already_set& error) {
    if (error.matches(PyExc_MemoryError)) throw;
    throw py::type_error(expected);
  }
  const char kind = any.dtype().kind();
  if (kind != 'f' && kind != 'i' && kind != 'u' && kind != 'b')
    throw py::type_error(expected + ", found one of " +
                         static_cast<std::string>(py::str(any.dtype())));
  return any;
}

std::vector<py::ssize_t> shape_of(const py::array& array) {
  return {array.shape(), array.shape() + array.ndim()};
}

/// Only of a shape that was looked at: what is too large or has another is not copied first.
Numbers copied(const py::array& any, std::vector<py::ssize_t> shape, const std::string& what) {
  const Plain plain(any);
  Numbers out{std::move(shape), {plain.data(), plain.data() + plain.size()}};
  for (std::size_t i = 0; i < out.value.size(); ++i)
    if (!std::isfinite(out.value[i]))
      throw py::value_error(what + place_text(i, out.shape) + " is not a finite number");
  return out;
}

[[noreturn]] void refuse_shape(const std::string& what, const std::string& words,
                               const std::vector<py::ssize_t>& found) {
  throw py::value_error(what + ": expected " + words + ", found " + shape_text(found));
}

/// Matrices of an array of doubles, read by its strides without a copy of it, as skinning pose
/// after pose asks. Nothing where it is another array, or a number is not finite.
std::optional<std::vector<glm::dmat4>> doubles_in_place(py::handle from, py::ssize_t each) {
  if (!py::isinstance<py::array_t<double>>(from)) return std::nullopt;
  const auto array = py::reinterpret_borrow<py::array>(from);
  const py::ssize_t dimensions = array.ndim();
  if (dimensions != 3 && dimensions != 4) return std::nullopt;
  const py::ssize_t* shape = array.shape() + (dimensions - 3);
  const py::ssize_t* stride = array.strides() + (dimensions - 3);
  if (shape[0] != each || shape[1] != 4 || shape[2] != 4) return std::nullopt;
  const py::ssize_t poses = dimensions == 4 ? array.shape(0) : 1;
  constexpr py::ssize_t kNumber = sizeof(double);
  const bool as_ours = stride[1] == kNumber && stride[2] == 4 * kNumber;  // Poses.matrices
  std::vector<glm::dmat4> out(static_cast<std::size_t>(poses * each));
  glm::dmat4* to = out.data();
  for (py::ssize_t p = 0; p < poses; ++p) {
    const auto* matrix = static_cast<const std::byte*>(array.data());
    if (dimensions == 4) matrix += p * array.strides(0);
    for (py::ssize_t m = 0; m < each; ++m, ++to, matrix += stride[0]) {
      if (as_ours) {
        std::memcpy(to, matrix, sizeof *to);
        continue;
      }
      for (int row = 0; row < 4; ++row)
        for (int column = 0; column < 4; ++column)
          std::memcpy(&(*to)[column][row], matrix + row * stride[1] + column * stride[2], kNumber);
    }
  }
  // Zero times a number is zero, unless it is not finite.
  glm::dmat4 sum(0.0);
  for (const glm::dmat4& matrix : out) sum += 0.0 * matrix;
  return sum == glm::dmat4(0.0) ? std::optional(std::move(out)) : std::nullopt;
}

bool fits(const std::vector<py::ssize_t>& shape, const std::vector<py::ssize_t>& expected) {
  if (shape.size() != expected.size()) return false;
  for (std::size_t d = 0; d < shape.size(); ++d)
    if (expected[d] >= 0 && shape[d] != expected[d]) return false;
  return true;
}

}  // namespace

Numbers read_numbers(py::handle from, const std::string& what, const std::string& words,
                     const std::vector<py::ssize_t>& expected) {
  const py::array any = real_array(from, what);
  const std::vector<py::ssize_t> shape = shape_of(any);
  if (!fits(shape, expected)) refuse_shape(what, words, shape);
  return copied(any, shape, what);
}

Numbers read_rows(py::handle from, const std::string& what, const std::string& words,
                  py::ssize_t width) {
  const py::array any = real_array(from, what);
  std::vector<py::ssize_t> shape = shape_of(any);
  if (fits(shape, {width})) shape.insert(shape.begin(), 1);
  if (!fits(shape, {-1, width})) refuse_shape(what, words, shape);
  return copied(any, shape, what);
}

std::vector<glm::dmat4> matrices_of(const Numbers& numbers) {
  std::vector<glm::dmat4> out(numbers.value.size() / 16);
  for (std::size_t m = 0; m < out.size(); ++m)
    for (int row = 0; row < 4; ++row)
      for (int column = 0; column < 4; ++column)
        out[m][column][row] = numbers.value[16 * m + static_cast<std::size_t>(4 * row + column)];
  return out;
}

std::vector<glm::dmat4> read_matrices(py::handle from, const std::string& what, py::ssize_t each) {
  if (std::optional<std::vector<glm::dmat4>> found = doubles_in_place(from, each))
    return std::move(*found);
  py::object given = py::reinterpret_borrow<py::object>(from);
  const py::array any = py::array::ensure(given);
  PyErr_Clear();
  if (any && any.ndim() == 3) given = any[py::make_tuple(py::none(), py::ellipsis())];
  return matrices_of(read_numbers(given, what, "N x " + std::to_string(each) + " x 4 x 4 numbers",
                                  {-1, each, 4, 4}));
}

std::string text_from(py::handle text, const std::string& what) {
  if (!py::isinstance<py::str>(text)) throw py::type_error(what + ": expected text");
  const auto bytes = py::reinterpret_steal<py::object>(
      PyUnicode_AsEncodedString(text.ptr(), "utf-8", "surrogateescape"));
  if (!bytes) {
    PyErr_Clear();
    throw py::value_error(what + ": the text holds half a character (a lone surrogate)");
  }
  return bytes.cast<std::string>();
}

py::object record(const char* kind, const py::dict& values) {
  // Never released: the module that defines the kinds lives as long as this one.
  static const py::handle module = py::module_::import("backbend").release();
  return module.attr(kind)(values);
}

py::array matrices_view(const std::shared_ptr<std::vector<glm::dmat4>>& matrices, py::ssize_t poses,
                        py::ssize_t each) {
  constexpr py::ssize_t kNumber = sizeof(double), kMatrix = sizeof(glm::dmat4);
  const auto* data = reinterpret_cast<const double*>(matrices->data());
  return view_of<double>(data, {poses, each, 4, 4}, matrices,
                         {each * kMatrix, kMatrix, kNumber, 4 * kNumber}, true);
}

}  // namespace backbend::python
