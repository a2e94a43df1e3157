"""Cuts a part out of a picture.

python3 tools/crop.py out/frame_0000.png part.png 240 135 480 270

The numbers are left, top, width and height [pixels]. Needs Pillow.
"""
import sys

from PIL import Image


def main(source, path, left, top, width, height):
    left, top, width, height = map(int, (left, top, width, height))
    part = Image.open(source).convert("RGB").crop((left, top, left + width, top + height))
    part.save(path, optimize=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
