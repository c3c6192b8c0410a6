// regulus._core: libregulus for Python. What is more comfortable in Python is in regulus/__init__.py.

#include "module.hpp"

#include <pybind11/functional.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <exception>
#include <string>
#include <variant>

namespace {

using namespace regulus;

/// What Scene.prepare() gives.
struct PreparedHandle {
  Prepared scene;
};

const char* name_of(ErrorCode code) {
  switch (code) {
    case ErrorCode::BadUsage:
      return "BAD_USAGE";
    case ErrorCode::BadFile:
      return "BAD_FILE";
    case ErrorCode::NoDevice:
      return "NO_DEVICE";
    case ErrorCode::Interrupted:
      return "INTERRUPTED";
    default:
      return "FAILED";
  }
}

void bind_errors(py::module_& module) {
  static py::exception<Error> error(module, "Error", PyExc_RuntimeError);
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      std::rethrow_exception(thrown);
    } catch (const Error& caught) {
      py::object raised = py::reinterpret_borrow<py::object>(error.ptr())(caught.what());
      raised.attr("code") = name_of(caught.code());
      PyErr_SetObject(error.ptr(), raised.ptr());
    }
  });
}

void bind_scene(py::module_& module) {
  py::class_<Camera>(module, "Camera")
      .def(py::init<>())
      .def_readwrite("name", &Camera::name)
      .def_readwrite("position", &Camera::position)
      .def_readwrite("direction", &Camera::direction)
      .def_readwrite("up", &Camera::up)
      .def_readwrite("is_orthographic", &Camera::is_orthographic)
      .def_readwrite("vertical_fov", &Camera::vertical_fov)
      .def_readwrite("half_height", &Camera::half_height)
      .def_readwrite("aspect_ratio", &Camera::aspect_ratio)
      .def_readwrite("lens_radius", &Camera::lens_radius)
      .def_readwrite("focus_distance", &Camera::focus_distance)
      .def(
          "look_at",
          [](const Camera& camera, const std::array<double, 3>& position, const std::array<double, 3>& target,
             const std::array<double, 3>& up) { return look_at(camera, position, target, up); },
          py::arg("position"), py::arg("target"), py::arg("up") = std::array<double, 3>{0, 1, 0});
  py::class_<PreparedHandle>(module, "PreparedScene");
  py::class_<Scene>(module, "Scene")
      .def_property_readonly("path", &Scene::path)
      .def_property_readonly("edits", &Scene::edits)
      .def_property_readonly("warnings", &Scene::warnings)
      .def_property_readonly("settings", &Scene::settings)
      .def_property_readonly("cameras", &Scene::cameras)
      .def("set_camera", &Scene::set_camera, py::arg("index"), py::arg("camera"))
      .def_property_readonly("bounds_min", &Scene::bounds_min)
      .def_property_readonly("bounds_max", &Scene::bounds_max)
      .def_property_readonly("triangle_count", &Scene::triangle_count)
      .def_property_readonly("material_names", &Scene::material_names)
      .def("prepare", [](const Scene& scene) {
        const py::gil_scoped_release released;
        return PreparedHandle{prepare(scene)};
      });
  py::class_<LoadOptions>(module, "LoadOptions")
      .def(py::init<>())
      .def_readwrite("scene", &LoadOptions::scene)
      .def_readwrite("variant", &LoadOptions::variant)
      .def_readwrite("animation", &LoadOptions::animation)
      .def_readwrite("time", &LoadOptions::time)
      .def_readwrite("environment", &LoadOptions::environment)
      .def_readwrite("environment_rotation", &LoadOptions::environment_rotation)
      .def_readwrite("environment_scale", &LoadOptions::environment_scale)
      .def_readwrite("edits", &LoadOptions::edits)
      .def_readwrite("allow_external", &LoadOptions::allow_external)
      .def_readwrite("is_strict", &LoadOptions::is_strict)
      .def_readwrite("memory_bytes", &LoadOptions::memory_bytes);
  module.def("load", &load, py::arg("path"), py::arg("options"), py::call_guard<py::gil_scoped_release>());
}

/// Values by pixel as an array of `shape`.
template <typename Value>
py::array pixels_of(const std::vector<Value>& values, const std::vector<py::ssize_t>& shape) {
  return py::array_t<Value>(shape, values.data());
}

py::dict channels_of(const Picture& picture) {
  py::dict result;
  for (const auto& [name, channel] : picture.channels)
    result[py::str(name)] = std::visit(
        [&](const auto& values) -> py::array {
          return pixels_of(values, {picture.height, picture.width});
        },
        channel);
  return result;
}

Picture picture_of(const py::array_t<float, py::array::c_style | py::array::forcecast>& rgb) {
  if (rgb.ndim() != 3 || rgb.shape(2) != 3)
    throw Error(ErrorCode::BadUsage, "a picture is an array of height x width x 3 values");
  return {.width = static_cast<uint32_t>(rgb.shape(1)),
          .height = static_cast<uint32_t>(rgb.shape(0)),
          .rgb = std::vector<float>(rgb.data(), rgb.data() + rgb.size()),
          .channels = {},
          .attributes = {}};
}

void bind_pictures(py::module_& module) {
  py::class_<Picture>(module, "Picture")
      .def(py::init(&picture_of), py::arg("rgb"))
      .def_property_readonly("rgb",
                             [](const Picture& picture) {
                               return pixels_of(picture.rgb, {picture.height, picture.width, 3});
                             })
      .def_property_readonly("channels", &channels_of)
      .def_readonly("attributes", &Picture::attributes)
      .def_readonly("width", &Picture::width)
      .def_readonly("height", &Picture::height)
      .def_readonly("x", &Picture::x)
      .def_readonly("y", &Picture::y)
      .def(
          "write",
          [](const Picture& picture, const std::filesystem::path& path, float exposure) {
            write_picture(path, picture, exposure);
          },
          py::arg("path"), py::arg("exposure") = 0.0f)
      .def("compare", &compare, py::arg("reference"));
  py::class_<Comparison>(module, "Comparison")
      .def_readonly("mse", &Comparison::mse)
      .def_readonly("relmse", &Comparison::relmse)
      .def_readonly("mae", &Comparison::mae)
      .def_readonly("psnr", &Comparison::psnr)
      .def_readonly("flip", &Comparison::flip)
      .def_readonly("mean", &Comparison::mean)
      .def_readonly("reference_mean", &Comparison::reference_mean)
      .def_readonly("non_finite", &Comparison::non_finite);
  module.def("read_picture", &read_picture, py::arg("path"));
}

/// Renders without holding Python's lock. An exception of `progress`, and Ctrl+C, stop the render, which
/// keeps what is done, and are raised then.
Outcome render_interruptibly(Renderer& renderer, const py::object& progress) {
  std::exception_ptr raised;
  Outcome outcome;
  {
    const py::gil_scoped_release released;
    outcome = renderer.render([&](uint64_t done, uint64_t all) {
      const py::gil_scoped_acquire acquired;
      try {
        if (PyErr_CheckSignals() != 0) throw py::error_already_set();
        if (progress.is_none()) return true;
        const py::object answer = progress(done, all);
        return answer.is_none() || answer.cast<bool>();
      } catch (const std::exception&) {
        raised = std::current_exception();
        return false;
      }
    });
  }
  if (raised) std::rethrow_exception(raised);
  return outcome;
}

void bind_rendering(py::module_& module) {
  py::class_<Settings>(module, "Settings")
      .def(py::init<>())
      .def(
          "set",
          [](Settings& settings, const std::string& name, const std::string& value) {
            settings.set(name, value);
          },
          py::arg("name"), py::arg("value"))
      .def_property_readonly("values", &Settings::values)
      .def_static("known", [] {
        std::map<std::string, std::string> known;
        for (const SettingDescription& setting : Settings::known()) known[setting.name] = setting.values;
        return known;
      });
  py::class_<Device>(module, "Device").def_property_readonly("name", &Device::name);
  py::class_<DeviceDescription>(module, "DeviceDescription")
      .def_readonly("name", &DeviceDescription::name)
      .def_readonly("driver", &DeviceDescription::driver)
      .def_readonly("is_software", &DeviceDescription::is_software)
      .def_readonly("missing", &DeviceDescription::missing);
  module.def("list_devices", &list_devices);
  module.def("open_device", &open_device, py::arg("select") = "", py::arg("memory_bytes") = 0);
  module.def("reference_device", &reference_device);
  py::class_<Plan>(module, "Plan")
      .def_property_readonly("width", &Plan::width)
      .def_property_readonly("height", &Plan::height)
      .def_property_readonly("samples", &Plan::samples)
      .def_property_readonly("techniques", &Plan::techniques)
      .def_property_readonly("merge_radius", &Plan::merge_radius)
      .def_property_readonly("dropped",
                             [](const Plan& plan) {
                               std::map<std::string, std::string> result;
                               for (const Dropped& dropped : plan.dropped())
                                 result[dropped.what] = dropped.why;
                               return result;
                             })
      .def_property_readonly("warnings", &Plan::warnings)
      .def_property_readonly("description", &Plan::description);
  module.def(
      "make_plan",
      [](const PreparedHandle& prepared, const Settings& settings) {
        return make_plan(prepared.scene, settings);
      },
      py::arg("scene"), py::arg("settings"), py::call_guard<py::gil_scoped_release>());
  py::class_<Outcome>(module, "Outcome")
      .def_readonly("is_complete", &Outcome::is_complete)
      .def_readonly("samples", &Outcome::samples)
      .def_readonly("noise", &Outcome::noise)
      .def_readonly("summary", &Outcome::summary)
      .def_readonly("warnings", &Outcome::warnings);
  py::class_<Renderer>(module, "Renderer")
      .def(py::init<const Plan&, const Device&>(), py::arg("plan"), py::arg("device"))
      .def("checkpoint", &Renderer::checkpoint, py::arg("path"), py::arg("seconds") = 60.0)
      .def("resume", &Renderer::resume, py::arg("path"))
      .def("render", &render_interruptibly, py::arg("progress") = py::none())
      .def("picture", &Renderer::picture)
      .def("write_part", &Renderer::write_part, py::arg("path"))
      .def("statistics_json", &Renderer::statistics);
  module.def("merge_parts", &merge_parts, py::arg("parts"), py::arg("output"));
}

}  // namespace

PYBIND11_MODULE(_core, module) {
  bind_errors(module);
  bind_scene(module);
  bind_pictures(module);
  bind_rendering(module);
  regulus::bind_checks(module);
}
