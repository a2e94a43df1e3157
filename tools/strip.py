"""Puts pictures beside each other, each with a word below.

python3 tools/strip.py docs/stages.png 240 "occlude -> Z=a.png" "accumulate -> F=b.png" ...

The number is the height of all pictures. Needs Pillow.
"""
import sys

from PIL import Image, ImageDraw, ImageFont

GAP, WORDS = 8, 26  # [pixels]


def main(path, height, *parts):
    height = int(height)
    words, files = zip(*(part.rsplit("=", 1) for part in parts))
    pictures = [Image.open(file).convert("RGB") for file in files]
    pictures = [p.resize((round(p.width * height / p.height), height), Image.Resampling.LANCZOS) for p in pictures]
    width = sum(p.width for p in pictures) + GAP * (len(pictures) - 1)
    strip = Image.new("RGB", (width, height + WORDS), "white")
    draw, font, left = ImageDraw.Draw(strip), ImageFont.load_default(14), 0
    for word, picture in zip(words, pictures):
        strip.paste(picture, (left, 0))
        draw.text((left + picture.width / 2, height + WORDS / 2), word, "black", font, "mm")
        left += picture.width + GAP
    strip.save(path, optimize=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
