"""Makes the pictures of docs/gallery from those of `make gallery`: small ones, with words, and those of the README.

python3 tools/small_pictures.py out/gallery docs/gallery [NAME]...

Needs Pillow.
"""
import pathlib
import sys

from PIL import Image

import label

SMALL = (432, 243)  # [pixels]
LARGE = ("convoy", "depth", "fur", "market", "pool", "screens")
# Places from left to right and from top to bottom (0 to 1), and words.
WORDS = {
    "depth": ("0.31,0.96,by the curve", "0.69,0.96,by the nearest depth"),
    "failures": ("0.9,0.225,one body", "0.9,0.37,nearest depth", "0.9,0.61,gobo: curve"),
    "seams": ("0.27,0.86,by the nearest depth", "0.78,0.86,by the curve"),
    "halves": ("0.25,0.93,cut out", "0.75,0.93,semitransparent"),
}


def main(source, target, *names):
    for file in sorted(pathlib.Path(source).glob("*.png")):
        name = file.stem
        if name == "sheet" or names and name not in names:
            continue
        picture = Image.open(file).convert("RGB")
        places = [(picture.resize(SMALL, Image.Resampling.LANCZOS), pathlib.Path(target, "small", file.name))]
        if name in LARGE:
            places.append((picture, pathlib.Path(target, file.name)))
        for image, path in places:
            image.save(path, optimize=True)
            if name in WORDS:
                label.main(path, path, *WORDS[name])


if __name__ == "__main__":
    main(*sys.argv[1:])
