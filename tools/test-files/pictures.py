"""Writes the picture of pictures.mjs as AVIF in the ways that sharp doesn't have: `pip install pillow && python pictures.py`."""

from pathlib import Path

from PIL import Image

folder = Path(__file__).parent / "../../crates/verify/corpus/images"
width, height = 21, 13
picture = Image.new("RGBA", (width, height))
for y in range(height):
    for x in range(width):
        picture.putpixel((x, y), (40 + 8 * x, 200 - 9 * y, 60 + 4 * x + 5 * y, 255 - 10 * y))

picture.getchannel("R").save(folder / "gray.avif", quality=100, subsampling="4:0:0")
picture.convert("RGB").save(folder / "422-limited.avif", quality=100, subsampling="4:2:2", range="limited")
picture.save(folder / "premultiplied.avif", quality=100, subsampling="4:4:4", alpha_premultiplied=True)
