"""A glTF scene as plain arrays, as far as the peers' converters know it: triangles in world space, factors and base colour
textures of materials, area, point, spot and distant lights, and the first camera.

What they do not know is an error, so that no table compares different scenes without saying so.
"""
import base64
import json
import pathlib
import struct
from dataclasses import dataclass, field

import numpy as np

KNOWN_EXTENSIONS = {"KHR_materials_emissive_strength", "KHR_materials_ior", "KHR_materials_specular",
                    "KHR_materials_transmission", "KHR_materials_volume", "KHR_lights_punctual", "KHR_texture_transform"}
TYPES = {5120: np.int8, 5121: np.uint8, 5122: np.int16, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}


@dataclass
class Material:
    base_color: np.ndarray          # linear
    base_color_image: bytes | None  # PNG or JPEG
    metallic: float
    roughness: float                # perceptual; alpha is its square
    specular: float
    transmission: float
    is_solid: bool                  # has a volume
    ior: float
    attenuation: np.ndarray         # absorption, 1/m
    emission: np.ndarray            # W/(m^2 sr)
    is_double_sided: bool


@dataclass
class Mesh:
    positions: np.ndarray   # n x 3
    normals: np.ndarray | None
    uvs: np.ndarray | None
    triangles: np.ndarray   # m x 3
    material: int


@dataclass
class Light:
    kind: str               # point, spot, directional
    color: np.ndarray       # times intensity
    position: np.ndarray
    direction: np.ndarray   # in which it shines
    inner: float = 0.0      # radians
    outer: float = 0.0


@dataclass
class Scene:
    meshes: list = field(default_factory=list)
    materials: list = field(default_factory=list)
    lights: list = field(default_factory=list)
    camera_to_world: np.ndarray = None
    fov: float = 0.0        # radians, of a square film (fov_of_square)


def parsed(path):
    """A file's JSON, and what a .glb has behind it."""
    data = pathlib.Path(path).read_bytes()
    if data[:4] != b"glTF":
        return json.loads(data), b""
    length = struct.unpack_from("<I", data, 12)[0]
    return json.loads(data[20:20 + length]), data[28 + length:]


class Reader:
    def __init__(self, path):
        self.folder = pathlib.Path(path).parent
        self.root, self.chunk = parsed(path)
        unknown = set(self.root.get("extensionsUsed", [])) - KNOWN_EXTENSIONS
        if unknown:
            raise ValueError(f"{path}: the peers' converters do not know {', '.join(sorted(unknown))}")
        self.buffers = [self.bytes_of(buffer) for buffer in self.root.get("buffers", [])]

    def bytes_of(self, entry):
        uri = entry.get("uri")
        if uri is None:
            return self.chunk
        if uri.startswith("data:"):
            return base64.b64decode(uri.split(",", 1)[1])
        return (self.folder / uri).read_bytes()

    def view(self, index):
        view = self.root["bufferViews"][index]
        start = view.get("byteOffset", 0)
        return self.buffers[view["buffer"]][start:start + view["byteLength"]], view.get("byteStride", 0)

    def accessor(self, index):
        accessor = self.root["accessors"][index]
        data, stride = self.view(accessor["bufferView"])
        width, kind = WIDTHS[accessor["type"]], np.dtype(TYPES[accessor["componentType"]])
        stride = stride or width * kind.itemsize
        rows = np.ndarray((accessor["count"], width), kind, data, accessor.get("byteOffset", 0), (stride, kind.itemsize))
        if accessor.get("normalized"):
            return rows / np.iinfo(kind).max
        return rows.copy()

    def image_of(self, texture):
        if texture is None:
            return None
        image = self.root["images"][self.root["textures"][texture["index"]]["source"]]
        return self.bytes_of(image) if "uri" in image else bytes(self.view(image["bufferView"])[0])

    def material(self, entry):
        pbr, extensions = entry.get("pbrMetallicRoughness", {}), entry.get("extensions", {})
        volume = extensions.get("KHR_materials_volume", {})
        distance = volume.get("attenuationDistance", np.inf)
        color = np.maximum(np.array(volume.get("attenuationColor", [1, 1, 1]), float), 1e-6)
        strength = extensions.get("KHR_materials_emissive_strength", {}).get("emissiveStrength", 1.0)
        return Material(
            base_color=np.array(pbr.get("baseColorFactor", [1, 1, 1, 1])[:3], float),
            base_color_image=self.image_of(pbr.get("baseColorTexture")),
            metallic=pbr.get("metallicFactor", 1.0), roughness=pbr.get("roughnessFactor", 1.0),
            specular=extensions.get("KHR_materials_specular", {}).get("specularFactor", 1.0),
            transmission=extensions.get("KHR_materials_transmission", {}).get("transmissionFactor", 0.0),
            is_solid=volume.get("thicknessFactor", 0.0) > 0,
            ior=extensions.get("KHR_materials_ior", {}).get("ior", 1.5), attenuation=-np.log(color) / distance,
            emission=strength * np.array(entry.get("emissiveFactor", [0, 0, 0]), float),
            is_double_sided=entry.get("doubleSided", False))


def matrix_of(node):
    if "matrix" in node:
        return np.array(node["matrix"], float).reshape(4, 4).T
    x, y, z, w = node.get("rotation", [0, 0, 0, 1])
    rotation = np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                         [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                         [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])
    matrix = np.eye(4)
    matrix[:3, :3] = rotation * np.array(node.get("scale", [1, 1, 1]), float)
    matrix[:3, 3] = node.get("translation", [0, 0, 0])
    return matrix


def fov_of_square(perspective):
    """The angle in radians, up and across, at which a square film shows the whole frame: glTF 2.0, 3.10.3, lets none be cut."""
    return 2 * np.arctan(np.tan(perspective["yfov"] / 2) * max(perspective.get("aspectRatio", 1.0), 1.0))


def load(path):
    reader, scene = Reader(path), Scene()
    root = reader.root
    scene.materials = [reader.material(m) for m in root.get("materials", [])]
    lights = root.get("extensions", {}).get("KHR_lights_punctual", {}).get("lights", [])

    def add_mesh(primitive, matrix):
        if primitive.get("mode", 4) != 4:
            raise ValueError(f"{path}: only triangles are converted")
        if "material" not in primitive:
            raise ValueError(f"{path}: a primitive has no material")
        attributes = primitive["attributes"]
        positions = reader.accessor(attributes["POSITION"]).astype(float) @ matrix[:3, :3].T + matrix[:3, 3]
        normals = uvs = None
        if "NORMAL" in attributes:
            normals = reader.accessor(attributes["NORMAL"]).astype(float) @ np.linalg.inv(matrix[:3, :3])
            normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
        if "TEXCOORD_0" in attributes:
            uvs = reader.accessor(attributes["TEXCOORD_0"]).astype(float)
        count = len(positions)
        indices = reader.accessor(primitive["indices"]).reshape(-1) if "indices" in primitive else np.arange(count)
        triangles = indices.astype(np.int64).reshape(-1, 3)
        if np.linalg.det(matrix[:3, :3]) < 0:
            triangles = triangles[:, ::-1]
        scene.meshes.append(Mesh(positions, normals, uvs, triangles, primitive["material"]))

    def visit(index, parent):
        node = root["nodes"][index]
        matrix = parent @ matrix_of(node)
        if "mesh" in node:
            for primitive in root["meshes"][node["mesh"]]["primitives"]:
                add_mesh(primitive, matrix)
        if "camera" in node and scene.camera_to_world is None:
            scene.camera_to_world, scene.fov = matrix, fov_of_square(root["cameras"][node["camera"]]["perspective"])
        number = node.get("extensions", {}).get("KHR_lights_punctual", {}).get("light")
        if number is not None:
            light = lights[number]
            color = np.array(light.get("color", [1, 1, 1]), float) * light.get("intensity", 1.0)
            cone = light.get("spot", {})
            direction = -matrix[:3, 2] / np.linalg.norm(matrix[:3, 2])
            scene.lights.append(Light(light["type"], color, matrix[:3, 3], direction, cone.get("innerConeAngle", 0.0),
                                      cone.get("outerConeAngle", np.pi / 4)))
        for child in node.get("children", []):
            visit(child, matrix)

    for index in root["scenes"][root.get("scene", 0)]["nodes"]:
        visit(index, np.eye(4))
    return scene
