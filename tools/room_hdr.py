"""Writes data/gallery/room.hdr: a dim room as light from all around, with a window and a glow for glass to mirror.

python3 tools/room_hdr.py data/gallery/room.hdr

An equirectangular Radiance image, whose middle looks along -z. Needs numpy.
"""
import sys

import numpy as np

WIDTH, HEIGHT = 256, 128


def smooth(low, high, x):
    t = np.clip((x - low) / (high - low), 0, 1)
    return t * t * (3 - 2 * t)


def room():
    """Linear radiance of each texel."""
    x, y = np.meshgrid((np.arange(WIDTH) + 0.5) / WIDTH, (np.arange(HEIGHT) + 0.5) / HEIGHT)
    turn = (x - 0.5) * 360  # to the right of -z [degrees]
    height = (0.5 - y) * 180  # above the horizon [degrees]
    wall = smooth(-70, 40, height)[..., None]
    light = np.array([0.035, 0.022, 0.016]) * (1 - wall) + np.array([0.1, 0.062, 0.04]) * wall
    # a wall behind the table, lit from the left
    glow = np.exp(-((turn + 22) / 34) ** 2 - ((height + 6) / 22) ** 2)[..., None]
    light = light + glow * np.array([0.62, 0.27, 0.11])
    # a window of two by three panes, behind the viewer's left shoulder, and a narrow one at the right
    for middle, width, bars, strength in ((-118, 10, 2, 8.0), (74, 3, 1, 5.0)):
        across = (turn - middle) / width
        up = (height - 24) / 16
        panes = (np.abs(across) < 1) & (np.abs(up) < 1)
        panes &= np.abs((across + 1) * bars / 2 % 1 - 0.5) < 0.45
        panes &= np.abs((up + 1) * 1.5 % 1 - 0.5) < 0.46
        light = light + panes[..., None] * strength * np.array([0.86, 0.94, 1.0])
    return light


def main(path):
    light = room()
    most = light.max(-1)
    mantissa, exponent = np.frexp(most)
    texels = np.empty((HEIGHT, WIDTH, 4), np.uint8)
    texels[..., :3] = light * (mantissa / most * 256)[..., None]
    texels[..., 3] = exponent + 128
    with open(path, "wb") as file:
        file.write(f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {HEIGHT} +X {WIDTH}\n".encode() + texels.tobytes())


if __name__ == "__main__":
    main(sys.argv[1])
