"""Mitsuba's side: the same triangles and numbers, for its path tracer."""

import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")

import metal  # noqa: E402  (its class needs the variant)

metal.register()


def rgb(color):
    return {"type": "rgb", "value": [float(channel) for channel in color]}


def surface(material):
    """What a mesh of this material has beside its triangles."""
    match material.kind:
        case "glow":
            dark = {"type": "diffuse", "reflectance": rgb((0, 0, 0))}
            return {"bsdf": dark, "emitter": {"type": "area", "radiance": rgb(material.color)}}
        case "diffuse":
            return {"bsdf": {"type": "diffuse", "reflectance": rgb(material.color)}}
        case "metal":
            # Perceptual roughness squared; without a material Fresnel's term is 1, as Schlick's is for white metal.
            alpha = material.roughness**2
            if material.is_mended:
                return {"bsdf": {"type": "white_metal", "alpha": alpha}}
            conductor = {"type": "roughconductor", "material": "none", "distribution": "ggx", "alpha": alpha}
            return {"bsdf": conductor | {"specular_reflectance": rgb(material.color)}}
        case "glass":
            dielectric = {"type": "dielectric", "int_ior": material.ior, "ext_ior": 1.0}
            absorbed = [-float(np.log(left)) for left in material.left_after_one]
            if not any(absorbed):
                return {"bsdf": dielectric}
            # Colours are at most 1.
            scale = max(absorbed)
            sigma_t = rgb([channel / scale for channel in absorbed])
            medium = {"type": "homogeneous", "albedo": 0.0, "sigma_t": sigma_t, "scale": scale}
            return {"bsdf": dielectric, "interior": medium}
    raise ValueError(material.kind)


def mesh(shape, seconds, folder, name):
    """A shape where it is so long after the moment."""
    path = folder / f"{name}.ply"
    positions = shape.positions + seconds * np.array(shape.velocity)
    properties = {"type": "ply", "filename": str(path), **surface(shape.material)}
    plain = mi.Mesh(name, len(positions), len(shape.triangles), has_vertex_normals=True)
    arrays = mi.traverse(plain)
    arrays["vertex_positions"] = positions.astype(np.float32).reshape(-1)
    arrays["vertex_normals"] = shape.normals.astype(np.float32).reshape(-1)
    arrays["faces"] = shape.triangles.astype(np.uint32).reshape(-1)
    arrays.update()
    plain.write_ply(str(path))
    return properties


def lamp(light):
    """A point, or a sphere or a rectangle whose surface sends the same candela."""
    if light.target:
        width, height = light.size
        to_world = mi.ScalarTransform4f().look_at(origin=light.position, target=light.target, up=[0, 1, 0])
        to_world = to_world @ mi.ScalarTransform4f().scale([0.5 * width, 0.5 * height, 1])
        emitter = {"type": "area", "radiance": rgb([light.candela / (width * height)] * 3)}
        return {"type": "rectangle", "to_world": to_world, "emitter": emitter}
    if not light.radius:
        return {"type": "point", "position": list(light.position), "intensity": rgb([light.candela] * 3)}
    radiance = light.candela / (np.pi * light.radius**2)
    emitter = {"type": "area", "radiance": rgb([radiance] * 3)}
    return {"type": "sphere", "center": list(light.position), "radius": light.radius, "emitter": emitter}


def sensor(case, size, samples):
    camera = case.camera
    to_world = mi.ScalarTransform4f().look_at(origin=camera.eye, target=camera.target, up=[0, 1, 0])
    film = {"type": "hdrfilm", "width": size[0], "height": size[1], "rfilter": {"type": "box"}}
    found = {
        "type": "thinlens" if camera.aperture else "perspective",
        "fov": camera.fov_degrees,
        "fov_axis": "y",
        "near_clip": 0.01,
        "far_clip": 1000.0,
        "to_world": to_world,
        "film": film,
        "sampler": {"type": "independent", "sample_count": samples},
    }
    if camera.aperture:
        found |= {"aperture_radius": camera.aperture / 2, "focus_distance": camera.focus}
    return found


def scene(case, size, samples, seconds, folder):
    media = any(min(shape.material.left_after_one) < 1 for shape in case.shapes)
    # What a camera sees is at depth 1, what a lamp lights there at 2; mirrors and glass come in between.
    lit = 1 if case.lamps else 0
    integrator = {"type": "volpathmis" if media else "path", "max_depth": 1 + case.depth + lit, "rr_depth": 1000}
    found = {"type": "scene", "integrator": integrator, "sensor": sensor(case, size, samples)}
    if any(case.background):
        found["around"] = {"type": "constant", "radiance": rgb(case.background)}
    for number, light in enumerate(case.lamps):
        found[f"lamp{number}"] = lamp(light)
    for number, shape in enumerate(case.shapes):
        found[f"shape{number}"] = mesh(shape, seconds, folder, f"{case.name}{number}")
    return mi.load_dict(found)


def render(case, size, samples, folder, seed):
    """Linear radiance. While a shutter is open, the mean of pictures at moments evenly apart: its definition."""
    moments = min(case.samples, samples) if case.shutter_seconds else 1
    total = 0.0
    for number in range(moments):
        seconds = case.shutter_seconds * ((number + 0.5) / moments - 0.5)
        each = max(samples // moments, 1)
        posed = scene(case, size, each, seconds, folder)
        total = total + np.array(mi.render(posed, spp=each, seed=seed * moments + number))[..., :3]
    return total / moments


def read(path):
    """Red, green and blue of an EXR file with other channels beside them."""
    bitmap = mi.Bitmap(str(path))
    names = [channel.name.removeprefix("rgba.") for channel in bitmap.struct_()]
    pixels = np.array(bitmap)
    return np.stack([pixels[..., names.index(name)] for name in "RGB"], -1).astype(np.float64)
