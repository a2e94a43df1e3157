"""Clouds of points as laspy, copclib, pye57 and pypcd4 store them, beside the numbers that they were made of."""
import re
import sys

import numpy

from common import FILES, WRONG, attempt, gobo, maps, row, scene, texels
from volumes import package

BULLET = "points"
# Rounding of coordinates to 1/1000 in LAS, and of a depth to its float.
PLACE = 1e-3


def cloud():
    """Points over a grid of metres, so that no disc hides another from above: places, sRGB bytes, classes."""
    chance = numpy.random.default_rng(3)
    x, y = numpy.meshgrid(numpy.arange(12.0), numpy.arange(9.0), indexing="ij")
    places = numpy.stack([x, y, chance.uniform(0, 3, x.shape)], -1).reshape(-1, 3)
    places[:, :2] += chance.uniform(-0.15, 0.15, (len(places), 2))
    places = numpy.round(places, 3)
    return places, chance.integers(30, 256, places.shape), chance.integers(2, 6, len(places))


def linear(bytes_of):
    share = bytes_of / 255
    return numpy.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)


def compare(name, program, places, colors, offset=(0, 0, 0), limit=0.002, alpha=1.0, more="", what=""):
    """Discs as a sun from above sees them: the colour and depth of each, and light elsewhere.

    `colors`: bytes of sRGB, or linear floats; `alpha`: of each disc; `more`: keys of the table.
    """
    path = scene("_".join(["points", *name.split("."), *what.split()]), f"""
[[material]]
name = "m"
transfer = "filter"
profile = "flat"
radius = 0.3
[[particles]]
file = "{name}"
material = "m"
{more}
[[light]]
name = "sun"
kind = "directional"
direction = [0, -1, 0]
size = 512
[shadow]
receiver = "nearest"
""")
    [(view, arrays)], said = maps(path)
    points, direction = texels(view)
    # z up turned to y; a far origin is subtracted, in whole kilometres, which the message names.
    here = numpy.stack([places[:, 0], places[:, 2], -places[:, 1]], -1) - numpy.asarray(offset, float)
    across = numpy.linalg.norm(points[:, :, None, ::2] - here[None, None, :, ::2], axis=-1)
    disc, distance = across.argmin(-1), across.min(-1)
    texel = abs(points[0, 1] - points[0, 0]).max()
    inside, outside = distance < 0.3 - texel, distance > 0.3 + texel
    light = arrays["filter"]
    shown = linear(colors) if numpy.issubdtype(colors.dtype, numpy.integer) else colors
    alphas = numpy.broadcast_to(alpha, len(places))[disc][..., None]
    truth = 1 - alphas * (1 - shown[disc])
    row(BULLET, name, program, f"colour in the discs {what}".rstrip(), numpy.abs(light - truth)[inside].max(), limit)
    row(BULLET, name, program, "shadow beside them", numpy.abs(light - 1)[outside].max(), 1e-6)
    depth = arrays["nearest"] * (view["far"] - view["near"]) + view["near"]
    off = points + direction * (depth - view["near"])[..., None]
    row(BULLET, name, program, "height [m]", numpy.abs(off[..., 1] - here[disc, 1])[inside].max(), PLACE)
    row(BULLET, name, program, "discs missing", len(places) - len(set(disc[inside])), 0)
    return said


def las_files(places, colors, classes):
    import laspy

    for name, form, wide, shift in [
        ("format2.las", 2, 257, 0),
        ("format3.laz", 3, 257, 0),
        ("format7.las", 7, 257, 0),
        ("format7.laz", 7, 257, 0),
        ("narrow.las", 2, 1, 0),
        ("mercator.laz", 7, 257, [1350000.0, 6250000.0, 0]),
    ]:
        head = laspy.LasHeader(point_format=form, version="1.4" if form > 5 else "1.2")
        head.scales, head.offsets = [0.001] * 3, numpy.zeros(3) + shift
        cloud_of = laspy.LasData(head)
        cloud_of.x, cloud_of.y, cloud_of.z = (places + shift).T
        cloud_of.red, cloud_of.green, cloud_of.blue = (colors * wide).T
        cloud_of.classification = classes

        def check(name=name, cloud_of=cloud_of, shift=shift):
            cloud_of.write(FILES / name)
            moved = places + shift
            offset = numpy.zeros(3)
            if numpy.abs(moved).max() > 1e4:
                middle = numpy.round((moved.min(0) + moved.max(0)) / 2, -3)
                offset = numpy.array([middle[0], middle[2], -middle[1]])
            said = compare(name, package("laspy"), moved, colors, offset)
            row(BULLET, name, package("laspy"), "messages of an origin missing", float(bool(offset.any()) and "1350" not in said), 0)

        attempt(BULLET, name, package("laspy"), check)


def laspy_scalars(places, colors, classes):
    """Without colours: grey by intensity; and the alphas that a scene gives to classes."""
    import laspy

    program = package("laspy")
    shades = numpy.random.default_rng(5).integers(0, 60000, len(places))

    def check():
        head = laspy.LasHeader(point_format=6, version="1.4")
        head.scales, head.offsets = [0.001] * 3, numpy.zeros(3)
        cloud_of = laspy.LasData(head)
        cloud_of.x, cloud_of.y, cloud_of.z = places.T
        cloud_of.intensity, cloud_of.classification = shades, classes
        cloud_of.write(FILES / "scalars.laz")
        white = numpy.sort(shades)[int((len(shades) - 1) * 0.98)]
        grey = numpy.clip(shades / white, 0.05, 1)[:, None].repeat(3, 1)
        alphas = {2: 1, 3: 0.75, 4: 0, 5: 0.4}
        alpha = numpy.array([alphas[one] for one in classes])
        compare("scalars.laz", program, places, grey, what="by intensity")
        shown = alpha > 0
        more = f"classes = {[[one, share] for one, share in alphas.items()]}"
        compare("scalars.laz", program, places[shown], grey[shown], alpha=alpha[shown], more=more, what="by class")

    attempt(BULLET, "scalars.laz", program, check)


def copc_files(places, colors):
    """Three levels: a sixteenth of the points, a quarter, the rest."""
    import copclib

    program = package("copclib")

    def check():
        config = copclib.CopcConfigWriter(7, [0.001] * 3, [0, 0, 0])
        config.las_header.min = list(places.min(0))
        config.las_header.max = list(places.max(0))
        config.copc_info.center_x, config.copc_info.center_y, config.copc_info.center_z = 6, 6, 6
        config.copc_info.halfsize, config.copc_info.spacing = 6.5, 1
        writer = copclib.FileWriter(str(FILES / "tree.copc.laz"), config)
        level = numpy.arange(len(places)) % 16
        level = numpy.where(level == 0, 0, numpy.where(level < 4, 1, 2))
        for depth in range(3):
            cell = numpy.clip(((places + 0.5) / (13 / 2**depth)).astype(int), 0, 2**depth - 1)
            for key in sorted({tuple(int(i) for i in one) for one in cell[level == depth]}):
                mine = numpy.flatnonzero((level == depth) & (cell == key).all(1))
                points = copclib.Points(writer.copc_config.las_header)
                for i in mine:
                    point = points.CreatePoint()
                    point.x, point.y, point.z = (float(c) for c in places[i])
                    point.red, point.green, point.blue = (int(c) * 257 for c in colors[i])
                    points.AddPoint(point)
                writer.AddNode(copclib.VoxelKey(depth, *key), points)
        writer.Close()
        compare("tree.copc.laz", program, places, colors)
        for levels in (1, 2):
            kept = level < levels
            name = f"tree.copc.laz, {levels} of 3 levels"
            (FILES / f"budget{levels}.toml").write_text(
                f"[[material]]\nname = 'm'\n[[particles]]\nfile = 'tree.copc.laz'\nmaterial = 'm'\npoint_budget = {kept.sum() + 1}\n"
            )
            said = gobo("check", FILES / f"budget{levels}.toml")
            counts = [int(number.replace(",", "")) for number in re.findall(r"[\d,]+", said) if number.strip(",")]
            row(BULLET, name, program, f"count of {kept.sum()} not said", float(int(kept.sum()) not in counts), 0)

    attempt(BULLET, "tree.copc.laz", program, check)


def e57_files(places, colors):
    import pye57

    program = package("pye57")

    def check():
        path = FILES / "scan.e57"
        path.unlink(missing_ok=True)
        file = pye57.E57(str(path), mode="w")
        # The pose turns by 90 degrees about z and moves; what is stored is turned back.
        moved = places - [1.0, 2.0, 0.5]
        local = numpy.stack([moved[:, 1], -moved[:, 0], moved[:, 2]], -1)
        half = 0.5**0.5
        file.write_scan_raw(
            {
                "cartesianX": local[:, 0], "cartesianY": local[:, 1], "cartesianZ": local[:, 2],
                "colorRed": colors[:, 0].astype("u1"), "colorGreen": colors[:, 1].astype("u1"), "colorBlue": colors[:, 2].astype("u1"),
            },
            rotation=numpy.array([half, 0, 0, half]),
            translation=numpy.array([1.0, 2.0, 0.5]),
        )
        file.close()
        compare("scan.e57", program, places, colors)

    attempt(BULLET, "scan.e57", program, check)


def pcd_files(places, colors):
    import pypcd4

    program = package("pypcd4")
    packed = pypcd4.PointCloud.encode_rgb(colors.astype("u1"))
    # In text, pypcd4 writes colours in floats as 0: whole numbers there.
    whole = packed.astype("f4").view("u4")
    for encoding in ("ASCII", "BINARY", "BINARY_COMPRESSED"):
        name = f"{encoding.lower()}.pcd"

        def check(name=name, encoding=encoding):
            columns = [*places.astype("f4").T, whole if encoding == "ASCII" else packed.astype("f4")]
            kinds = [numpy.float32] * 3 + [numpy.uint32 if encoding == "ASCII" else numpy.float32]
            made = pypcd4.PointCloud.from_points(columns, ("x", "y", "z", "rgb"), kinds)
            made.save(FILES / name, encoding=getattr(pypcd4.Encoding, encoding))
            compare(name, program, places, colors)

        attempt(BULLET, name, program, check)


def main():
    places, colors, classes = cloud()
    for make, more in ((las_files, [classes]), (laspy_scalars, [classes]), (copc_files, []), (e57_files, []), (pcd_files, [])):
        attempt(BULLET, make.__name__, "", lambda: make(places, colors, *more))


if __name__ == "__main__":
    main()
    sys.exit(bool(WRONG))
