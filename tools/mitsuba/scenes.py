"""Small scenes that both programs can show: shapes, what they are made of, a light and a camera."""

from dataclasses import dataclass, field

import numpy as np

Color = tuple[float, float, float]
WHITE: Color = (1.0, 1.0, 1.0)
BLACK: Color = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Material:
    """`kind` is diffuse, glow (radiance `color` everywhere), metal or glass."""

    kind: str
    color: Color = WHITE
    roughness: float = 0.0
    ior: float = 1.5
    # What is left of light after one unit inside of glass.
    left_after_one: Color = WHITE
    # Whether Mitsuba has Umbrage's metal (white) rather than its own.
    is_mended: bool = False


@dataclass
class Shape:
    """Triangles with a unit normal for each vertex."""

    positions: np.ndarray
    normals: np.ndarray
    triangles: np.ndarray
    material: Material
    # World units a second.
    velocity: Color = BLACK


@dataclass(frozen=True)
class Lamp:
    """A ball that sends so many candela in all directions, or a panel with a level width that sends as many to its target."""

    position: Color
    candela: float
    radius: float = 0.0
    target: Color | None = None
    # Width and height, where there is a target.
    size: tuple[float, float] = (1.0, 1.0)


@dataclass(frozen=True)
class Viewpoint:
    eye: Color
    target: Color
    # Vertical field of view.
    fov_degrees: float = 35.0
    aperture: float = 0.0
    focus: float = 1.0


@dataclass
class Case:
    """A scene and how it is rendered. `depth` counts mirrors and surfaces of glass one after the other."""

    name: str
    shapes: list[Shape]
    camera: Viewpoint
    lamps: list[Lamp] = field(default_factory=list)
    background: Color = BLACK
    depth: int = 0
    gloss: bool = False
    shutter_seconds: float = 0.0
    samples: int = 256


# The middle of the animation, and its length, in seconds.
MOMENT, DURATION = 1.0, 2.0


def quad(corner, first, second, material):
    """A parallelogram, seen from where its edges `first` and `second` turn counterclockwise."""
    corner, first, second = (np.array(vector, float) for vector in (corner, first, second))
    positions = np.array([corner, corner + first, corner + first + second, corner + second])
    normal = np.cross(first, second)
    normals = np.tile(normal / np.linalg.norm(normal), (4, 1))
    return Shape(positions, normals, np.array([[0, 1, 2], [0, 2, 3]]), material)


def joined(shapes):
    """Shapes of one material as one."""
    offsets = np.cumsum([0] + [len(shape.positions) for shape in shapes])
    return Shape(
        np.concatenate([shape.positions for shape in shapes]),
        np.concatenate([shape.normals for shape in shapes]),
        np.concatenate([shape.triangles + offset for shape, offset in zip(shapes, offsets)]),
        shapes[0].material,
        shapes[0].velocity,
    )


def checker(corner, first, second, count, materials):
    """`count` × `count` squares of two materials in turn."""
    corner, first, second = (np.array(vector, float) for vector in (corner, first, second))
    squares = ([], [])
    for i in range(count):
        for j in range(count):
            which = (i + j) % 2
            at = corner + (first * i + second * j) / count
            squares[which].append(quad(at, first / count, second / count, materials[which]))
    return [joined(of_one) for of_one in squares]


def ball(center, radius, material, velocity=BLACK, rings=96):
    """A sphere with 2 × `rings` meridians; those triangles at the poles that would be lines are left out."""
    angles = np.linspace(0, np.pi, rings + 1), np.linspace(0, 2 * np.pi, 2 * rings + 1)
    polar, around = np.meshgrid(*angles, indexing="ij")
    normals = np.stack([np.sin(polar) * np.cos(around), np.cos(polar), -np.sin(polar) * np.sin(around)], -1)
    normals = normals.reshape(-1, 3)
    row = 2 * rings + 1
    triangles = []
    for i in range(rings):
        for j in range(2 * rings):
            a, b, c, d = (i * row + j, (i + 1) * row + j, (i + 1) * row + j + 1, i * row + j + 1)
            triangles += [[a, b, c]] if i + 1 < rings else []
            triangles += [[a, c, d]] if i > 0 else []
    return Shape(np.array(center) + radius * normals, normals, np.array(triangles), material, velocity)


def box(center, size, degrees, material, velocity=BLACK):
    """A box, turned around the vertical axis."""
    angle = np.radians(degrees)
    axes = np.array([[np.cos(angle), 0, -np.sin(angle)], [0, 1, 0], [np.sin(angle), 0, np.cos(angle)]])
    axes = axes * np.array(size, float)[:, None]
    faces = []
    for axis in range(3):
        for sign in (-1.0, 1.0):
            across = axes[(axis + 1) % 3], axes[(axis + 2) % 3]
            first, second = across if sign > 0 else across[::-1]
            corner = np.array(center) + 0.5 * (sign * axes[axis] - first - second)
            faces.append(quad(corner, first, second, material))
    shape = joined(faces)
    shape.velocity = velocity
    return shape
