// Checks at the public door: what came, what was expected, by the argument's name. Arrays are read in place through the
// buffer protocol, which costs a fraction of an array conversion.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>

#define NPY_NO_DEPRECATED_API NPY_2_0_API_VERSION
#include <numpy/ndarraytypes.h>

#include <cmath>
#include <string>
#include <utility>

namespace nb = nanobind;

// Raises stillreach.errors.InputError(argument, got, expected).
[[noreturn]] inline void refuse(const char* argument, const std::string& got, const std::string& expected) {
  const nb::object type = nb::module_::import_("stillreach.errors").attr("InputError");
  const nb::object error = type(argument, got, expected);
  PyErr_SetObject(type.ptr(), error.ptr());
  nb::raise_python_error();
}

// A borrowed view of a float64 array; the array cannot be resized or freed while it lives.
class View {
 public:
  View() = default;
  View(View&& other) noexcept : buffer_(other.buffer_), open_(std::exchange(other.open_, false)) {}
  View(const View&) = delete;
  View& operator=(const View&) = delete;
  View& operator=(View&& other) noexcept {
    if (open_) PyBuffer_Release(&buffer_);
    buffer_ = other.buffer_;
    open_ = std::exchange(other.open_, false);
    return *this;
  }
  ~View() {
    if (open_) PyBuffer_Release(&buffer_);
  }
  // False, with no error set, where the object has no such buffer.
  bool open(nb::handle object) {
    if (PyObject_GetBuffer(object.ptr(), &buffer_, PyBUF_STRIDES | PyBUF_FORMAT) != 0) {
      PyErr_Clear();
      return false;
    }
    return open_ = true;
  }
  PyObject* owner() const { return open_ ? buffer_.obj : nullptr; }
  double* data() const { return static_cast<double*>(buffer_.buf); }
  bool is_double() const { return buffer_.format && buffer_.format[0] == 'd' && buffer_.format[1] == 0; }
  bool is_writable() const { return !buffer_.readonly; }
  bool is_aligned(std::size_t to = alignof(double)) const {
    return reinterpret_cast<std::uintptr_t>(buffer_.buf) % to == 0;
  }
  int ndim() const { return buffer_.ndim; }
  long size(int axis) const { return static_cast<long>(buffer_.shape[axis]); }
  long bytes() const { return static_cast<long>(buffer_.len); }
  bool is_contiguous() const { return PyBuffer_IsContiguous(&buffer_, 'C'); }

 private:
  Py_buffer buffer_{};
  bool open_ = false;
};

inline PyTypeObject* array_type() {
  static PyObject* const type = nb::object(nb::module_::import_("numpy").attr("ndarray")).release().ptr();
  return reinterpret_cast<PyTypeObject*>(type);
}

// A NumPy vector of `length` float64 in place, without the cost of the buffer protocol; null where it is something
// else. Only macros of NumPy's headers are used and none of its functions, so that the module needs no NumPy to load.
inline double* numpy_vector(nb::handle object, long length, bool writable = false) {
  PyArrayObject* const array = reinterpret_cast<PyArrayObject*>(object.ptr());
  if (Py_TYPE(object.ptr()) != array_type()) return nullptr;
  const PyArray_Descr* const type = PyArray_DESCR(array);
  if (type->type_num != NPY_DOUBLE || !PyArray_ISNBO(type->byteorder)) return nullptr;
  if (PyArray_NDIM(array) != 1 || PyArray_DIM(array, 0) != length) return nullptr;
  if (!PyArray_CHKFLAGS(array, writable ? NPY_ARRAY_CARRAY : NPY_ARRAY_CARRAY_RO)) return nullptr;
  return static_cast<double*>(PyArray_DATA(array));
}

// One of NumPy's arrays with a mask, which the buffer protocol does not show.
inline bool is_masked(nb::handle object) {
  if (Py_TYPE(object.ptr()) == array_type() || !PyObject_TypeCheck(object.ptr(), array_type())) return false;
  return nb::cast<bool>(nb::module_::import_("stillreach._door").attr("is_masked")(object));
}

inline std::string shape_text(std::initializer_list<long> shape) {
  std::string text = "(";
  for (long s : shape) text += (s < 0 ? std::string("N") : std::to_string(s)) + ", ";
  text.resize(text.size() - (shape.size() == 1 ? 1 : 2));
  return text + ")";
}

// What came, in words.
inline std::string describe(nb::handle object) {
  return nb::cast<std::string>(nb::module_::import_("stillreach._door").attr("describe")(object));
}

// Opens `object` in place: float64, C-contiguous, aligned, of this shape (-1: any length); and writable where asked.
inline View strict(const char* argument, nb::handle object, std::initializer_list<long> shape, bool writable) {
  View view;
  const auto wanted = [&] {
    return std::string(writable ? "a writable" : "a") + " C-contiguous float64 array of shape " + shape_text(shape);
  };
  if (!view.open(object)) refuse(argument, describe(object), wanted());
  bool fits = view.ndim() == static_cast<int>(shape.size());
  int axis = 0;
  for (long s : shape) {
    fits = fits && (s < 0 || view.size(axis) == s);
    ++axis;
  }
  if (!fits || !view.is_double()) refuse(argument, describe(object), wanted());
  if (!view.is_contiguous() || !view.is_aligned()) refuse(argument, describe(object) + ", not contiguous", wanted());
  if (writable && !view.is_writable()) refuse(argument, describe(object) + ", read-only", wanted());
  if (is_masked(object)) refuse(argument, "a masked array", wanted());
  return view;
}

// Fast check that an input other than NumPy's can be read in place.
inline bool readable(View& view, nb::handle object, long length) {
  if (PyObject_TypeCheck(object.ptr(), array_type()) || !view.open(object) || view.ndim() != 1) return false;
  return view.size(0) == length && view.is_double() && view.is_contiguous() && view.is_aligned();
}

// Reads `length` finite numbers from anything that the door turns into a float64 vector; by `labels` where it has
// labels.
inline void read_vector(const char* argument, nb::handle object, long length, double* to, bool finite = true,
                        nb::handle labels = nb::none()) {
  View view;
  if (const double* in_place = numpy_vector(object, length)) {
    for (long i = 0; i < length; ++i) to[i] = in_place[i];
  } else if (readable(view, object, length)) {
    for (long i = 0; i < length; ++i) to[i] = view.data()[i];
  } else {
    const nb::object array = nb::module_::import_("stillreach._door")
                                 .attr("vector")(argument, object, length, nb::arg("allow_inf") = !finite,
                                                 nb::arg("one_for_all") = false, nb::arg("labels") = labels);
    View converted = strict(argument, array, {length}, false);
    for (long i = 0; i < length; ++i) to[i] = converted.data()[i];
  }
  if (!finite) return;
  for (long i = 0; i < length; ++i)
    if (!std::isfinite(to[i]))
      refuse(argument, std::to_string(to[i]) + " at index " + std::to_string(i), "finite numbers");
}

// A new float64 array of NumPy's.
inline nb::object new_array(nb::handle shape) {
  static PyObject* const empty = nb::object(nb::module_::import_("numpy").attr("empty")).release().ptr();
  PyObject* const arguments[] = {nullptr, shape.ptr()};
  PyObject* array = PyObject_Vectorcall(empty, arguments + 1, 1 | PY_VECTORCALL_ARGUMENTS_OFFSET, nullptr);
  if (!array) nb::raise_python_error();
  return nb::steal(array);
}

// A new float64 vector. NumPy's own constructor costs a third of numpy.empty; it is taken from its place in NumPy's C
// API (the table's entries keep theirs), once it has been seen to make what it should.
inline nb::object new_vector(long length) {
  using New = PyObject* (*)(PyTypeObject*, int, const Py_ssize_t*, int, const Py_ssize_t*, void*, int, int, PyObject*);
  struct Known {
    PyTypeObject* array = nullptr;
    New make = nullptr;
    Known() {
      try {
        const nb::object numpy = nb::module_::import_("numpy");
        nb::object api =
            nb::module_::import_(nb::hasattr(numpy, "_core") ? "numpy._core.multiarray" : "numpy.core.multiarray")
                .attr("_ARRAY_API");
        void** table = static_cast<void**>(PyCapsule_GetPointer(api.ptr(), nullptr));
        if (!table) nb::raise_python_error();
        if (table[2] != numpy.attr("ndarray").ptr()) return;
        array = static_cast<PyTypeObject*>(table[2]);
        make = reinterpret_cast<New>(table[93]);
        const nb::object sample = vector(3);
        if (!sample.is_valid() || !numpy_vector(sample, 3, true)) make = nullptr;
      } catch (nb::python_error&) {
        make = nullptr;
      }
    }
    nb::object vector(Py_ssize_t length) const {
      constexpr int float64 = 12;  // NPY_DOUBLE
      return nb::steal(make(array, 1, &length, float64, nullptr, nullptr, 0, 0, nullptr));
    }
  };
  static const Known known;
  if (!known.make) return new_array(nb::int_(length));
  nb::object made = known.vector(length);
  if (!made.is_valid()) nb::raise_python_error();
  return made;
}
