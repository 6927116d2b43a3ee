"""A spinning lidar of 128 beams before a character that walks in a forest: a range image and a point cloud of one turn.

    python crates/python/examples/lidar.py [PICTURE] [SCENE]

SCENE is what the command reads: a file, a sequence, or a scene that comes with the library. The sensor is where its camera is. It
turns ten times a second, and the scene moves while it turns: each slice of the turn is scanned at its own moment.
"""

import sys

import matplotlib
import numpy as np

import umbrage

matplotlib.use("Agg")
import matplotlib.pyplot as plt

BEAMS, AROUND, SLICES, TURN_SECONDS = 128, 2048, 16, 0.1


def main(picture="lidar.png", address="demo:forest?triangles=60000"):
    animation = umbrage.open(address)
    start = 0.4 * animation.duration
    frame = animation.at(start)

    # From 25° below to 15° above the horizon; rows are beams, columns are steps of the turn.
    elevation = np.radians(np.linspace(15, -25, BEAMS))[:, None]
    azimuth = np.linspace(0, 2 * np.pi, AROUND, endpoint=False)[None, :]
    directions = np.stack(
        np.broadcast_arrays(
            np.cos(elevation) * np.cos(azimuth), np.sin(elevation), np.cos(elevation) * np.sin(azimuth)
        ),
        axis=-1,
    ).astype(np.float32)
    if frame.cameras:
        _, camera = frame.cameras[0]
        origin = np.array(camera.position)
    else:
        origin = animation.origin + (frame.vertices.min(axis=0) + frame.vertices.max(axis=0)) / 2

    scene = umbrage.RaycastingScene(origin=animation.origin)
    mesh = scene.add_triangles(frame.vertices, frame.triangles)
    ranges = np.empty((BEAMS, AROUND))
    cosines = np.empty((BEAMS, AROUND))
    for slice_ in np.array_split(np.arange(AROUND), SLICES):
        moment = start + TURN_SECONDS * slice_[0] / AROUND
        scene.update_vertices(mesh, animation.at(moment).vertices)
        ahead = np.ascontiguousarray(directions[:, slice_])
        answer = scene.scan(origin, ahead)
        ranges[:, slice_] = answer["t_hit"]
        cosines[:, slice_] = np.abs((answer["primitive_normals"] * ahead).sum(axis=-1))

    hit = np.isfinite(ranges)
    points = origin + directions[hit] * ranges[hit, None]
    near = ranges[hit] < np.quantile(ranges[hit], 0.7)
    print(f"{hit.sum()} of {hit.size} directions hit something, from {ranges[hit].min():.2f} to {ranges[hit].max():.2f} away")

    figure = plt.figure(figsize=(12, 8.5), layout="constrained")
    top, below = figure.subfigures(2, 1, height_ratios=[1, 2.6])
    axes = top.subplots()
    image = axes.imshow(
        np.where(hit, ranges, np.nan), extent=(0, 360, -25, 15), aspect="auto", cmap="turbo", norm="log", interpolation="nearest"
    )
    axes.set(title="Range image", xlabel="azimuth in degrees", ylabel="elevation in degrees")
    bar = top.colorbar(image, label="distance in world units", format="{x:.3g}", ticks=[1, 2, 5, 10, 20, 50])
    bar.minorticks_off()
    cloud = below.add_subplot(projection="3d", computed_zorder=False)
    # Its axes are right-handed with z upwards, where the scene's has y.
    turned = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])
    cloud.scatter(*turned @ points[near].T, c=cosines[hit][near], s=0.6, cmap="viridis", linewidths=0)
    cloud.scatter(*turned @ origin, c="red", s=20)
    cloud.set_box_aspect(np.ptp(points[near], axis=0)[[0, 2, 1]], zoom=1.3)
    cloud.set(title="Point cloud of the nearer ones, by the cosine of incidence; the sensor is red", xlabel="x", ylabel="−z", zlabel="y")
    cloud.view_init(elev=32, azim=-75)
    figure.savefig(picture, dpi=110)
    print(f"wrote {picture}")


if __name__ == "__main__":
    main(*sys.argv[1:])
