"""Umbrage's side: a glTF file and a command."""

import json
import subprocess

import numpy as np

from scenes import DURATION, MOMENT

FLOAT, UNSIGNED = 5126, 5125


class Gltf:
    """A file with its buffer beside it."""

    def __init__(self):
        self.blob = b""
        self.root = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}], "extensionsUsed": []}
        for name in ("nodes", "meshes", "materials", "accessors", "bufferViews"):
            self.root[name] = []

    def add(self, name, value):
        self.root[name].append(value)
        return len(self.root[name]) - 1

    def accessor(self, array, kind):
        """An array of f32 or u32 in the buffer."""
        array = np.asarray(array)
        array = array.astype("<u4" if array.dtype.kind in "iu" else "<f4")
        view = self.add("bufferViews", {"buffer": 0, "byteOffset": len(self.blob), "byteLength": array.nbytes})
        self.blob += array.tobytes()
        component, flat = (UNSIGNED if array.dtype.kind == "u" else FLOAT), array.reshape(len(array), -1)
        described = {"bufferView": view, "componentType": component, "count": array.size, "type": kind}
        if kind != "SCALAR" or component == FLOAT:
            described |= {"count": len(array), "min": flat.min(0).tolist(), "max": flat.max(0).tolist()}
        return self.add("accessors", described)

    def shape(self, shape):
        attributes = {
            "POSITION": self.accessor(shape.positions, "VEC3"),
            "NORMAL": self.accessor(shape.normals, "VEC3"),
        }
        indices = self.accessor(shape.triangles.reshape(-1), "SCALAR")
        material = self.add("materials", self.material(shape.material))
        primitive = {"attributes": attributes, "indices": indices, "material": material}
        mesh = self.add("meshes", {"primitives": [primitive]})
        node = self.add("nodes", {"mesh": mesh})
        self.root["scenes"][0]["nodes"].append(node)
        if any(shape.velocity):
            self.move(node, np.array(shape.velocity))

    def material(self, material):
        """A glTF material without anything that the other program's one lacks."""
        extensions = self.extensions(material)
        self.root["extensionsUsed"] = sorted({*self.root["extensionsUsed"], *extensions})
        surface = {
            "baseColorFactor": [*material.color, 1.0],
            "metallicFactor": float(material.kind == "metal"),
            "roughnessFactor": 1.0 if material.kind == "diffuse" else material.roughness,
        }
        return {"pbrMetallicRoughness": surface, "extensions": extensions}

    @staticmethod
    def extensions(material):
        match material.kind:
            case "glow":
                return {"KHR_materials_unlit": {}}
            case "diffuse":
                return {"KHR_materials_specular": {"specularFactor": 0.0}}
            case "glass":
                left = {"attenuationColor": material.left_after_one, "attenuationDistance": 1.0}
                return {
                    "KHR_materials_transmission": {"transmissionFactor": 1.0},
                    "KHR_materials_ior": {"ior": material.ior},
                    "KHR_materials_volume": {"thicknessFactor": 1.0, **left},
                }
        return {}

    def move(self, node, velocity):
        """Moves a node so that it is in its place at the moment."""
        times = self.accessor(np.array([0.0, DURATION]), "SCALAR")
        places = self.accessor(np.array([-MOMENT * velocity, (DURATION - MOMENT) * velocity]), "VEC3")
        animation = self.root.setdefault("animations", [{"samplers": [], "channels": []}])[0]
        animation["samplers"].append({"input": times, "output": places})
        target = {"node": node, "path": "translation"}
        animation["channels"].append({"sampler": len(animation["samplers"]) - 1, "target": target})

    def write(self, path):
        buffer = path.with_suffix(".bin")
        buffer.write_bytes(self.blob)
        self.root["buffers"] = [{"uri": buffer.name, "byteLength": len(self.blob)}]
        path.write_text(json.dumps(self.root))


def words(vector):
    return ",".join(str(float(number)) for number in vector)


def flags(case):
    """Those of `umbrage render` for a case."""
    camera = case.camera
    found = ["--camera", f"{words(camera.eye)}:{words(camera.target)}:{camera.fov_degrees}"]
    for lamp in case.lamps:
        if lamp.target:
            width, height = lamp.size
            aim = f"{words(lamp.position)}:{words(lamp.target)}"
            found += ["--light", f"rect:{aim}:{width}x{height}:{lamp.candela}"]
            continue
        radius = f":radius={lamp.radius}" if lamp.radius else ""
        found += ["--light", f"point:{words(lamp.position)}:{lamp.candela}{radius}"]
    if not case.lamps:
        # The command's own light would come in place of none.
        found += ["--light", "sun:0,-1,0:0"]
    found += ["--background", words(case.background)]
    if camera.aperture:
        found += ["--aperture", str(camera.aperture), "--focus", str(camera.focus)]
    if case.depth:
        found += ["--bounces", str(case.depth), "--least-contribution", "0"]
    if case.gloss:
        found += ["--gloss"]
    if case.shutter_seconds:
        found += ["--time", str(MOMENT), "--shutter", str(case.shutter_seconds)]
    return found


def render(case, size, umbrage, folder):
    """The file that the command writes."""
    gltf = Gltf()
    for shape in case.shapes:
        gltf.shape(shape)
    scene, picture = folder / f"{case.name}.gltf", folder / f"{case.name}.exr"
    gltf.write(scene)
    command = [umbrage, "render", scene, "--size", "{}x{}".format(*size), "--samples", str(case.samples)]
    command += [*flags(case), "--bit-depth", "32", "-q", "-o", picture]
    subprocess.run([str(word) for word in command], check=True)
    return picture
