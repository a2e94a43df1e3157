"""Writes words into a picture.

python3 tools/label.py IN.png OUT.png [SIZE] "0.25,0.05,by the curve" "0.75,0.05,by the nearest depth"

Each argument is the middle of a text, from left to right and from top to bottom (0 to 1), and the text. Needs Pillow.
"""
import sys

from PIL import Image, ImageDraw, ImageFont


def main(source, path, *labels):
    picture = Image.open(source).convert("RGB")
    draw = ImageDraw.Draw(picture)
    is_size = labels[0].isdigit()
    size = int(labels[0]) if is_size else max(11, picture.height // 26)
    font, labels = ImageFont.load_default(size), labels[is_size:]
    for label in labels:
        across, down, text = label.split(",", 2)
        place = (float(across) * picture.width, float(down) * picture.height)
        draw.text(place, text, "white", font, "mm", stroke_width=1 + size // 20, stroke_fill="black")
    picture.save(path, optimize=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
