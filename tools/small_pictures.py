"""Makes pictures of docs/gallery of one that `gobo render` wrote: a small one, with words, and where the README has it a large one.

python3 tools/small_pictures.py out/frame_0000.png docs/gallery NAME [MASKS.png]

MASKS is what `--debug masks` wrote; the first of them is set into the corner. Needs Pillow.
"""
import pathlib
import sys

from PIL import Image

import label

SMALL = (432, 243)  # [pixels]
LARGE = ("convoy", "depth", "fur", "incense", "market", "pool", "screens")
# Places from left to right and from top to bottom (0 to 1), and words.
WORDS = {
    "depth": ("0.31,0.96,by the curve", "0.69,0.96,by the nearest depth"),
    "failures": ("0.9,0.18,one body", "0.9,0.335,nearest depth", "0.9,0.6,gobo: curve"),
    "seams": ("0.27,0.86,by the nearest depth", "0.78,0.86,by the curve"),
    "halves": ("0.25,0.93,cut out", "0.75,0.93,semitransparent"),
}


def inset(picture, masks):
    """The mask at the left of a debug picture, in the lower left corner."""
    size = (picture.width // 4, picture.height // 4)
    mask = masks.crop((0, 0, picture.width, picture.height)).resize(size, Image.Resampling.LANCZOS)
    picture.paste((20, 20, 20), (16, picture.height - size[1] - 20, size[0] + 20, picture.height - 16))
    picture.paste(mask, (18, picture.height - size[1] - 18))


def main(source, target, name, masks=None):
    picture = Image.open(source).convert("RGB")
    if masks:
        inset(picture, Image.open(masks).convert("RGB"))
    places = [(picture.resize(SMALL, Image.Resampling.LANCZOS), pathlib.Path(target, "small", f"{name}.png"))]
    if name in LARGE:
        places.append((picture, pathlib.Path(target, f"{name}.png")))
    for image, path in places:
        image.save(path, optimize=True)
        if name in WORDS:
            label.main(path, path, *WORDS[name])


if __name__ == "__main__":
    main(*sys.argv[1:])
