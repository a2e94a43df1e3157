"""Writes data/gallery/slide.png, the slide of data/projector.toml and data/gallery/cinema.toml: a balloon over a lake in the evening.

python3 tools/slide.py data/gallery/slide.png

Needs Pillow and numpy.
"""
import math
import sys

import numpy as np
from PIL import Image, ImageDraw, ImageFilter

SIZE = (480, 320)  # [pixels]
FINE = 3  # pixels drawn for one, along each axis
SHORE = 0.66  # share of the height
SUN = (0.66, 0.56)  # shares of the width and of the height
# Heights, and colours between them.
SKY = ((0.0, (16, 24, 92)), (0.24, (92, 38, 140)), (0.42, (226, 66, 98)), (0.56, (255, 148, 52)), (SHORE, (255, 226, 120)))
GORES = ((226, 30, 44), (255, 196, 24), (20, 150, 214), (250, 246, 232))


def gradient(stops, at):
    """Colours between `stops` at heights `at`."""
    heights = [height for height, _ in stops]
    return np.stack([np.interp(at, heights, [color[i] for _, color in stops]) for i in range(3)], -1)


def ridge(x, seed, rough):
    """Heights of a range of mountains over the shore, shares of the height."""
    waves = [(3, 0.05), (7, 0.028), (15, 0.014 * rough), (31, 0.007 * rough)]
    return 0.06 + sum(size * (math.sin(count * x * 2.1 + seed * (i + 1.7)) + 0.4) for i, (count, size) in enumerate(waves))


def balloon(draw, middle, radius):
    """An envelope of gores, and its basket."""
    x, y = middle
    tip = (x, y + 1.62 * radius)
    draw.polygon([(x - 0.8 * radius, y + 0.6 * radius), (x + 0.8 * radius, y + 0.6 * radius), tip], fill=GORES[0])
    # From outside to the middle: each gore is an ellipse that the next one covers.
    for i, part in enumerate((1.0, 0.78, 0.5, 0.2)):
        half = part * radius
        draw.ellipse((x - half, y - radius, x + half, y + radius), fill=GORES[i])
        draw.polygon([(x - 0.8 * half, y + 0.6 * radius), (x + 0.8 * half, y + 0.6 * radius), tip], fill=GORES[i])
    draw.ellipse((x - 0.24 * radius, y + 1.36 * radius, x + 0.24 * radius, y + 1.46 * radius), fill=(60, 20, 40))
    draw.rectangle((x - 0.15 * radius, y + 1.7 * radius, x + 0.15 * radius, y + 1.92 * radius), fill=(70, 34, 20))
    for side in (-1, 1):
        draw.line((x + side * 0.2 * radius, y + 1.42 * radius, x + side * 0.14 * radius, y + 1.7 * radius), fill=(50, 24, 30), width=3)


def pine(draw, x, foot, height):
    for i in range(5):
        top, low = foot - height * (1 - 0.16 * i), foot - height * (0.72 - 0.18 * i)
        half = height * (0.07 + 0.035 * i)
        draw.polygon([(x, top), (x - half, low), (x + half, low)], fill=(14, 12, 34))


def main(path):
    width, height = (FINE * edge for edge in SIZE)
    rows = (np.arange(height) + 0.5) / height
    columns = (np.arange(width) + 0.5) / width
    # The lake mirrors the sky, darker.
    mirrored = np.where(rows < SHORE, rows, np.maximum(SHORE - 1.7 * (rows - SHORE), 0))
    sky = gradient(SKY, mirrored) * np.where(rows < SHORE, 1.0, 0.72)[:, None]
    image = np.repeat(sky[:, None], width, 1)
    x, y = np.meshgrid((columns - SUN[0]) * 1.5, rows - SUN[1])
    glow = np.exp(-(x * x + y * y) / 0.02) * (rows < SHORE)[:, None]
    image += glow[..., None] * np.array([60, 120, 110])
    picture = Image.fromarray(np.uint8(np.clip(image, 0, 255)))
    draw = ImageDraw.Draw(picture)
    at, radius = (SUN[0] * width, SUN[1] * height), 0.075 * height
    draw.ellipse((at[0] - radius, at[1] - radius, at[0] + radius, at[1] + radius), fill=(255, 250, 214))
    shore = SHORE * height
    for seed, color, tall in ((1.3, (150, 60, 120), 1.25), (4.1, (98, 36, 104), 0.95), (7.7, (52, 22, 78), 0.6)):
        tops = [(i, shore - tall * ridge(i / width, seed, 1.5) * height) for i in range(0, width + 1, 3)]
        draw.polygon([(0, shore), *tops, (width, shore)], fill=color)
    # Glitter under the sun, wider towards the viewer.
    for i in range(26):
        part = (i + 0.5) / 26
        row = shore + part**1.4 * (height - shore)
        half = (0.02 + 0.11 * part) * width * (0.55 + 0.45 * math.sin(11.3 * i))
        middle = at[0] + 0.02 * width * math.sin(5.1 * i)
        draw.line((middle - half, row, middle + half, row), fill=(255, 216, 130), width=2 + int(5 * part))
    balloon(draw, (0.27 * width, 0.27 * height), 0.165 * height)
    balloon(draw, (0.83 * width, 0.2 * height), 0.055 * height)
    for place, tall in ((0.02, 0.5), (0.075, 0.36), (0.13, 0.27), (0.94, 0.4), (0.99, 0.56)):
        pine(draw, place * width, height, tall * height)
    picture.filter(ImageFilter.GaussianBlur(1)).resize(SIZE, Image.Resampling.LANCZOS).save(path, optimize=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
