"""What is compared."""

from scenes import WHITE, Case, Lamp, Material, Viewpoint, ball, box, checker, quad

CLAY = Material("diffuse", (0.7, 0.7, 0.7))
TERRACOTTA = Material("diffuse", (0.7, 0.3, 0.2))
SLATE = Material("diffuse", (0.2, 0.35, 0.6))
BRIGHT_SQUARES = (Material("glow", (0.9, 0.85, 0.75)), Material("glow", (0.12, 0.14, 0.2)))
CLAY_SQUARES = (Material("diffuse", (0.8, 0.8, 0.8)), Material("diffuse", (0.25, 0.25, 0.25)))


def glass():
    """A clear ball and a tinted block over a floor that glows, so that no light has to be found through glass."""
    clear = Material("glass")
    tinted = Material("glass", left_after_one=(0.35, 0.75, 0.55))
    floor = checker((-4, 0, 4), (8, 0, 0), (0, 0, -8), 16, BRIGHT_SQUARES)
    shapes = [*floor, ball((-0.9, 1.05, 0), 0.9, clear), box((1.1, 0.9, 0.1), (1.4, 1.4, 0.5), 25, tinted)]
    camera = Viewpoint((0.4, 2.6, 5.2), (0.05, 0.8, 0))
    return Case("glass", shapes, camera, background=(0.35, 0.45, 0.6), depth=8, samples=64)


def gloss(is_mended=False):
    """Metal plates of two roughnesses below what glows, and a lamp that is mirrored in them."""
    smoother, rougher = (Material("metal", WHITE, roughness, is_mended=is_mended) for roughness in (0.2, 0.4))
    wall = checker((-3, 0, -2), (6, 0, 0), (0, 3, 0), 12, BRIGHT_SQUARES)
    plates = [quad((-3, 0, 3), (3, 0, 0), (0, 0, -5), smoother), quad((0, 0, 3), (3, 0, 0), (0, 0, -5), rougher)]
    balls = [
        ball((-0.8, 0.6, -0.6), 0.45, Material("glow", (0.9, 0.25, 0.1))),
        ball((0.8, 0.6, -0.6), 0.45, Material("glow", (0.1, 0.45, 0.9))),
    ]
    camera = Viewpoint((0, 2.2, 4.6), (0, 0.3, -0.4))
    lamps = [Lamp((0, 2.2, -1.4), 1.5)]
    name = "same_gloss" if is_mended else "gloss"
    return Case(name, [*wall, *plates, *balls], camera, lamps, (0.1, 0.12, 0.16), 1, gloss=True)


def same_gloss():
    """The same with one formula in both programs; minutes, since Mitsuba's part of it is in Python."""
    return gloss(is_mended=True)


def light():
    """The shadows of a lamp with a size."""
    floor = quad((-4, 0, 4), (8, 0, 0), (0, 0, -8), CLAY)
    shapes = [floor, box((-0.7, 0.6, 0.2), (0.5, 1.2, 0.5), 30, TERRACOTTA), ball((0.8, 0.5, 0.1), 0.5, SLATE)]
    lamps = [Lamp((2.2, 4.0, 2.0), 60.0, radius=0.5)]
    return Case("light", shapes, Viewpoint((0, 2.8, 5.0), (0, 0.4, 0)), lamps)


def panel():
    """The shadows of a panel that faces the floor aslant."""
    lamps = [Lamp((2.2, 2.6, 1.0), 40.0, target=(-0.4, 0.3, 0.0), size=(2.0, 0.7))]
    return Case("panel", light().shapes, Viewpoint((0, 2.8, 5.0), (0, 0.4, 0)), lamps)


def lens():
    """A row of balls away from a lens that is sharp at the third."""
    floor = checker((-4, 0, 3), (8, 0, 0), (0, 0, -14), 16, CLAY_SQUARES)
    materials = (TERRACOTTA, SLATE, CLAY, TERRACOTTA, SLATE)
    row = [ball((-1.2 + 0.7 * i, 0.4, 1.6 - 1.4 * i), 0.4, material) for i, material in enumerate(materials)]
    camera = Viewpoint((0, 1.5, 5.5), (0, 0.4, 0), 35.0, aperture=0.4, focus=6.6)
    return Case("lens", [*floor, *row], camera, [Lamp((3.0, 6.0, 4.0), 120.0)])


def shutter():
    """A ball and a block that move while the shutter is open, with their shadows."""
    floor = checker((-4, 0, 4), (8, 0, 0), (0, 0, -8), 16, CLAY_SQUARES)
    moving = [
        ball((-0.8, 0.9, 0.2), 0.45, TERRACOTTA, velocity=(1.5, 0.0, 0.0)),
        box((0.9, 0.6, 0.0), (0.6, 0.6, 0.6), 20, SLATE, velocity=(0.0, 1.2, 0.6)),
    ]
    camera = Viewpoint((0, 2.8, 5.0), (0, 0.5, 0))
    return Case("shutter", [*floor, *moving], camera, [Lamp((2.0, 5.0, 3.0), 90.0)], shutter_seconds=0.4)


ALL = {make.__name__: make for make in (glass, gloss, same_gloss, light, panel, lens, shutter)}
