"""Regulus: robust light transport for glTF scenes on Vulkan devices.

    import regulus
    scene = regulus.load("scene.gltf")
    picture = regulus.render(scene, integrator="vcm", spp=64, size=(640, 360), aov=["albedo", "Z"])
    picture.rgb             # float32, height x width x 3, linear Rec. 709, rows from the top
    picture["albedo"]       # an AOV, height x width (x 3)
    picture.write("picture.exr")

Settings are the long options of ``regulus render`` (``regulus.settings()`` lists them), with "_" for "-".
What goes wrong raises ``regulus.Error`` with the text of the command line, and a ``code``.
"""

import json as _json

import numpy as _numpy

from . import _core
from ._core import (Camera, CheckLine, Comparison, Device, DeviceDescription, Error, Outcome, Picture, Plan,
                    PreparedScene, Scene, list_devices, open_device, read_picture, reference_device)

__all__ = ["Camera", "CheckLine", "Comparison", "Device", "DeviceDescription", "Error", "Outcome", "Picture", "Plan",
           "PreparedScene", "Renderer", "Scene", "check", "list_devices", "load", "make_plan", "merge_parts",
           "open_device", "read_picture", "reference_device", "render", "settings", "trace_path"]


def load(path, **options):
    """Reads a .gltf or .glb file.

    Options: scene (index), variant, animation, time (seconds), environment (file), environment_rotation (degrees),
    environment_scale, edits (a list like ["materials.Glass.roughness=0.1"], as of the command line's -D), allow_external,
    is_strict, memory_bytes.
    """
    given = _core.LoadOptions()
    for name, value in options.items():
        if not hasattr(given, name):
            raise TypeError(f"load() has no option {name!r}")
        setattr(given, name, value)
    return _core.load(path, given)


def settings():
    """What a render can be asked for: the values that each setting takes, in words, by name."""
    return {name.replace("-", "_"): values for name, values in _core.Settings.known().items()}


_SEPARATORS = {"size": "x", "samples": ":"}


def _text(name, value):
    if isinstance(value, (bool, _numpy.bool_)):
        return "true" if value else "false"
    if isinstance(value, (list, tuple)):
        return _SEPARATORS.get(name, ",").join(str(part) for part in value)
    return str(value)


def make_plan(scene, **settings):
    """Decides what is done of the scene's settings and these, which win.

    ``scene`` is a Scene, which is prepared for this plan alone, or what Scene.prepare() gives, which may be shared.
    """
    prepared = scene.prepare() if isinstance(scene, Scene) else scene
    chosen = _core.Settings()
    for name, value in settings.items():
        if value is not None:
            chosen.set(name.replace("_", "-"), _text(name, value))
    return _core.make_plan(prepared, chosen)


class Renderer(_core.Renderer):
    """Renders a plan with a device. render() may be stopped, and goes on when it is called again."""

    def statistics(self):
        """Times, rays, memory, scene and settings of the last render()."""
        return _json.loads(self.statistics_json())


def _device(backend, device):
    if isinstance(device, Device):
        return device
    if backend == "reference":
        return reference_device()
    if backend != "vulkan":
        raise ValueError(f"backend {backend!r} is not one of vulkan, reference")
    return open_device(device)


def render(scene, backend="vulkan", device="", progress=None, **settings):
    """Renders a Scene, or what Scene.prepare() gives, to a Picture.

    backend: "vulkan", or "reference" for the scalar double-precision reference. device: a Device that is already
    open, an index or part of a name. progress(paths_done, paths_total) is called many times a second; if it returns
    False the render stops, and the picture has the samples that are done. Ctrl+C raises KeyboardInterrupt.
    """
    renderer = Renderer(make_plan(scene, **settings), _device(backend, device))
    renderer.render(progress)
    return renderer.picture()


def merge_parts(parts, output):
    """Joins ranges of samples or crops of one render (Renderer.write_part) exactly."""
    _core.merge_parts(list(parts), output)


def check(scene, device="", **settings):
    """Holds every stage of a device against the scalar reference: a list of CheckLine."""
    return _core.check_device(make_plan(scene, **settings), _device("vulkan", device))


def trace_path(scene, x, y, sample=0, device="", **settings):
    """One camera path by the reference and by a device, with the same random numbers, as a dict.

    "vertices" holds an array for each quantity, a row for each vertex: position, normals, bsdf, pdf_to_light and
    pdf_to_camera (1/sr) and so on of the reference, and those that begin with device_. "contributions" lists the
    paths that were found, each with the densities and weights of all techniques that could have found it.
    """
    return _core.trace_path(make_plan(scene, **settings), _device("vulkan", device), x, y, sample)


def _channel(picture, name):
    channels = picture.channels
    if name in channels:
        return channels[name]
    for parts in ("RGB", "XYZ"):
        names = [f"{name}.{part}" for part in parts]
        if all(each in channels for each in names):
            return _numpy.stack([channels[each] for each in names], axis=-1)
    raise KeyError(f"{name}: the picture has {', '.join(sorted(channels)) or 'no channels but rgb'}")


Picture.__getitem__ = _channel
