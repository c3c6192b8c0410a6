// What the sources of regulus._core share.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <regulus/regulus.hpp>

namespace py = pybind11;

namespace regulus {

/// Binds check() and trace_path().
void bind_checks(py::module_& module);

}  // namespace regulus
