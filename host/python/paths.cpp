// Checks and traced paths as arrays.

#include <pybind11/stl.h>

#include <array>
#include <string>
#include <vector>

#include "module.hpp"

namespace regulus {

namespace {

template <size_t Size>
py::array_t<double> array_of(const std::array<double, Size>& values) {
  return py::array_t<double>(Size, values.data());
}

/// One field of all vertices: an array of as many rows.
template <typename Value>
py::array column(const std::vector<TracedVertex>& vertices, Value TracedVertex::*field) {
  py::array_t<Value> result(static_cast<py::ssize_t>(vertices.size()));
  auto values = result.template mutable_unchecked<1>();
  for (size_t i = 0; i < vertices.size(); ++i) values(static_cast<py::ssize_t>(i)) = vertices[i].*field;
  return result;
}

py::array column(const std::vector<TracedVertex>& vertices, std::array<double, 3> TracedVertex::*field) {
  py::array_t<double> result({static_cast<py::ssize_t>(vertices.size()), py::ssize_t{3}});
  auto values = result.mutable_unchecked<2>();
  for (size_t i = 0; i < vertices.size(); ++i)
    for (size_t c = 0; c < 3; ++c)
      values(static_cast<py::ssize_t>(i), static_cast<py::ssize_t>(c)) = (vertices[i].*field)[c];
  return result;
}

py::dict arrays_of(const std::vector<TracedVertex>& vertices) {
  py::dict result;
  result["position"] = column(vertices, &TracedVertex::position);
  result["geometric_normal"] = column(vertices, &TracedVertex::geometric_normal);
  result["shading_normal"] = column(vertices, &TracedVertex::shading_normal);
  result["triangle"] = column(vertices, &TracedVertex::triangle);
  result["material"] = column(vertices, &TracedVertex::material);
  result["throughput"] = column(vertices, &TracedVertex::throughput);
  result["bsdf"] = column(vertices, &TracedVertex::bsdf);
  result["pdf_to_light"] = column(vertices, &TracedVertex::pdf_to_light);
  result["pdf_to_camera"] = column(vertices, &TracedVertex::pdf_to_camera);
  result["is_delta"] = column(vertices, &TracedVertex::is_delta);
  result["is_on_device"] = column(vertices, &TracedVertex::is_on_device);
  result["device_position"] = column(vertices, &TracedVertex::device_position);
  result["device_throughput"] = column(vertices, &TracedVertex::device_throughput);
  result["device_triangle"] = column(vertices, &TracedVertex::device_triangle);
  result["device_mis_a"] = column(vertices, &TracedVertex::device_mis_a);
  result["device_mis_b"] = column(vertices, &TracedVertex::device_mis_b);
  return result;
}

py::dict dictionary_of(const TracedContribution& found) {
  py::list names;
  std::vector<double> densities, weights;
  for (const TracedTechnique& technique : found.techniques) {
    names.append(technique.name);
    densities.push_back(technique.density);
    weights.push_back(technique.weight);
  }
  py::dict result;
  result["technique"] = found.technique;
  result["edges"] = found.edges;
  result["weight"] = found.weight;
  result["unweighted"] = array_of(found.unweighted);
  result["techniques"] = names;
  result["densities"] = py::array_t<double>(static_cast<py::ssize_t>(densities.size()), densities.data());
  result["weights"] = py::array_t<double>(static_cast<py::ssize_t>(weights.size()), weights.data());
  return result;
}

py::dict trace(const Plan& plan, const Device& device, uint32_t x, uint32_t y, uint32_t sample) {
  TracedPath path;
  {
    const py::gil_scoped_release released;
    path = trace_path(plan, device, x, y, sample);
  }
  py::list contributions;
  for (const TracedContribution& found : path.contributions) contributions.append(dictionary_of(found));
  py::dict result;
  result["film"] = array_of(path.film);
  result["origin"] = array_of(path.origin);
  result["direction"] = array_of(path.direction);
  result["device_origin"] = array_of(path.device_origin);
  result["device_direction"] = array_of(path.device_direction);
  result["vertices"] = arrays_of(path.vertices);
  result["contributions"] = contributions;
  result["radiance"] = array_of(path.radiance);
  result["device_radiance"] = array_of(path.device_radiance);
  return result;
}

}  // namespace

void bind_checks(py::module_& module) {
  py::class_<CheckLine>(module, "CheckLine")
      .def_readonly("name", &CheckLine::name)
      .def_readonly("items", &CheckLine::items)
      .def_readonly("is_passed", &CheckLine::is_passed)
      .def_readonly("text", &CheckLine::text);
  module.def(
      "check_device", [](const Plan& plan, const Device& device) { return check_device(plan, device); },
      py::arg("plan"), py::arg("device"), py::call_guard<py::gil_scoped_release>());
  module.def("trace_path", &trace, py::arg("plan"), py::arg("device"), py::arg("x"), py::arg("y"),
             py::arg("sample") = 0);
}

}  // namespace regulus
