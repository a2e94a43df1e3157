"""Volumes as numpy, pynrrd, nibabel, SimpleITK, VTK, tifffile, Debian's OpenVDB and NanoVDB store them, beside sums of numpy."""
import importlib.metadata
import subprocess
import sys

import numpy

from common import FILES, WRONG, attempt, maps, row, run, scene, texels

BULLET = "volumes"
# Voxels along x, y and z, all different so that no axis can be taken for another.
SIZE = (15, 12, 9)
# Densities are stored as halves: 11 bits of an optical depth of at most 3, and 2^-12 more of the light by
# the product of bricks.
LIMIT = 2e-3


def voxels():
    """Values from 0 to 250, by `[x, y, z]`, with empty regions."""
    chance = numpy.random.default_rng(8)
    values = chance.integers(0, 251, SIZE)
    return numpy.where(chance.random(SIZE) < 0.3, 0, values)


def transmitted(values, factor, to_world, view):
    """Light behind trilinear voxels along an axis of the world, for each texel of a map.

    `to_world`: an affine 4 x 4 matrix [m] that takes voxels' axes to those of the world, up to signs.
    """
    points, direction = texels(view)
    from_world = numpy.linalg.inv(to_world)
    way = from_world[:3, :3] @ direction
    axis = int(numpy.abs(way).argmax())
    assert numpy.abs(numpy.delete(way, axis)).max() < 1e-6 * abs(way[axis]), "not along an axis"
    # A ray's integral of trilinear voxels is the bilinear mean of their columns' sums.
    sums = values.sum(axis) / abs(way[axis])
    place = points @ from_world[:3, :3].T + from_world[:3, 3]
    place = numpy.delete(place, axis, -1)
    corner = numpy.floor(place).astype(int)
    far = place - corner
    padded = numpy.pad(sums, 1)
    total = 0
    for i in (0, 1):
        for k in (0, 1):
            at = [numpy.clip(corner[..., n] + (i, k)[n] + 1, 0, padded.shape[n] - 1) for n in (0, 1)]
            weights = [far[..., n] if (i, k)[n] else 1 - far[..., n] for n in (0, 1)]
            total += padded[at[0], at[1]] * weights[0] * weights[1]
    return numpy.exp(-factor * total)


def compare(name, program, values, to_world, more="", scale=1.0):
    """Maps of suns along all three axes. `values`: by `[x, y, z]`, or by `[x, y, z, channel]` where colours differ."""
    lengths = numpy.abs(to_world[:3, :3]).max(0)
    factor = 3 / max((values.sum(axis) * lengths[axis]).max() for axis in range(3))
    channels = numpy.moveaxis(values, -1, 0) if values.ndim == 4 else [values]
    suns = "".join(
        f"[[light]]\nname = '{axis}'\nkind = 'directional'\ndirection = {way.tolist()}\nsize = 64\n"
        for axis, way in zip("xyz", numpy.eye(3))
    )
    text = (
        f"[[volume]]\nfile = '{name}'\ndensity = {{ factor = {factor * scale} }}\n{more}\n{suns}"
        "[shadow]\nreceiver = 'nearest'\n"
    )
    path = scene("volume_" + name.replace(".", "_").replace("/", "_"), text)
    worst, least = 0, 1
    for axis in "xyz":
        [(view, arrays)], _ = maps(path, axis)
        truth = numpy.stack([transmitted(one, factor, to_world, view) for one in channels], -1)
        worst = max(worst, numpy.abs(arrays["filter"] - truth).max())
        least = min(least, truth.min())
    assert least < 0.2, f"a test of no shadow: {least}"
    row(BULLET, name, program, "light of 3 x 64^2 texels", worst, LIMIT)


def matrix(columns, origin):
    whole = numpy.eye(4)
    whole[:3, :3] = numpy.stack(columns, -1)
    whole[:3, 3] = origin
    return whole


def package(name):
    return f"{name} {importlib.metadata.version(name)}"


def arrays(values):
    plain = numpy.eye(4)
    for name, array in [
        ("u1.npy", values.astype("u1")),
        ("f4_fortran.npy", numpy.asfortranarray(values.astype("f4"))),
        ("big_f8.npy", values.astype(">f8")),
    ]:
        numpy.save(FILES / name, numpy.asarray(array.T, order="F" if "fortran" in name else "C"))
        attempt(BULLET, name, package("numpy"), lambda: compare(name, package("numpy"), values, plain))
    numpy.savez_compressed(FILES / "packed.npz", other=numpy.zeros(3), density=values.T.astype("i2"))
    attempt(BULLET, "packed.npz", package("numpy"), lambda: compare("packed.npz", package("numpy"), values, plain))


def rgba_files(values):
    """Colours that differ by channel and voxel, with opacities: each channel absorbs by its colour times the opacity."""
    import nrrd

    rgba = numpy.stack([values, values[::-1], values[:, ::-1], numpy.maximum(values[:, :, ::-1], 5)], -1)
    absorbed = rgba[..., :3] / 255 * rgba[..., 3:] / 255
    name, program = "rgba_u1.npy", package("numpy")
    numpy.save(FILES / name, numpy.ascontiguousarray(rgba.astype("u1").transpose(2, 1, 0, 3)))
    attempt(BULLET, name, program, lambda name=name, program=program: compare(name, program, absorbed, numpy.eye(4)))
    name, program = "rgba_u2.nrrd", package("pynrrd")
    head = {"kinds": ["RGBA-color", "domain", "domain", "domain"], "spacings": [numpy.nan, 1, 1, 1], "encoding": "gzip"}
    nrrd.write(str(FILES / name), numpy.moveaxis(rgba, -1, 0).astype("u2") * 257, head)
    attempt(BULLET, name, program, lambda: compare(name, program, absorbed, numpy.eye(4)))


def nrrd_files(values):
    import nrrd

    axes = numpy.diag([0.5, 0.75, 1.5])
    for name, encoding in (("raw.nrrd", "raw"), ("gzip.nrrd", "gzip"), ("text.nrrd", "ascii"), ("two.nhdr", "gzip")):
        head = {"space": "left-posterior-superior", "space directions": axes, "space origin": [3.0, -4.0, 5.0], "encoding": encoding}
        nrrd.write(str(FILES / name), values.astype("i2"), head, detached_header=name.endswith(".nhdr"))
        to_world = body_axes(numpy.diag([1, 1, 1]) @ axes, numpy.array([3.0, -4.0, 5.0]))
        attempt(BULLET, name, package("pynrrd"), lambda: compare(name, package("pynrrd"), values, to_world))


def body_axes(columns, origin):
    """From left, posterior and superior [mm] to x to the left, y to the head, z to the front [m]."""
    turn = numpy.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]]) / 1000
    return matrix(list((turn @ columns).T), turn @ origin)


def nifti_files(values):
    import nibabel

    affine = numpy.diag([0.9, 1.1, 2.0, 1])
    affine[:3, 3] = [-7, 3, 11]
    for name, kind in (("plain.nii", "i2"), ("packed.nii.gz", "f4")):
        image = nibabel.Nifti1Image(values.astype(kind), affine)
        image.header.set_xyzt_units("mm")
        nibabel.save(image, FILES / name)
        # Right and anterior are the opposites of left and posterior.
        flip = numpy.diag([-1.0, -1.0, 1.0])
        to_world = body_axes(flip @ affine[:3, :3], flip @ affine[:3, 3])
        attempt(BULLET, name, package("nibabel"), lambda: compare(name, package("nibabel"), values, to_world))


def meta_files(values):
    import SimpleITK

    image = SimpleITK.GetImageFromArray(numpy.ascontiguousarray(values.T).astype("f4"))
    image.SetSpacing((0.5, 0.8, 1.25))
    image.SetOrigin((1.0, 2.0, -3.0))
    to_world = body_axes(numpy.diag([0.5, 0.8, 1.25]), numpy.array([1.0, 2.0, -3.0]))
    for name, packed in (("one.mha", False), ("packed.mha", True), ("two.mhd", True)):
        SimpleITK.WriteImage(image, str(FILES / name), packed)
        attempt(BULLET, name, package("SimpleITK"), lambda: compare(name, package("SimpleITK"), values, to_world))


def vtk_files(values):
    import vtk
    from vtk.util.numpy_support import numpy_to_vtk

    image = vtk.vtkImageData()
    image.SetDimensions(*SIZE)
    image.SetSpacing(0.1, 0.2, 0.3)
    image.SetOrigin(5, 6, 7)
    array = numpy_to_vtk(values.astype("f4").ravel(order="F"), deep=True)
    array.SetName("pressure")
    image.GetPointData().SetScalars(array)
    to_world = matrix(list(numpy.diag([0.1, 0.2, 0.3])), [5, 6, 7])
    modes = {"text": (lambda w: w.SetDataModeToAscii()), "inline": (lambda w: w.SetDataModeToBinary()), "raw": (lambda w: w.SetDataModeToAppended())}
    for mode, choose in modes.items():
        for packer in ("None", "ZLib", "LZ4"):
            name = f"{mode}_{packer}.vti"
            writer = vtk.vtkXMLImageDataWriter()
            choose(writer)
            getattr(writer, f"SetCompressorTypeTo{packer}")()
            writer.EncodeAppendedDataOff()
            writer.SetFileName(str(FILES / name))
            writer.SetInputData(image)
            writer.Write()
            attempt(BULLET, name, package("vtk"), lambda: compare(name, package("vtk"), values, to_world))


def tiff_files(values):
    import tifffile

    # Rows go down, and pages back.
    to_world = matrix([[1, 0, 0], [0, -1, 0], [0, 0, -1]], [0, 0, 0])
    for name, packing in (("plain.tif", None), ("packed.tif", "zlib")):
        tifffile.imwrite(FILES / name, values.T.astype("u2"), compression=packing, photometric="minisblack")

        def check(name=name):
            # Where the first page stands does not matter: the views tell.
            compare(name, package("tifffile"), values, to_world)

        attempt(BULLET, name, package("tifffile"), check)


VDB = """
import numpy, sys
try:
    import pyopenvdb as vdb
except ImportError:
    import openvdb as vdb
values = numpy.load(sys.argv[1]).astype('f4')
grid = vdb.FloatGrid()
grid.copyFromArray(values)
grid.name = 'density'
grid.transform = vdb.createLinearTransform(voxelSize=0.25)
vdb.write(sys.argv[2], grids=[grid])
print('.'.join(map(str, vdb.LIBRARY_VERSION)))
"""


def vdb_files(values):
    """OpenVDB by Debian's python3-openvdb, NanoVDB by its nanovdb_convert."""
    numpy.save(FILES / "voxels.npy", values)
    script = FILES / "make_vdb.py"
    script.write_text(VDB)
    made = run("/usr/bin/python3", script, FILES / "voxels.npy", FILES / "float.vdb").strip()
    program = f"OpenVDB {made.split()[-1]}"
    to_world = matrix(list(numpy.eye(3) * 0.25), [0, 0, 0])
    attempt(BULLET, "float.vdb", program, lambda: compare("float.vdb", program, values, to_world))
    shown = subprocess.run(["nanovdb_convert", "--version"], capture_output=True, text=True, check=False)
    program = f"nanovdb_convert ({(shown.stdout + shown.stderr).split(chr(10))[0].strip()})"
    kinds = {"float": [], "zip": ["-z"], "blosc": ["-b"], "fp16": ["--fp16"], "fp8": ["--fp8"], "fpN": ["--fpN", "-a", "0.1"]}
    for kind, options in kinds.items():
        name = f"{kind}.nvdb"

        def check(name=name, options=options):
            run("nanovdb_convert", "-f", *options, FILES / "float.vdb", FILES / name)
            compare(name, program, values, to_world)

        attempt(BULLET, name, program, check)


def main():
    values = voxels()
    for make in (arrays, rgba_files, nrrd_files, nifti_files, meta_files, vtk_files, tiff_files, vdb_files):
        attempt(BULLET, make.__name__, "", lambda: make(values.astype(float)))


if __name__ == "__main__":
    main()
    sys.exit(bool(WRONG))
