// SPDX-License-Identifier: GPL-3.0-or-later
// NumPy arrays that are attributes of Python objects, as spans: no copy, and no doubt about their type.
// What the arrays mean is told in addon/export/buffers.py.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>

#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace cotorra {

namespace nb = nanobind;

template <class Scalar>
using Array = nb::ndarray<const Scalar, nb::c_contig, nb::device::cpu>;

// The array `object.name`, viewed as Ts; its last dimension must fill one T. `keep` holds what the view needs alive.
template <class T, class Scalar>
std::span<const T> view(nb::handle object, const char *name, std::vector<nb::object> &keep) {
  nb::object value = nb::getattr(object, name);
  if (value.is_none()) return {};
  Array<Scalar> array;
  if (!nb::try_cast(value, array, false)) {  // converted, it would be a copy that is gone when the view is read
    const std::string type = nb::cast<std::string>(nb::repr(nb::getattr(value, "dtype", value.type())));
    throw std::invalid_argument(std::string(name) + " is not a C-contiguous array of the expected type, but " + type);
  }
  constexpr std::size_t components = sizeof(T) / sizeof(Scalar);
  if (components > 1 && (array.ndim() == 0 || array.shape(array.ndim() - 1) != components)) {
    throw std::invalid_argument(std::string(name) + " must have " + std::to_string(components) + " columns");
  }
  keep.push_back(std::move(value));
  return {reinterpret_cast<const T *>(array.data()), array.size() / components};
}

}  // namespace cotorra
