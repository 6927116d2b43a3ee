"""The shaded share of a spacecraft's solar panels along an orbit, while they turn after the sun.

    python crates/python/examples/panels.py [PICTURE]

The craft always has the same side down. Its panels turn about their axis, so far as that helps, and its body and dish keep light
away from them. Each step moves the panels and asks `lit_areas` about the sun.
"""

import sys

import matplotlib
import numpy as np

import umbrage

matplotlib.use("Agg")
import matplotlib.pyplot as plt

STEPS, BETA_DEGREES, EARTH_OVER_ORBIT = 180, 52.0, 6371 / 6921


def box(low, high):
    """Vertices and triangles of a box."""
    low, high = np.array(low, float), np.array(high, float)
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = [of for a, b, c, d in quads for of in ((a, b, c), (a, c, d))]
    return (low + corners * (high - low)).astype(np.float32), np.array(triangles, np.uint32)


def dish(middle, radius, depth, rings=6, around=32):
    """Vertices and triangles of a paraboloid that opens downwards."""
    r, angle = np.meshgrid(np.linspace(0, 1, rings), np.arange(around) * 2 * np.pi / around, indexing="ij")
    vertices = np.stack([radius * r * np.cos(angle), -depth * r**2, radius * r * np.sin(angle)], axis=-1)
    ring, step = np.meshgrid(np.arange(rings - 1), np.arange(around), indexing="ij")
    a, b = (ring * around + step).ravel(), (ring * around + (step + 1) % around).ravel()
    triangles = np.concatenate([np.stack([a, b, b + around], -1), np.stack([a, b + around, a + around], -1)])
    return (np.array(middle) + vertices.reshape(-1, 3)).astype(np.float32), triangles.astype(np.uint32)


def sun(turn):
    """The direction to the sun for an observer on board: x is ahead, y is up, z is across, the panels' axis."""
    beta = np.radians(BETA_DEGREES)
    return np.array([-np.cos(beta) * np.sin(turn), np.cos(beta) * np.cos(turn), np.sin(beta)])


def is_eclipsed(towards):
    """Whether the Earth, below, is before the sun."""
    return towards[1] < -np.sqrt(1 - EARTH_OVER_ORBIT**2)


def main(picture="panels.png"):
    scene = umbrage.RaycastingScene()
    for part in (box((-1.2, -1, -0.8), (1.2, 1.6, 0.8)), dish((0, -1.4, 0), 1.9, 0.7), box((0.9, 1.6, 0.2), (1.1, 4.2, 0.4))):
        scene.add_triangles(*part)
    wings = [scene.add_triangles(*box((-0.9, -0.02, low), (0.9, 0.02, low + 5))) for low in (-6.2, 1.2)]
    turns = np.linspace(0, 2 * np.pi, STEPS, endpoint=False)
    shaded, power = np.full((STEPS, 2), np.nan), np.zeros(STEPS)
    for step, turn in enumerate(turns):
        towards = sun(turn)
        angle = np.arctan2(-towards[0], towards[1])
        turned = np.eye(4)
        turned[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
        for wing in wings:
            scene.set_transform(wing, turned)
        if is_eclipsed(towards):
            continue
        share = scene.lit_areas(umbrage.Light.sun(-towards), samples=1024)["share"][0]
        # The two large triangles of a wing that face the sun: y is the same for all corners, which are at the top.
        lit = np.array([share[scene.triangle_slice(wing)][6:8].mean() for wing in wings])
        shaded[step], power[step] = 1 - lit, lit.mean() * np.hypot(*towards[:2])
    worst = int(np.nanargmax(shaded.sum(axis=1)))
    print(f"at worst {np.nanmax(shaded):.1%} of a wing is shaded; in the mean of an orbit {power.mean():.3f} of full power")

    towards = sun(turns[worst])
    angle = np.arctan2(-towards[0], towards[1])
    turned[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    for wing in wings:
        scene.set_transform(wing, turned)
    view = umbrage.Camera(9 * towards + (3, 5, -9), (0, 0.3, 0), fov_degrees=56)
    image = scene.render(view, 760, 560, samples=16, lights=[umbrage.Light.sun(-towards)], background="#0a0e1a")

    figure, (left, right) = plt.subplots(1, 2, figsize=(12, 4.2), width_ratios=[1.3, 1], layout="constrained")
    degrees = np.degrees(turns)
    left.plot(degrees, 100 * shaded, label=["wing away from the sun", "wing towards the sun"])
    left.plot(degrees, 100 * power, color="gray", linestyle="--", label="power, of a panel square to the sun")
    dark = degrees[np.isnan(shaded[:, 0])]
    if len(dark):
        left.axvspan(dark.min(), dark.max(), color="black", alpha=0.12, label="the Earth's shadow")
    left.axvline(degrees[worst], color="red", linewidth=0.8)
    left.set(xlabel="along the orbit in degrees from noon", ylabel="percent", xlim=(0, 360), ylim=(0, 100), xticks=range(0, 361, 45))
    left.legend(loc="upper center", fontsize=8)
    left.set_title("Shaded share of each wing")
    right.imshow(image)
    right.set_title("Where the most is shaded (red line)")
    right.axis("off")
    figure.savefig(picture, dpi=90)
    print(f"wrote {picture}")


if __name__ == "__main__":
    main(*sys.argv[1:])
