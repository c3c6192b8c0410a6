"""A glTF 2.0 document under construction, and its two encodings: .gltf with .bin, and .glb. Output depends
on the calls alone, byte for byte."""
import array
import json
import struct
import sys

from .vec import length, look_at

FLOAT, UINT16, UINT32 = 5126, 5123, 5125
ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER = 34962, 34963


def _bytes(type_code, values):
    data = array.array(type_code, values)
    if sys.byteorder == "big":
        data.byteswap()
    return data


class Gltf:
    """Collects materials, meshes, nodes, cameras and lights; all methods that add return an index."""

    def __init__(self, title, resolution, settings=None, expected=None):
        """settings: options of `regulus render` for the intended picture. expected: known values that tests
        compare with, written to scenes[0].extras.regulus_expected."""
        extras = {"regulus": settings or {}}
        if expected:
            extras["regulus_expected"] = expected
        self._data = bytearray()
        self._json = {
            "asset": {"version": "2.0", "generator": "Regulus scenes/generate.py",
                      "extras": {"title": title, "resolution": list(resolution)}},
            "scene": 0,
            "scenes": [{"nodes": [], "extras": extras}],
            "nodes": [], "cameras": [], "materials": [], "meshes": [], "accessors": [], "bufferViews": [],
        }
        self._used_extensions = set()

    # Materials.

    def material(self, name, base_color=(1, 1, 1), metallic=0.0, roughness=1.0, emission=None, extensions=None):
        """emission: radiance (r, g, b), split into a factor of at most 1 and a strength."""
        extensions = dict(extensions or {})
        material = {"name": name,
                    "pbrMetallicRoughness": {"baseColorFactor": [*base_color, 1], "metallicFactor": metallic,
                                             "roughnessFactor": roughness}}
        if emission:
            strength = max(*emission, 1.0)
            material["emissiveFactor"] = [value / strength for value in emission]
            if strength > 1.0:
                extensions["KHR_materials_emissive_strength"] = {"emissiveStrength": strength}
        if extensions:
            material["extensions"] = extensions
            self._used_extensions.update(extensions)
        return self._append("materials", material)

    def diffuse(self, name, albedo, emission=None):
        """Lambert alone: a specular factor of 0 removes the dielectric coat."""
        return self.material(name, albedo, emission=emission,
                             extensions={"KHR_materials_specular": {"specularFactor": 0}})

    def light_material(self, name, emission):
        """Emits from the front face, reflects nothing."""
        return self.diffuse(name, (0, 0, 0), emission)

    def metal(self, name, reflectance, roughness):
        """roughness is perceptual (alpha = roughness^2); 0 is a perfect mirror."""
        return self.material(name, reflectance, metallic=1.0, roughness=roughness)

    def glass(self, name, ior, roughness=0.0, attenuation=None):
        """Solid glass: a refracting boundary, perfectly smooth with roughness 0. attenuation: (what is left of white,
        after how many metres)."""
        volume = {"thicknessFactor": 1}
        if attenuation:
            volume.update({"attenuationColor": list(attenuation[0]), "attenuationDistance": attenuation[1]})
        return self.material(name, roughness=roughness, extensions={
            "KHR_materials_transmission": {"transmissionFactor": 1},
            "KHR_materials_volume": volume,
            "KHR_materials_ior": {"ior": ior}})

    def amend(self, material, pbr=None, **members):
        """Adds members to a material, and to its pbrMetallicRoughness."""
        self._json["materials"][material].update(members)
        self._json["materials"][material]["pbrMetallicRoughness"].update(pbr or {})

    def repeated(self, texture, across, down):
        """Use of a texture that repeats it so often over the unit square."""
        self._used_extensions.add("KHR_texture_transform")
        return {"index": texture, "extensions": {"KHR_texture_transform": {"scale": [across, down]}}}

    def texture(self, png):
        """A texture of the bytes of a PNG; repeats, is filtered."""
        self._data.extend(bytes(-len(self._data) % 4))
        view = self._append("bufferViews", {"buffer": 0, "byteOffset": len(self._data), "byteLength": len(png)})
        self._data.extend(png)
        images = self._json.setdefault("images", [])
        images.append({"bufferView": view, "mimeType": "image/png"})
        textures = self._json.setdefault("textures", [])
        textures.append({"source": len(images) - 1})
        return len(textures) - 1

    # Geometry.

    def geometry(self, mesh, uvs=None):
        """Accessors of a mesh as a primitive without material; give it to several meshes to share data. uvs: texture
        coordinates, (0, 0) at the upper left corner of the image."""
        attributes = {"POSITION": self._accessor(mesh.positions, with_bounds=True)}
        if mesh.normals:
            attributes["NORMAL"] = self._accessor(mesh.normals)
        if uvs:
            attributes["TEXCOORD_0"] = self._accessor(uvs)
        return {"attributes": attributes, "indices": self._indices(mesh)}

    def colors(self, values):
        """Accessor of linear RGB per vertex."""
        return self._accessor(values)

    def add_mesh(self, name, geometry, material, translation=None, scale=None, matrix=None):
        """A node with a mesh of one primitive."""
        self._append("meshes", {"name": name, "primitives": [{**geometry, "material": material}]})
        node = {"name": name, "mesh": len(self._json["meshes"]) - 1}
        if translation:
            node["translation"] = list(translation)
        if scale:
            node["scale"] = [scale] * 3
        if matrix:
            node["matrix"] = list(matrix)
        return self._root(node)

    def add_surface(self, name, mesh, material):
        """A node with a mesh that nothing else shares."""
        return self.add_mesh(name, self.geometry(mesh), material)

    def _accessor(self, vectors, with_bounds=False):
        data = _bytes("f", (x for v in vectors for x in v))
        accessor = {"bufferView": self._view(data, ARRAY_BUFFER), "componentType": FLOAT,
                    "count": len(vectors), "type": f"VEC{len(vectors[0])}"}
        if with_bounds:
            accessor["min"] = [min(data[i::3]) for i in range(3)]
            accessor["max"] = [max(data[i::3]) for i in range(3)]
        return self._append("accessors", accessor)

    def _indices(self, mesh):
        is_small = len(mesh.positions) < 65535
        data = _bytes("H" if is_small else "I", (i for t in mesh.triangles for i in t))
        return self._append("accessors", {
            "bufferView": self._view(data, ELEMENT_ARRAY_BUFFER),
            "componentType": UINT16 if is_small else UINT32, "count": len(data), "type": "SCALAR"})

    def _view(self, data, target):
        self._data.extend(bytes(-len(self._data) % 4))  # accessors start at multiples of their component
        view = {"buffer": 0, "byteOffset": len(self._data), "byteLength": len(data) * data.itemsize,
                "target": target}
        self._data.extend(data.tobytes())
        return self._append("bufferViews", view)

    # Cameras and lights.

    def perspective_camera(self, matrix, y_fov, aspect_ratio=1.0):
        self._append("cameras", {"type": "perspective", "perspective": {
            "yfov": y_fov, "aspectRatio": aspect_ratio, "znear": 0.001}})
        return self._root({"name": "camera", "camera": 0, "matrix": matrix})

    def orthographic_camera(self, matrix, half_width, half_height):
        self._append("cameras", {"type": "orthographic", "orthographic": {
            "xmag": half_width, "ymag": half_height, "znear": 0.0, "zfar": 100.0}})
        return self._root({"name": "camera", "camera": 0, "matrix": matrix})

    def point_light(self, position, intensity):
        """intensity in candela; the renderer takes it as W/sr per channel."""
        light = self._light({"type": "point", "intensity": intensity})
        return self._root({"name": "light", "translation": list(position), "extensions": light})

    def directional_light(self, direction, illuminance, color):
        """Light that travels in `direction`; illuminance in lux, taken as W/m^2 per channel."""
        light = self._light({"type": "directional", "intensity": illuminance, "color": list(color)})
        up = (0.0, 1.0, 0.0) if abs(direction[1]) < 0.9 * length(direction) else (1.0, 0.0, 0.0)
        return self._root({"name": "light", "matrix": look_at((0.0, 0.0, 0.0), direction, up), "extensions": light})

    def environment(self, radiance):
        """The same radiance from all directions; an extra of ours."""
        self._json["scenes"][0]["extras"]["regulus"]["environment"] = {"color": list(radiance)}

    def _light(self, light):
        """Adds a light; returns the extension of a node that refers to it."""
        self._used_extensions.add("KHR_lights_punctual")
        lights = self._json.setdefault("extensions", {}).setdefault("KHR_lights_punctual", {"lights": []})["lights"]
        lights.append(light)
        return {"KHR_lights_punctual": {"light": len(lights) - 1}}

    # Output.

    def write(self, path):
        """path.gltf and path.bin."""
        path.parent.mkdir(parents=True, exist_ok=True)
        document = self._document()
        document["buffers"][0]["uri"] = path.name + ".bin"
        path.with_name(path.name + ".gltf").write_text(json.dumps(document, indent=1) + "\n")
        path.with_name(path.name + ".bin").write_bytes(self._data)

    def write_glb(self, path):
        text = json.dumps(self._document(), separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        data = bytes(self._data) + bytes(-len(self._data) % 4)
        with open(path, "wb") as file:
            file.write(struct.pack("<4sII", b"glTF", 2, 12 + 8 + len(text) + 8 + len(data)))
            file.write(struct.pack("<I4s", len(text), b"JSON") + text)
            file.write(struct.pack("<I4s", len(data), b"BIN\0") + data)

    def _document(self):
        document = {"asset": self._json["asset"]}
        if self._used_extensions:
            document["extensionsUsed"] = sorted(self._used_extensions)
        document.update((key, value) for key, value in self._json.items() if value != [])
        document["buffers"] = [{"byteLength": len(self._data)}]
        return document

    def _append(self, collection, item):
        self._json[collection].append(item)
        return len(self._json[collection]) - 1

    def _root(self, node):
        index = self._append("nodes", node)
        self._json["scenes"][0]["nodes"].append(index)
        return index
