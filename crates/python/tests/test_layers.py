"""Layers of EXR files, read by OpenEXR's own library."""

import json
import shutil
import struct
import subprocess

import numpy as np
import pytest

OpenEXR = pytest.importorskip("OpenEXR", minversion="3.3", reason="OpenEXR isn't installed")

pytestmark = pytest.mark.skipif(shutil.which("umbrage") is None, reason="there is no command `umbrage`")

SCENE, SIZE = "demo:marbles?triangles=3000", (48, 32)
NONE = 2**32 - 1
ALWAYS = {"R", "G", "B", "A", "Z", "depth.Z", "normal.X", "normal.Y", "normal.Z", "id"}
LAYERS = {
    "shadow": {"shadow.key", "shadow.fill"},
    "motion": {"motion.X", "motion.Y"},
    "barycentric": {"barycentric.u", "barycentric.v"},
    "ids": {"ids.object", "ids.triangle"},
    "cryptomatte": {f"CryptoObject0{layer}.{channel}" for layer in range(3) for channel in "RGBA"},
}


def render(path, *more):
    """The header and the channels of a picture."""
    width, height = SIZE
    line = ["umbrage", "render", SCENE, "--size", f"{width}x{height}", "-o", str(path), "--quiet", *more]
    subprocess.run(line, check=True)
    written = path.parent / (path.name % 12) if "%" in path.name else path
    with OpenEXR.File(str(written), separate_channels=True) as file:
        (part,) = file.parts
        return dict(part.header), {name: channel.pixels for name, channel in part.channels.items()}


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """All layers, with sixteen samples a pixel."""
    path = tmp_path_factory.mktemp("layers") / "whole.exr"
    return render(path, "--layers", "all", "--samples", "16", "--time", "0.5")


@pytest.mark.parametrize("layer", [None, *LAYERS])
def test_files_have_what_is_asked_for(tmp_path, layer):
    header, channels = render(tmp_path / "a.exr", *(["--layers", layer] if layer else []))
    assert set(channels) == ALWAYS | LAYERS.get(layer, set())
    assert ("umbrage/objects" in header) == (layer == "ids")
    assert any(name.startswith("cryptomatte/") for name in header) == (layer == "cryptomatte")


def test_channels_have_their_types(whole):
    _, channels = whole
    assert set(channels) == ALWAYS.union(*LAYERS.values())
    for name, pixels in channels.items():
        expected = np.uint32 if name == "id" or name.startswith("ids.") else np.float32
        assert pixels.dtype == (np.float16 if name in "RGBA" else expected), name
        assert pixels.shape == SIZE[::-1], name


def test_numbers_say_which_object_is_where(whole):
    header, channels = whole
    assert np.array_equal(channels["ids.triangle"], channels["id"])
    names = json.loads(header["umbrage/objects"])
    objects = channels["ids.object"]
    assert np.array_equal(objects == NONE, channels["id"] == NONE)
    seen = {names[number] for number in np.unique(objects[objects != NONE])}
    assert {"felt", "walnut", "table"} < seen and any(name.startswith("ember swirl ") for name in seen), seen
    u, v = channels["barycentric.u"], channels["barycentric.v"]
    assert (u >= 0).all() and (v >= 0).all() and (u + v <= 1 + 1e-6).all() and u.std() > 0.1


def test_lights_shine_and_leave_shadows(whole):
    _, channels = whole
    for name in LAYERS["shadow"]:
        lit = channels[name]
        assert 0 <= lit.min() and lit.max() <= 1 and (lit == 1).any() and (lit == 0).any() and lit.std() > 0.1, name
        # Sixteen samples have seventeen shades.
        assert np.array_equal(lit * 16, np.round(lit * 16)), name
    misses = channels["A"] == 0
    assert (channels["shadow.key"][misses] == 0).all()


def test_mattes_are_those_of_the_manifest(whole):
    header, channels = whole
    attributes = {name.split("/")[2]: (name, value) for name, value in header.items() if name.startswith("cryptomatte/")}
    assert {name: value for name, (_, value) in attributes.items() if name != "manifest"} == {
        "name": "CryptoObject",
        "hash": "MurmurHash3_32",
        "conversion": "uint32_to_float32",
    }
    assert {len(name.split("/")[1]) for name, _ in attributes.values()} == {7}
    manifest = json.loads(attributes["manifest"][1])
    ids = {struct.unpack(">f", bytes.fromhex(digits))[0]: name for name, digits in manifest.items()}
    assert sorted(manifest) == sorted(json.loads(header["umbrage/objects"]))
    ranks = [(f"CryptoObject0{layer}.{a}", f"CryptoObject0{layer}.{b}") for layer in range(3) for a, b in ("RG", "BA")]
    parts = np.stack([channels[part] for _, part in ranks])
    covered = parts.sum(axis=0)
    assert (np.diff(parts, axis=0) <= 0).all(), "the greatest part comes first"
    assert (covered <= 1 + 1e-6).all() and (covered[channels["ids.object"] != NONE] > 0).all()
    few = (parts[-1] == 0) & (channels["A"] == 1)
    assert few.mean() > 0.5 and np.allclose(covered[few], 1)
    # The first sample is of one of the objects that cover its pixel.
    names = json.loads(header["umbrage/objects"])
    for y, x in np.argwhere(few & (channels["ids.object"] != NONE)):
        there = {ids[float(channels[name][y, x])] for name, part in ranks if channels[part][y, x] > 0}
        assert names[channels["ids.object"][y, x]] in there


def test_the_camera_shows_points_where_their_pixels_are(whole):
    header, channels = whole
    width, height = SIZE
    to_ndc, to_camera = (np.asarray(header[name]).reshape(4, 4) for name in ("worldToNDC", "worldToCamera"))
    # Points of pixels, from their depths: the first of sixteen samples is at 1/32 of the pixel.
    rows, columns = np.nonzero(np.isfinite(channels["Z"]))
    depths = channels["Z"][rows, columns].astype(float)
    across = ((columns + 1 / 32) / width - 0.5) * header["screenWindowWidth"]
    up = (0.5 - (rows + 1 / 32) / height) * header["screenWindowWidth"] * height / width
    of_camera = np.stack([across * depths, up * depths, depths, np.ones_like(depths)], axis=1)
    points = of_camera @ np.linalg.inv(to_camera)
    ndc = points @ to_ndc
    pixels = ndc[:, :2] / ndc[:, 3:] * [width, height]
    assert np.allclose(pixels, np.stack([columns, rows], axis=1) + 1 / 32, atol=1e-2)
    # The marbles' table is level.
    normals = np.stack([channels[f"normal.{axis}"] for axis in "XYZ"], axis=-1)[rows, columns]
    level = np.array(json.loads(header["umbrage/objects"]))[channels["ids.object"][rows, columns]] == "felt"
    heights = points[level & (normals[:, 1] > 0.999), 1]
    assert len(heights) > 10 and np.ptp(heights) < 1e-3
    degrees = header["fieldOfViewHorizontal"]
    assert np.isclose(2 * np.tan(np.radians(degrees) / 2), header["screenWindowWidth"])
    assert header["fieldOfViewVertical"] < degrees


def test_frames_move_and_know_their_rate(tmp_path, whole):
    header, channels = render(
        tmp_path / "f_%02d.exr", "--layers", "motion,ids", "--frames", "12..13", "--fps", "30000/1001"
    )
    rate = header["framesPerSecond"]
    assert (rate.numerator, rate.denominator) == (30000, 1001)
    assert "framesPerSecond" not in whole[0]
    moved = np.hypot(channels["motion.X"], channels["motion.Y"])
    names = np.array([*json.loads(header["umbrage/objects"]), "nothing"])
    objects = names[np.minimum(channels["ids.object"], len(names) - 1)]
    # The camera moves a little, marbles fall.
    falling = np.char.find(objects.astype(str), "swirl") >= 0
    assert falling.any() and moved[falling].max() > 3 * np.median(moved[objects == "table"])
    assert (moved[objects == "nothing"] == 0).all()
