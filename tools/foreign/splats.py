"""Splats as splat-transform and GaussianSplats3D store them, beside the .ply that all were made of."""
import json
import struct
import sys

import numpy

from common import FILES, HERE, WRONG, attempt, gobo, node, row, scene, version

BULLET = "splats"
COUNT = 2000
FIRST = 0.28209479177387814
UNTURNED = (1, 1, 1)
ABOUT_X = (1, -1, -1)
ABOUT_Z = (-1, -1, 1)
COLUMNS = (
    ["x", "y", "z", "nx", "ny", "nz"]
    + [f"f_dc_{i}" for i in range(3)]
    + [f"f_rest_{i}" for i in range(45)]
    + ["opacity"]
    + [f"scale_{i}" for i in range(3)]
    + [f"rot_{i}" for i in range(4)]
)


def write_ply(path, columns):
    head = "".join(f"property float {name}\n" for name in COLUMNS)
    table = numpy.stack([columns[name] for name in COLUMNS], -1).astype("<f4")
    start = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(table)}\n{head}end_header\n"
    path.write_bytes(start.encode() + table.tobytes())


def read_ply(path):
    head, body = path.read_bytes().split(b"end_header\n", 1)
    names = [line.split()[2].decode() for line in head.splitlines() if line.startswith(b"property")]
    table = numpy.frombuffer(body, "<f4").reshape(-1, len(names))
    return {name: table[:, i].astype(float) for i, name in enumerate(names)}


def source():
    """Splats over ten metres, of one to thirty centimetres, with harmonics of degree 3."""
    chance = numpy.random.default_rng(5)
    columns = {name: numpy.zeros(COUNT) for name in COLUMNS}
    for name, spread in zip("xyz", (2, 1, 3)):
        columns[name] = chance.normal(size=COUNT) * spread
    for i in range(3):
        columns[f"f_dc_{i}"] = chance.normal(size=COUNT) * 0.5
        columns[f"scale_{i}"] = chance.normal(size=COUNT) * 0.7 - 3
    for i in range(45):
        columns[f"f_rest_{i}"] = chance.normal(size=COUNT) * 0.1
    columns["opacity"] = chance.normal(size=COUNT) * 2
    turns = chance.normal(size=(COUNT, 4))
    turns /= numpy.linalg.norm(turns, axis=1, keepdims=True)
    for i in range(4):
        columns[f"rot_{i}"] = turns[:, i]
    return columns


def several(columns, stem, count):
    return numpy.stack([columns[f"{stem}_{i}"] for i in range(count)], -1)


def places(columns):
    return numpy.stack([columns[axis] for axis in "xyz"], -1)


def of_quaternions(turns):
    """Rotation matrices of (w, x, y, z)."""
    w, x, y, z = (turns / numpy.linalg.norm(turns, axis=1, keepdims=True)).T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return numpy.moveaxis(numpy.array(rows), -1, 0)


def covariances(columns, turn=UNTURNED):
    axes = numpy.diag(turn) @ of_quaternions(several(columns, "rot", 4))
    axes = axes * numpy.exp(several(columns, "scale", 3))[:, None, :]
    return axes @ axes.transpose(0, 2, 1)


def colors(columns):
    return numpy.clip(0.5 + FIRST * several(columns, "f_dc", 3), 0, 1)


def opacities(columns):
    return 1 / (1 + numpy.exp(-columns["opacity"]))


def compare(path, program, truth, limits, turn=UNTURNED):
    """The splats of a file as `gobo relight` writes them without lights, beside those of the source.

    `turn`: signs of the axes, by which a converter turns what stands upside down.
    """
    dark = scene("dark", "[[light]]\nkind = 'directional'\ndirection = [0, -1, 0]\nintensity = 0\n[[material]]\nname = 'm'\n"
                 "[[shape]]\nkind = 'plane'\nmaterial = 'm'\ntranslation = [0, -100, 0]\n")
    out = HERE / "out.ply"
    gobo("relight", path, "--scene", dark, "-o", out)
    read = read_ply(out)
    there, here = places(truth) * turn, places(read)
    apart = numpy.linalg.norm(there[:, None] - here[None], axis=-1)
    order = apart.argmin(1)
    name = str(path.relative_to(FILES))
    row(BULLET, name, program, "splats missing or doubled", COUNT - len(set(order)) + abs(len(here) - COUNT), 0)
    nearest = {key: column[order] for key, column in read.items()}
    found = {
        "place [m]": numpy.abs(places(nearest) - there).max(),
        "colour": numpy.abs(colors(nearest) - colors(truth)).max(),
        "opacity": numpy.abs(opacities(nearest) - opacities(truth)).max(),
    }
    of = covariances(truth, turn)
    size = numpy.trace(of, axis1=1, axis2=2)
    found["covariance by its trace"] = (
        numpy.abs(covariances(nearest) - of).max((1, 2)) / size
    ).max()
    count = sum(key.startswith("f_rest") for key in read) // 3
    if count and turn == UNTURNED:
        kept = [f"f_rest_{channel * 15 + i}" for channel in range(3) for i in range(count)]
        off = [nearest[f"f_rest_{i}"] - truth[key] for i, key in enumerate(kept)]
        found["harmonics, root mean square"] = float(numpy.sqrt(numpy.mean(numpy.square(off))))
    for what, error in found.items():
        row(BULLET, name, program, what, error, limits[what])


def container(spz, path, count=0):
    """A glTF file around an SPZ file, after KHR_gaussian_splatting_compression_spz_2, in a form that the source of a writer shows:
    of spz2glb, without attributes, or, with the `count` of splats, of Cesium's sample converter, by the draft's name and with
    accessors that have no view."""
    names = ["KHR_gaussian_splatting", "KHR_gaussian_splatting_compression_spz_2"]
    inner = names[1].removesuffix("_2") if count else names[1]
    view = {"bufferView": 0}
    splats = {"extensions": {inner: view}}
    if not count:
        version, compression = (4, "none") if spz.startswith(b"NGSP") else (3, "gzip")
        view |= {"spzVersion": version, "compression": compression, "coordinateSystem": 0}
        splats |= {"kernel": "ellipse", "colorSpace": "srgb_rec709_display", "sortingMethod": "cameraDistance", "projection": "perspective"}
    placeholders = {"POSITION": "VEC3", "COLOR_0": "VEC4", f"{names[0]}:ROTATION": "VEC4", f"{names[0]}:SCALE": "VEC3"} if count else {}
    body = spz + b"\0" * (-len(spz) % 4)
    gltf = {
        "asset": {"version": "2.0"},
        "extensionsUsed": names,
        "extensionsRequired": names,
        "buffers": [{"byteLength": len(body)}],
        "bufferViews": [{"buffer": 0, "byteLength": len(spz)}],
        "meshes": [{"primitives": [{
            "mode": 0,
            "attributes": {name: index for index, name in enumerate(placeholders)},
            "extensions": {names[0]: splats},
        }]}],
        "nodes": [{"mesh": 0}],
        "scenes": [{"nodes": [0]}],
        "scene": 0,
    }
    if count:
        kind = {"COLOR_0": 5121}
        gltf["accessors"] = [
            {"componentType": kind.get(name, 5126), "count": count, "type": of} for name, of in placeholders.items()
        ]
    text = json.dumps(gltf).encode()
    text += b" " * (-len(text) % 4)
    head = struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(body))
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(body), b"BIN\0") + body
    path.write_bytes(head + chunks)


# Steps of a format's numbers, from its description: half of one, or all of it where the program cuts off.
def limits(place, colour, opacity, covariance, harmonics=0.0):
    named = {"place [m]": place, "colour": colour, "opacity": opacity, "covariance by its trace": covariance}
    return {**named, "harmonics, root mean square": harmonics}


BYTE = 1 / 255 + 1e-4
EXACT = limits(1e-6, 1e-6, 1e-5, 1e-5, 1e-6)
# Beside splat-transform's own reading, which its code books make differ from the source.
SOG = limits(1e-5, 1e-5, 1e-5, 1e-5, 1e-5)
# 11, 10 and 11 bits of places and deviations in bounds of 256 splats, 10 bits of rotations, 8 of the rest.
COMPRESSED = limits(0.01, BYTE, BYTE, 0.02, 0.02)
# 4096ths of a metre, 16ths of a logarithm, 8 bits of colours and opacities, 9 of rotations.
SPZ = limits(2e-4, 0.008, BYTE, 0.08)
# Colours and opacities in bytes. Floats, then halves of deviations and rotations, and 16 bits of 5 m around a centre,
# then bytes of harmonics.
KSPLAT = [limits(1e-6, BYTE, BYTE, 1e-5, 1e-6), limits(1e-4, BYTE, BYTE, 0.003, 1e-4), limits(1e-4, BYTE, BYTE, 0.003, 0.005)]


def main():
    truth = source()
    ply = FILES / "source.ply"
    write_ply(ply, truth)
    # Singles, as all programs have read them.
    truth = read_ply(ply)
    attempt(BULLET, "source.ply", "numpy", lambda: compare(ply, "numpy", truth, EXACT))
    tool = HERE / "node_modules/@playcanvas/splat-transform/bin/cli.mjs"
    program = f"splat-transform {version('@playcanvas/splat-transform')}"

    def convert(*arguments):
        node(tool, "-w", "-q", "-g", "cpu", *arguments)

    for name, steps, turn, more in [
        ("small.compressed.ply", COMPRESSED, UNTURNED, []),
        ("v4.spz", SPZ, ABOUT_X, []),
        ("v3.spz", SPZ, ABOUT_X, ["--spz-version", "3"]),
        ("splats.glb", EXACT, ABOUT_Z, []),
    ]:
        path = FILES / name

        def check(path=path, steps=steps, turn=turn, more=more):
            convert(*more, ply, path)
            compare(path, program, truth, steps, turn)

        attempt(BULLET, name, program, check)

    def back(*sources):
        """What splat-transform reads."""
        convert(*sources, FILES / "back.ply")
        return read_ply(FILES / "back.ply")

    def bundled(path, source):
        source.parent.mkdir(exist_ok=True)
        convert(ply, source)
        compare(path, program, back(source), SOG)

    attempt(BULLET, "sog/meta.json", program, lambda: bundled(FILES / "sog/meta.json", FILES / "sog/meta.json"))
    attempt(BULLET, "sog", program, lambda: bundled(FILES / "sog", FILES / "sog/meta.json"))
    attempt(BULLET, "bundle.sog", program, lambda: bundled(FILES / "bundle.sog", FILES / "bundle.sog"))

    def streamed():
        half, lod = FILES / "half.ply", FILES / "lod"
        lod.mkdir(exist_ok=True)
        convert(ply, "--decimate", "50%", half)
        convert(ply, "-l", "0", half, "-l", "1", lod / "lod-meta.json", "-C", "1")
        compare(lod / "lod-meta.json", program, back(*sorted(lod.glob("0_*/meta.json"))), SOG)
        for level, count in ((0, COUNT), (1, COUNT // 2)):
            place = scene(f"level{level}", f"[[splats]]\nfile = 'lod/lod-meta.json'\nlod = {level}\n")
            # One line of JSON, after messages.
            said = gobo("render", place, "--json", "--set", "camera.size=[16,9]", "-o", HERE / "out")
            line = next(line for line in said.splitlines() if line.startswith("{"))
            off = abs(json.loads(line)["casters"] - count)
            row(BULLET, f"lod/lod-meta.json, level {level}", program, "splats too many or few", off, 0)

    attempt(BULLET, "lod/lod-meta.json", program, streamed)
    program = f"GaussianSplats3D {version('@mkkellogg/gaussian-splats-3d')}"
    attempt(BULLET, "*.ksplat", program, lambda: node("splats.mjs", ply, FILES))
    for level, steps in enumerate(KSPLAT):
        path = FILES / f"level{level}.ksplat"
        attempt(BULLET, path.name, program, lambda: compare(path, program, truth, steps))
    for name, form, count in (("v3", "spz2glb", 0), ("v4", "spz2glb", 0), ("v3", "Cesium", len(truth["x"])), ("v4", "Cesium", len(truth["x"]))):
        path = FILES / f"{name}_{form}.glb"
        container((FILES / f"{name}.spz").read_bytes(), path, count)
        said = f"SPZ by splat-transform, glTF in the form of {form}"
        attempt(BULLET, path.name, said, lambda: compare(path, said, truth, SPZ, ABOUT_X))


if __name__ == "__main__":
    main()
    sys.exit(bool(WRONG))
