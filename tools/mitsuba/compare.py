#!/usr/bin/env python3
"""Pictures of Umbrage beside those of Mitsuba 3, and how far they are apart.

    pip install mitsuba numpy pillow
    cargo build --release
    python tools/mitsuba/compare.py --output docs/images

prints a line of a table for each case (means of absolute differences in parts of the reference's mean; `mean` is by how
much all of Umbrage's picture is brighter) and writes mitsuba_NAME.png: Umbrage, Mitsuba, and ten times what is between
them.
"""

import argparse
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image

import cases
import ours
import theirs

ROOT = Path(__file__).resolve().parents[2]
BLOCK = 8


def relative_error(image, reference):
    """The mean of all absolute differences in parts of the mean of the reference, over pixels and channels."""
    return np.abs(image - reference).mean() / reference.mean()


def blocks(image):
    """Means of 8 × 8 pixels."""
    height, width = (side // BLOCK * BLOCK for side in image.shape[:2])
    return image[:height, :width].reshape(height // BLOCK, BLOCK, width // BLOCK, BLOCK, 3).mean((1, 3))


def screen(image):
    """Bytes of linear radiance on a screen; what is too bright is cut off."""
    linear = np.clip(image, 0, 1)
    curved = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    return np.uint8(np.round(255 * curved))


def side_by_side(image, reference, path):
    difference = np.clip(10 * np.abs(image - reference), 0, 1)
    pictures = np.concatenate([screen(image), screen(reference), np.uint8(255 * difference)], 1)
    Image.fromarray(pictures).quantize(256).save(path, optimize=True)


def compare(name, arguments, folder):
    case = cases.ALL[name]()
    if arguments.samples:
        case.samples = arguments.samples
    picture = ours.render(case, arguments.size, arguments.umbrage, folder)
    image = theirs.read(picture)
    # Twice, for what noise alone is between two pictures of theirs.
    size, samples = arguments.size, arguments.reference_samples
    first, second = (theirs.render(case, size, samples, folder, seed) for seed in (0, 1))
    both = (first + second) / 2
    side_by_side(image, both, arguments.output / f"mitsuba_{name}.png")
    # Half of a difference of two is as large as the error of their mean.
    noise = relative_error(blocks(first), blocks(second)) / 2
    errors = relative_error(image, both), relative_error(blocks(image), blocks(both))
    bias = image.mean() / both.mean() - 1
    counts = f"{case.samples} | {2 * samples}"
    print(f"| {name} | {counts} | {errors[0]:.2%} | {errors[1]:.2%} | {noise:.2%} | {bias:+.2%} |", flush=True)


def size(text):
    width, height = (int(side) for side in text.split("x"))
    return width, height


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"{', '.join(cases.ALL)} [default: all]")
    parser.add_argument("--umbrage", type=Path, default=ROOT / "target/release/umbrage", help="the command")
    parser.add_argument("--size", type=size, default=(320, 240), metavar="WxH")
    parser.add_argument("--samples", type=int, help="of each pixel in Umbrage [default: 256]")
    parser.add_argument("--reference-samples", type=int, default=512, help="in Mitsuba, twice")
    parser.add_argument("--output", type=Path, default=Path("."), help="folder for the pictures")
    parser.add_argument("--keep", type=Path, help="folder for scenes and EXR files [default: none is kept]")
    arguments = parser.parse_args()
    unknown = set(arguments.names) - set(cases.ALL)
    if unknown:
        parser.error(f"there is no {', '.join(sorted(unknown))}")
    print("| | samples | of Mitsuba | pixels | 8×8 means | noise of these | mean |\n|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as scratch:
        folder = arguments.keep or Path(scratch)
        folder.mkdir(parents=True, exist_ok=True)
        for name in arguments.names or cases.ALL:
            compare(name, arguments, folder)


if __name__ == "__main__":
    main()
