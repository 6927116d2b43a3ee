"""Hours of sun on the walls, roofs and streets of a block of buildings, on a day in spring.

    python crates/python/examples/sunshine.py [PICTURE]

Walls are cut into cells, and each cell asks which share of it each of the day's suns reaches.
"""

import sys

import matplotlib
import numpy as np

import umbrage

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

LATITUDE_DEGREES, DECLINATION_DEGREES, STEP_HOURS, CELL_METERS = 48.0, 12.0, 1 / 6, 2.0
# West, south, width, depth and height in meters; x is east, y is up, z is south.
BUILDINGS = [
    (8, 10, 14, 12, 22), (26, 8, 18, 10, 12), (50, 8, 14, 16, 34), (8, 30, 14, 22, 10),
    (28, 28, 10, 10, 44), (50, 34, 14, 18, 14), (30, 48, 14, 12, 8), (8, 60, 18, 12, 18), (34, 66, 30, 8, 16),
]  # fmt: skip


def cells(corner, along, across):
    """A rectangle as cells of four corners: counterclockwise where they are seen along minus `along` x `across`."""
    counts = [round(np.linalg.norm(edge) / CELL_METERS) for edge in (along, across)]
    u, v = np.meshgrid(*(np.arange(count) for count in counts), indexing="ij")
    steps = np.stack([u, v], axis=-1)[:, :, None] + np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
    return (np.array(corner) + (steps / counts) @ np.array([along, across], float)).reshape(-1, 4, 3)


def block():
    """The cells of all walls, roofs and the ground, (N, 4, 3)."""
    parts = [cells((0, 0, 0), (0, 0, 80), (72, 0, 0))]
    for west, north, width, depth, height in BUILDINGS:
        low, x, y, z = np.array((west, 0, north)), np.array((width, 0, 0)), np.array((0, height, 0)), np.array((0, 0, depth))
        parts += [cells(low + y, z, x), cells(low, y, x), cells(low + z, x, y), cells(low, z, y), cells(low + x, y, z)]
    return np.concatenate(parts)


def day():
    """Where the sun is at each step while it is up: unit vectors towards it, (L, 3)."""
    latitude, declination = np.radians([LATITUDE_DEGREES, DECLINATION_DEGREES])
    hour = np.radians(15 * np.arange(-12, 12, STEP_HOURS))
    up = np.sin(latitude) * np.sin(declination) + np.cos(latitude) * np.cos(declination) * np.cos(hour)
    south = np.sin(latitude) * np.cos(declination) * np.cos(hour) - np.cos(latitude) * np.sin(declination)
    west = np.cos(declination) * np.sin(hour)
    return np.stack([-west, up, south], axis=-1)[up > 0]


def main(picture="sunshine.png"):
    quads, towards = block(), day()
    scene = umbrage.RaycastingScene()
    triangles = np.arange(4 * len(quads)).reshape(-1, 4)[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)
    scene.add_triangles(quads.reshape(-1, 3).astype(np.float32), triangles.astype(np.uint32))
    share = scene.lit_areas(umbrage.Light.suns(-towards), samples=16)["share"]

    # A cell has two triangles, and only its outer side counts.
    share = share.reshape(len(towards), -1, 2).mean(axis=-1)
    normals = np.cross(quads[:, 1] - quads[:, 0], quads[:, 3] - quads[:, 0])
    hours = STEP_HOURS * (share * (towards @ normals.T > 0)).sum(axis=0)
    print(f"{len(towards)} suns, {len(quads)} cells: {hours.min():.1f} to {hours.max():.1f} hours of sun")

    figure = plt.figure(figsize=(9, 7), layout="constrained")
    axes = figure.add_subplot(projection="3d", proj_type="persp")
    shown = normals @ (-0.55, 0.6, 0.65) > 0
    colors = matplotlib.colormaps["inferno"](hours[shown] / hours.max())
    axes.add_collection3d(Poly3DCollection(quads[shown][..., [0, 2, 1]], facecolors=colors, edgecolors=colors, linewidths=0.3))
    axes.set(xlim=(0, 72), ylim=(80, 0), zlim=(0, 46), xlabel="east in m", ylabel="south in m", zlabel="height in m")
    axes.set_box_aspect((72, 80, 46), zoom=1.1)
    axes.view_init(elev=38, azim=-128)
    scale = matplotlib.cm.ScalarMappable(matplotlib.colors.Normalize(0, hours.max()), "inferno")
    figure.colorbar(scale, ax=axes, shrink=0.6, label=f"hours of sun, {LATITUDE_DEGREES:.0f}° north in late April")
    figure.savefig(picture, dpi=80)
    print(f"wrote {picture}")


if __name__ == "__main__":
    main(*sys.argv[1:])
