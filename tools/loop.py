"""Joins frames to an animated WebP that goes there and back: the last frame leads to the first without a jump.

python3 tools/loop.py out/hero docs/gallery/moving.webp [FPS=24] [QUALITY=60] [once]

Of keys that are symmetric in time half of the frames suffice: those after the last one are the same, backwards. With `once` it goes
there, and begins again. Needs Pillow.
"""
import sys
from pathlib import Path

from PIL import Image


def main(folder, path, fps="24", quality="60", back=None):
    there = [Image.open(file).convert("RGB") for file in sorted(Path(folder).glob("frame_????.png"))]
    frames = there if back == "once" else there + there[-2:0:-1]
    # Whole milliseconds, which add up to the time of all frames.
    ends = [round(1000 * (i + 1) / float(fps)) for i in range(len(frames))]
    durations = [end - start for start, end in zip([0, *ends], ends)]
    # Each frame by itself: what WebP takes over from the frame before shows as blocks in dark gradients.
    frames[0].save(
        path, save_all=True, append_images=frames[1:], duration=durations, loop=0, quality=int(quality), method=6,
        kmin=0, kmax=1,
    )
    print(f"{len(frames)} frames, {Path(path).stat().st_size >> 10} KiB")


if __name__ == "__main__":
    main(*sys.argv[1:])
