"""The Python module, on the scene of library.cpp: a square of albedo 0.5, 2 m wide, under a point light."""

import base64
import json
import os
import signal
import tempfile
import threading
import time
import unittest

import numpy as np

import regulus

FOLDER = tempfile.TemporaryDirectory()
SCENE = os.path.join(FOLDER.name, "square.gltf")
MIDDLE = 0.5 / np.pi  # W / (m^2 sr)
SMALL = {"size": (9, 9), "spp": 4, "filter": "box"}


def write_square(path):
    positions = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], np.float32)
    data = positions.tobytes() + np.array([0, 1, 2, 0, 2, 3], np.uint32).tobytes()
    scene = {
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": 72,
                     "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode()}],
        "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 24}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [-1, -1, 0],
                       "max": [1, 1, 0]}, {"bufferView": 1, "componentType": 5125, "count": 6, "type": "SCALAR"}],
        "materials": [{"pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.5, 0.5, 1], "metallicFactor": 0},
                       "extensions": {"KHR_materials_specular": {"specularFactor": 0}}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.8, "znear": 1e-7}}],
        "extensionsUsed": ["KHR_lights_punctual", "KHR_materials_specular"],
        "extensions": {"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 1}]}},
        "nodes": [{"mesh": 0}, {"camera": 0, "translation": [0, 0, 2]},
                  {"translation": [0, 0, 1], "extensions": {"KHR_lights_punctual": {"light": 0}}}],
        "scenes": [{"nodes": [0, 1, 2]}],
        "scene": 0,
    }
    with open(path, "w", encoding="utf-8") as file:
        json.dump(scene, file)


class Module(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        write_square(SCENE)
        cls.scene = regulus.load(SCENE)
        cls.device = regulus.open_device()

    def test_both_backends_find_the_known_radiance(self):
        half_pixel = 2 * np.tan(0.4) / 9
        least = MIDDLE / (1 + 2 * half_pixel**2) ** 1.5
        for backend in ("vulkan", "reference"):
            picture = regulus.render(self.scene, backend=backend, **SMALL)
            self.assertEqual(picture.rgb.shape, (9, 9, 3))
            self.assertEqual(picture.rgb.dtype, np.float32)
            self.assertLessEqual(picture.rgb[4, 4, 0], MIDDLE * (1 + 1e-5))
            self.assertGreaterEqual(picture.rgb[4, 4, 0], least * (1 - 1e-5))

    def test_camera_moves(self):
        scene = regulus.load(SCENE)
        camera = scene.cameras[0]
        camera.position = [0.5, 0, 2]
        scene.set_camera(0, camera)
        moved = regulus.render(scene, device=self.device, **SMALL).rgb[4, 4, 0]
        self.assertLess(moved, MIDDLE / (1 + 0.4**2) ** 1.5)
        self.assertGreater(moved, MIDDLE / (1 + 0.6**2 + 0.1**2) ** 1.5)

    def test_edits_change_the_scene(self):
        scene = regulus.load(SCENE, edits=["lights.0.intensity=3"])
        self.assertEqual(len(scene.edits), 1)
        bright = regulus.render(scene, device=self.device, **SMALL).rgb[4, 4, 0]
        np.testing.assert_allclose(bright, 3 * regulus.render(self.scene, device=self.device, **SMALL).rgb[4, 4, 0],
                                   rtol=1e-5)
        with self.assertRaisesRegex(regulus.Error, "did you mean intensity?"):
            regulus.load(SCENE, edits=["lights.0.intensty=3"])

    def test_aovs_are_arrays(self):
        picture = regulus.render(self.scene, device=self.device, aov=["albedo", "Z", "material"], **SMALL)
        self.assertEqual(picture["albedo"].shape, (9, 9, 3))
        np.testing.assert_allclose(picture["albedo"][4, 4], 0.5, rtol=1e-6)
        np.testing.assert_allclose(picture["Z"][4, 4], 2, rtol=1e-6)
        self.assertEqual(picture["material"].dtype, np.uint32)
        with self.assertRaises(KeyError):
            picture["N"]

    def test_errors_have_the_text_of_the_command_line_and_a_code(self):
        with self.assertRaisesRegex(regulus.Error, "none.gltf") as caught:
            regulus.load("none.gltf")
        self.assertEqual(caught.exception.code, "BAD_FILE")
        with self.assertRaisesRegex(regulus.Error, "did you mean max-depth?") as caught:
            regulus.render(self.scene, max_deph=3)
        self.assertEqual(caught.exception.code, "BAD_USAGE")
        with self.assertRaisesRegex(regulus.Error, "^camera 7: .*square.gltf has 0"):
            regulus.render(self.scene, camera=7)
        with self.assertRaises(TypeError):
            regulus.load(SCENE, no_such_option=1)

    def test_progress_stops_and_its_errors_arrive(self):
        plan = regulus.make_plan(self.scene, size=(9, 9), spp=64, wave=81)
        renderer = regulus.Renderer(plan, self.device)
        self.assertFalse(renderer.render(lambda done, total: False).is_complete)
        self.assertTrue(renderer.render().is_complete)
        self.assertEqual(renderer.statistics()["spp_done"], 64)

        def fail(done, total):
            raise ZeroDivisionError("of the caller")

        with self.assertRaisesRegex(ZeroDivisionError, "of the caller"):
            regulus.Renderer(plan, self.device).render(fail)

    def test_interrupt_raises_and_keeps_what_is_done(self):
        plan = regulus.make_plan(self.scene, size=(64, 64), spp=1 << 24, wave=4096)
        renderer = regulus.Renderer(plan, self.device)
        begun = threading.Event()

        def interrupt():
            begun.wait(60)
            os.kill(os.getpid(), signal.SIGINT)

        thread = threading.Thread(target=interrupt)
        thread.start()
        start = time.monotonic()
        with self.assertRaises(KeyboardInterrupt):
            renderer.render(lambda done, total: begun.set())
        thread.join()
        self.assertLess(time.monotonic() - start, 60)
        self.assertGreater(renderer.picture().rgb.max(), 0)

    def test_pictures_are_written_read_and_compared(self):
        picture = regulus.Picture(np.full((3, 4, 3), 0.25))
        with tempfile.TemporaryDirectory() as folder:
            picture.write(f"{folder}/a.exr")
            read = regulus.read_picture(f"{folder}/a.exr")
        np.testing.assert_array_equal(read.rgb, picture.rgb)
        self.assertEqual(read.compare(picture).mse, 0)
        self.assertAlmostEqual(regulus.Picture(np.full((3, 4, 3), 0.5)).compare(picture).mse, 0.0625)

    def test_checks_and_paths(self):
        self.assertTrue(all(line.is_passed for line in regulus.check(self.scene, device=self.device, **SMALL)))
        path = regulus.trace_path(self.scene, 4, 4, device=self.device, **SMALL)
        vertices = path["vertices"]
        self.assertTrue(vertices["is_on_device"][0])
        np.testing.assert_allclose(vertices["position"][0], vertices["device_position"][0], atol=1e-5)
        np.testing.assert_allclose(path["radiance"], path["device_radiance"], atol=1e-5)
        r_squared = (vertices["position"][0, :2] ** 2).sum()
        np.testing.assert_allclose(path["radiance"][0], MIDDLE / (1 + r_squared) ** 1.5, rtol=1e-5)
        for found in path["contributions"]:
            self.assertAlmostEqual(found["weights"].sum(), 1)

    def test_stubs_name_everything(self):
        with open(os.path.join(os.path.dirname(regulus.__file__), "__init__.pyi"), encoding="utf-8") as file:
            stubs = file.read()
        for name in regulus.__all__:
            self.assertRegex(stubs, rf"(def|class) {name}\b")


unittest.main()
