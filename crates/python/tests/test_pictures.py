"""Scenes of files, and pictures."""

from pathlib import Path

import numpy as np
import pytest
from conftest import gltf_of_two_balls, scene_of, sphere

import umbrage


def test_a_scene_moves_and_its_frames_are_meshes():
    cloth = umbrage.open("demo:cloth?triangles=2000")
    assert cloth.duration > 0 and cloth.warnings == []
    one, other = cloth.at(0.2), cloth.at(0.9)
    assert one.vertices.dtype == np.float32 and one.triangles.dtype == np.uint32
    assert one.vertices.shape == other.vertices.shape and (one.vertices != other.vertices).any()
    assert one.triangles is other.triangles and not one.triangles.flags.writeable
    assert one.triangles.max() < len(one.vertices) and one.seconds == 0.2
    np.testing.assert_array_equal(cloth.at(0.2 + cloth.duration).vertices.shape, one.vertices.shape)
    scene = scene_of(one.vertices, one.triangles)
    name, camera = one.cameras[0]
    assert isinstance(name, str) and one.lights
    assert np.isfinite(scene.see(camera, 32, 18)["t_hit"]).mean() > 0.3


def test_a_file_is_read(tmp_path):
    vertices, triangles = sphere()
    path = tmp_path / "ball.obj"
    lines = [f"v {x} {y} {z}" for x, y, z in vertices.tolist()]
    path.write_text("\n".join([*lines, *(f"f {a + 1} {b + 1} {c + 1}" for a, b, c in triangles.tolist())]))
    frame = umbrage.open(path).at(0)
    assert len(frame.triangles) == len(triangles)
    np.testing.assert_array_equal(np.sort(frame.vertices[frame.triangles], axis=None), np.sort(vertices[triangles], axis=None))
    with pytest.raises(ValueError, match="broken.obj"):
        (tmp_path / "broken.obj").write_text("f 1 2 3\n")
        umbrage.open(tmp_path / "broken.obj")


def test_instances_move_by_their_transforms(tmp_path):
    path = tmp_path / "balls.gltf"
    path.write_text(gltf_of_two_balls())
    file = umbrage.open(path)
    scene = umbrage.RaycastingScene()
    first = file.instances(0)
    assert [part.name for part in first] == ["stays", "rises"]
    for part in first:
        assert part.vertices.dtype == np.float32 and part.triangles.dtype == np.uint32
        scene.add_triangles(part.vertices, part.triangles)
    for seconds in (0, 0.25, 1):
        parts = file.instances(seconds)
        np.testing.assert_array_equal(parts[1].world_from_object[:3, 3], [5, seconds, 0])
        np.testing.assert_array_equal(parts[0].world_from_object, np.diag([2, 1, 1, 1]))
        for id, part in enumerate(parts):
            np.testing.assert_array_equal(part.vertices, first[id].vertices)
            scene.set_transform(id, part.world_from_object)
        whole = file.at(seconds)
        corners = np.concatenate([(part.vertices @ part.world_from_object[:3, :3].T + part.world_from_object[:3, 3])[part.triangles] for part in parts])
        np.testing.assert_allclose(whole.vertices[whole.triangles], corners, rtol=0, atol=1e-6)
        rays = np.float32([[0.1, 9, 0.2, 0, -1, 0], [5.1, 9, 0.2, 0, -1, 0]])
        hits = scene.cast_rays(rays)
        np.testing.assert_array_equal(hits["geometry_ids"], [0, 1])
        places = scene.object_positions(hits["geometry_ids"], hits["primitive_ids"], hits["primitive_uvs"])
        np.testing.assert_allclose(places[:, [0, 2]], [[0.05, 0.2], [0.1, 0.2]], atol=1e-6)
        np.testing.assert_allclose(9 - hits["t_hit"] - places[:, 1], [0, seconds], atol=1e-6)


VASE = Path(__file__).parents[2] / "verify" / "corpus" / "glb" / "variants.glb"


def test_variants_are_chosen_by_name():
    scene = umbrage.open(VASE)
    assert len(scene.variants) > 1
    pictures = [umbrage.open(VASE, variant=variant).render(0, 64, 36) for variant in [None, *scene.variants]]
    assert any((one != pictures[0]).any() for one in pictures)
    with pytest.raises(ValueError, match=scene.variants[0]):
        umbrage.open(VASE, variant="none of them")


def test_objects_are_hidden_by_name():
    scene = umbrage.open("demo:cloth?triangles=2000")
    assert scene.objects == ["silk", "ball", "floor"]
    without = umbrage.open("demo:cloth?triangles=2000", hide=["si*", "floor"])
    assert without.objects == scene.objects
    assert [part.name for part in without.instances(0.5)] == ["ball"]
    assert len(without.at(0.5).triangles) < len(scene.at(0.5).triangles)
    with pytest.raises(ValueError, match="`silk`, `ball`, `floor`"):
        umbrage.open("demo:cloth?triangles=2000", hide=["cotton"])


def test_a_background_of_one_colour_is_shown_as_it_is():
    picture = umbrage.open(VASE).render(0, 64, 36, background="#336699")
    np.testing.assert_array_equal(picture[0, 0], [0x33, 0x66, 0x99])


def test_pictures_show_what_they_are_of():
    cloth = umbrage.open("demo:cloth?triangles=2000")
    picture = cloth.render(0.5, 64, 36)
    assert picture.shape == (36, 64, 3) and picture.dtype == np.uint8
    assert len(np.unique(picture.reshape(-1, 3), axis=0)) > 100
    np.testing.assert_array_equal(cloth.render(0.5, 64, 36), picture)
    for changed in (
        cloth.render(0.9, 64, 36),
        cloth.render(0.5, 64, 36, samples=4),
        cloth.render(0.5, 64, 36, lights=["sun:-1,-2,-1:3"]),
        cloth.render(0.5, 64, 36, lights=umbrage.Light.sun([-1, -1, 0])),
        cloth.render(0.5, 64, 36, camera="0,1,5:0,0,0:40"),
        cloth.render(0.5, 64, 36, camera=umbrage.Camera([0, 3, 9], [0, 0, 0])),
        cloth.render(0.5, 64, 36, exposure=1),
    ):
        assert (changed != picture).mean() > 0.02
    assert cloth.render(0.5, 64, 36, camera=0).shape == picture.shape


def test_notebooks_show_pictures(tmp_path):
    scene = scene_of(*sphere())
    camera = umbrage.Camera([0, 0, 4], [0, 0, 0])
    for background in ("sky", "none"):
        picture = scene.render(camera, 40, 30, lights="sun:0,-1,-1", background=background)
        assert isinstance(picture, umbrage.Picture)
        # The library reads it back: as a background of one's own.
        (tmp_path / "shown.png").write_bytes(picture._repr_png_())
        read = pytest.importorskip("matplotlib.image").imread(tmp_path / "shown.png")
        np.testing.assert_array_equal(np.round(255 * read), picture)
    part = picture[5:20, ::2, :3]
    assert part._repr_png_().startswith(b"\x89PNG")
    for numbers in (picture[..., 3], picture[:0], picture.astype(np.float32)):
        assert numbers._repr_png_() is None
    assert type(picture / 2) is type(picture.mean(axis=0)) is type(picture == picture) is np.ndarray
    assert isinstance(picture.max(), np.uint8) and isinstance(picture.mean(), np.float64)


def test_objects_say_what_they_are(tmp_path):
    cloth = umbrage.open("demo:cloth?triangles=2000")
    frame = cloth.at(0.5)
    vertices, triangles = frame.vertices.shape[0], frame.triangles.shape[0]
    assert repr(cloth).startswith('<umbrage.Scene "demo:cloth?triangles=2000": 3 objects, ')
    assert f"{round(cloth.duration, 3):g} s of animation" in repr(cloth)
    assert repr(frame).startswith(f"<umbrage.Frame at 0.5 s: {vertices} vertices, {triangles} triangles, ")
    part = cloth.instances(0.5)[2]
    assert repr(part) == f'<umbrage.Instance "floor": {len(part.vertices)} vertices, {len(part.triangles)} triangles>'
    assert repr(umbrage.RaycastingScene(nthreads=2)) == "<umbrage.RaycastingScene: 0 geometries, 0 triangles, nthreads=2>"
    assert repr(umbrage.Light.sun([0, -2, 0])) == "Light(sun:0,-1,0)"
    camera = umbrage.Camera([1, 2, 3], [1, 2, -7], fov_degrees=33)
    assert repr(camera) == "Camera([1.0, 2.0, 3.0], [1.0, 2.0, 2.0], [0.0, 1.0, 0.0], fov_degrees=33)"
    again = eval(f"umbrage.{camera!r}")
    np.testing.assert_allclose(again.rays(8, 6), camera.rays(8, 6), atol=1e-5)
    own = umbrage.Camera.from_intrinsics([[90, 0, 40], [0, 80, 30], [0, 0, 1]], width=80, height=60)
    assert "80×60 pixels, fx=90, fy=80, cx=40, cy=30" in repr(own)


def test_exposure_is_measured():
    scene = scene_of(*sphere())
    camera = umbrage.Camera([0, 0, 4], [0, 0, 0])
    keywords = {"lights": "sun:0,-1,-1:0.5", "background": "#000000"}
    dark, measured = (scene.render(camera, 60, 40, exposure=exposure, **keywords) for exposure in (None, "auto"))
    np.testing.assert_array_equal(scene.render(camera, 60, 40, exposure=0, **keywords), dark)
    assert dark.max() < 130 and 180 < measured.max() < 255
    # Sixteen times the light is as bright in the end.
    keywords["lights"] = "sun:0,-1,-1:8"
    brighter = scene.render(camera, 60, 40, exposure="auto", **keywords)
    assert np.abs(brighter.astype(int) - measured).max() <= 2
    cloth = umbrage.open("demo:cloth?triangles=2000")
    assert (cloth.render(0.5, 64, 36, exposure="auto") != cloth.render(0.5, 64, 36)).any()
    for bad in ("automatic", [1, 2]):
        with pytest.raises(ValueError, match="exposure: expected a number or 'auto'"):
            scene.render(camera, 8, 8, exposure=bad)


def test_alpha_is_where_something_is_seen():
    scene = scene_of(*sphere())
    camera = umbrage.Camera([0, 0, 4], [0, 0, 0])
    picture = scene.render(camera, 60, 40, lights=umbrage.Light.sun([0, -1, -1]), background="none")
    assert picture.shape == (40, 60, 4)
    hit = np.isfinite(scene.see(camera, 60, 40)["t_hit"])
    np.testing.assert_array_equal(picture[..., 3] == 255, hit)
    np.testing.assert_array_equal(picture[..., 3] == 0, ~hit)
    # Its upper half is lit from above.
    assert picture[12, 30, :3].mean() > picture[28, 30, :3].mean() + 30


def test_cameras_say_where_their_rays_go():
    camera = umbrage.Camera([1, 2, 3], [1, 2, -7], fov_degrees=90)
    assert camera.position == [1, 2, 3] and camera.forward == [0, 0, -1]
    rays = camera.rays(2, 2)
    assert rays.shape == (2, 2, 6) and rays.dtype == np.float64
    np.testing.assert_allclose(rays[0, 0], [1, 2, 3, -0.5, 0.5, -1], atol=1e-7)
    np.testing.assert_allclose(rays[1, 1, 3:], [0.5, -0.5, -1], atol=1e-7)
    assert "fov_degrees=90" in repr(camera)
