"""Models and skies as three.js, Babylon.js, glTF Transform, Blender and OpenEXR write them, beside closed forms."""
import subprocess
import sys

import numpy

from common import FILES, GOBO, HERE, WRONG, attempt, gobo, maps, node, row, scene, texels, version
from volumes import package

BULLET = "glass and models"
COLOR = numpy.array([0.9, 0.6, 0.3])
# Light of maps: 16 bits and rounding of the exponent.
LIGHT = 1e-3
# Rays at the rim of a ball land metres away: light is counted up to here [m].
LANDED = 2.5
SUN = """
[[light]]
name = "sun"
kind = "directional"
direction = [0, -1, 0]
size = {size}
{more}
[shadow]
receiver = "nearest"
"""
GROUND = """
[[material]]
name = "ground"
transfer = "opaque"
[[shape]]
kind = "plane"
material = "ground"
scale = [{width}, 1, {width}]
translation = [0, {height}, 0]
"""


def sunlit(name, mesh="", size=128, more="", ground=""):
    path = scene("model_" + name.replace(".", "_"), f"[[mesh]]\nfile = '{name}'\n{mesh}\n" + SUN.format(size=size, more=more) + ground)
    return maps(path)


def inner(view, half):
    """Texels within a square around the y axis."""
    points, _ = texels(view)
    return numpy.abs(points[..., [0, 2]]).max(-1) < half


def flat(name, program, what, truth, mesh=""):
    """The colour of the shadow of a square or a block of one metre, from above."""

    def check():
        [(view, arrays)], _ = sunlit(name, mesh)
        error = numpy.abs(arrays["filter"][inner(view, 0.45)] - truth).max()
        row(BULLET, name, program, what, error, LIGHT)

    attempt(BULLET, name, program, check)


def face(index):
    return ((index - 1) / (index + 1)) ** 2


def through_ball(index, radius, floor, rays=20000):
    """Where light straight down lands below a ball at the origin, by the distance of rays from its axis; the light of each."""
    off = (numpy.arange(rays) + 0.5) / rays * radius
    start = numpy.sqrt(radius**2 - off**2)
    # In the plane of the axis and the ray: (aside, up).
    ray, place = numpy.array([numpy.zeros(rays), -numpy.ones(rays)]), numpy.array([off, start])
    normal = place / radius
    reflected = 1
    for ratio, sign in ((1 / index, 1), (index, -1)):
        facing = normal * sign
        cosine = -(ray * facing).sum(0)
        rest = numpy.sqrt(1 - ratio**2 * (1 - cosine**2))
        ray = ray * ratio + facing * (ratio * cosine - rest)
        if sign > 0:
            place = place - ray * 2 * (ray * place).sum(0)
            normal = place / radius
    # The maps' reflections are those of the straight ray, twice at its angle of incidence.
    cosine = start / radius
    inside = numpy.sqrt(1 - (1 - cosine**2) / index**2)
    across, along = (cosine - index * inside) / (cosine + index * inside), (index * cosine - inside) / (index * cosine + inside)
    passed = (1 - (across**2 + along**2) / 2) ** 2
    landed = place[0] + ray[0] * (-floor - place[1]) / ray[1]
    return numpy.abs(landed), passed * off


def ball(name, program, index, dispersion):
    """Mean distances from the axis at which red, green and blue light land."""

    def check():
        radius, floor = 0.5, 2.0
        ground = GROUND.format(width=6, height=-floor)
        [(view, arrays)], _ = sunlit(name, size=1024, more="caustics = 2", ground=ground)
        points, _ = texels(view)
        distance = numpy.hypot(points[..., 0], points[..., 2])
        found, wanted = [], []
        for channel in range(3):
            light = arrays["caustics"][..., channel]
            near = distance < LANDED
            found.append((light * distance)[near].sum() / light[near].sum())
            bent = index + (channel - 1) * (index - 1) * dispersion / 40
            landed, weight = through_ball(bent, radius, floor)
            near = landed < LANDED
            wanted.append((landed * weight)[near].sum() / weight[near].sum())
        for channel, (here, there) in zip(("red", "green", "blue"), zip(found, wanted)):
            row(BULLET, name, program, f"{channel} light lands at {there:.4f} m on average, share", abs(here / there - 1), 0.02)
        apart = (found[2] - found[0]) / (wanted[2] - wanted[0])
        row(BULLET, name, program, "blue minus red, share", abs(apart - 1), 0.05)

    attempt(BULLET, name, program, check)


def glass():
    node("glass.mjs", FILES)
    three, babylon = (f"{name} {version(of)}" for name, of in (("three.js", "three"), ("Babylon.js", "@babylonjs/serializers")))
    transform = f"glTF Transform {version('@gltf-transform/core')}"
    ball("three_ball.glb", three, 1.6, 2)
    ball("three_ball_usual.glb", three, 1.5, 2)
    ball("babylon_ball.glb", babylon, 1.6, 2)
    # Two faces, and 0.8 m of which 0.5 m transmit the colour.
    block = (1 - face(1.7)) ** 2 * COLOR ** (0.8 / 0.5)
    flat("three_block.glb", three, "Fresnel and absorption", block)
    flat("babylon_block.glb", babylon, "Fresnel and absorption", block)
    pane = (1 - face(1.7)) / (1 + face(1.7))
    flat("three_pane.glb", three, "Fresnel of a thin pane", pane)
    flat("transform_pane.glb", transform, "Fresnel of a thin pane", pane)
    leaf = 0.75 * numpy.array([0.4, 0.8, 0.1])
    flat("babylon_leaf.glb", babylon, "diffuse transmission", leaf)
    flat("transform_leaf.glb", transform, "diffuse transmission", leaf)
    # Coverage of a half, then the half of what is left: (1 - a)(1 - a (1 - c)).
    for variant, color in (("day", [1, 0.5, 0]), ("night", [0, 0.25, 1])):
        truth = 0.5 * (1 - 0.5 * (1 - numpy.array(color)))
        flat("transform_variants.glb", transform, f"variant {variant}", truth, f"variant = '{variant}'")

    def hidden():
        [(view, arrays)], said = sunlit("transform_hidden.glb")
        top = texels(view)[0][0, 0, 1] - arrays["opaque"][inner(view, 0.45)] * (view["far"] - view["near"])
        row(BULLET, "transform_hidden.glb", transform, "height of what is seen [m]", numpy.abs(top).max(), 1e-3)

    attempt(BULLET, "transform_hidden.glb", transform, hidden)


BLENDER = """
import bpy, sys
bpy.ops.wm.read_factory_settings(use_empty=True)
boxes = [((-1, 0, .2), (1, .6, .4), (.8, .1, .1)), ((.5, .5, .5), (.8, .8, 1), (.1, .7, .2)), ((.5, -1, .35), (1.2, .5, .7), (.2, .3, .9))]
for place, size, color in boxes:
    bpy.ops.mesh.primitive_cube_add(size=1, location=place)
    box = bpy.context.object
    box.scale = size
    material = bpy.data.materials.new(f'color {len(bpy.data.materials)}')
    material.use_nodes = True
    material.node_tree.nodes['Principled BSDF'].inputs['Base Color'].default_value = (*color, 1)
    box.data.materials.append(material)
    colors = box.data.color_attributes.new('Col', 'FLOAT_COLOR', 'POINT')
    for point in colors.data:
        point.color = (*color, 1)
bpy.ops.wm.obj_export(filepath=sys.argv[-1] + '/blender.obj')
bpy.ops.wm.ply_export(filepath=sys.argv[-1] + '/blender.ply', forward_axis='NEGATIVE_Z', up_axis='Y')
bpy.ops.export_scene.gltf(filepath=sys.argv[-1] + '/blender.glb')
bpy.ops.wm.usd_export(filepath=sys.argv[-1] + '/blender.usdc')
bpy.ops.export_scene.fbx(filepath=sys.argv[-1] + '/blender.fbx')
print(bpy.app.version_string)
"""
BOXES = [((-1, 0, 0.2), (1, 0.6, 0.4), (0.8, 0.1, 0.1)), ((0.5, 0.5, 0.5), (0.8, 0.8, 1), (0.1, 0.7, 0.2)), ((0.5, -1, 0.35), (1.2, 0.5, 0.7), (0.2, 0.3, 0.9))]


def blender():
    script = FILES / "blender.py"
    script.write_text(BLENDER)
    made = subprocess.run([sys.executable, script, FILES], capture_output=True, text=True, check=True)
    program = f"Blender {made.stdout.strip().splitlines()[-1]}"
    for name in ("blender.obj", "blender.ply", "blender.glb"):
        attempt(BULLET, name, program, lambda: boxes(name, program))
    for name in ("blender.usdc", "blender.fbx"):
        said = subprocess.run([GOBO, "render", FILES / name, "-o", HERE / "out"], capture_output=True, text=True, check=False)
        right = said.returncode == 2 and "glTF" in said.stderr
        row(BULLET, name, program, "not refused by the way through glTF", float(not right), 0)


def boxes(name, program):
    """Heights of three boxes from above, and their colours in the picture's layer."""
    import OpenEXR

    [(view, arrays)], _ = sunlit(name, size=256, more="near = -5\nfar = 5")
    points, _ = texels(view)
    # Blender's (x, y, z) is (x, z, -y).
    tops = numpy.zeros(points.shape[:2])
    edge = numpy.zeros(points.shape[:2], bool)
    for (x, y, z), (wide, deep, high), _ in BOXES:
        off = numpy.maximum(numpy.abs(points[..., 0] - x) - wide / 2, numpy.abs(points[..., 2] + y) - deep / 2)
        tops = numpy.where(off < 0, z + high / 2, tops)
        edge |= numpy.abs(off) < 0.05
    seen = points[..., 1] - arrays["opaque"] * (view["far"] - view["near"])
    on_box = (tops > 0) & ~edge
    row(BULLET, name, program, "height of boxes [m]", numpy.abs(seen - tops)[on_box].max(), 1e-3)
    row(BULLET, name, program, "boxes beside them", float((arrays["opaque"] < 1)[(tops == 0) & ~edge].sum()), 0)
    out = HERE / "out" / name
    path = FILES / f"model_{name.replace('.', '_')}.toml"
    gobo("render", path, "--exr", "--layers", "-o", out, "--set", "camera.size=[160,120]", "--set", "camera.samples=1",
         "--set", "camera.eye=[0.001,6,0]", "--set", "camera.target=[0,0,0]")
    picture = OpenEXR.File(str(out / "frame_0000.exr"), separate_channels=True).channels()
    albedo = numpy.stack([picture[f"albedo.{channel}"].pixels for channel in "RGB"], -1)
    shown = albedo[picture["depth.Z"].pixels < 1e9]
    # Blender cuts sRGB to bytes in PLY: a step is .0086 near a linear 0.9.
    apart = numpy.abs(shown[:, None] - numpy.array([color for *_, color in BOXES])[None]).max(-1)
    row(BULLET, name, program, "albedo", apart.min(1).max(), 0.009)
    row(BULLET, name, program, "colours missing", 3 - len(set(apart.argmin(1))), 0)


def sky():
    """A sky of which the upper half is bright: a white floor sends its radiance, by harmonics of order 2 exactly."""
    import OpenEXR

    program = package("OpenEXR")
    light = numpy.array([1.0, 0.5, 0.25])
    pixels = numpy.zeros((128, 256, 3), "f4")
    pixels[:64] = light
    for name, packing in (("zip.exr", OpenEXR.ZIP_COMPRESSION), ("piz.exr", OpenEXR.PIZ_COMPRESSION), ("none.exr", OpenEXR.NO_COMPRESSION)):

        def check(name=name, packing=packing):
            head = {"compression": packing, "type": OpenEXR.scanlineimage}
            with OpenEXR.File(head, {"RGB": pixels}) as file:
                file.write(str(FILES / name))
            path = scene("sky_" + name.replace(".", "_"), f"""
[camera]
eye = [0, 4, 0.01]
target = [0, 0, 0]
size = [16, 16]
samples = 1
occlusion = false
[environment]
file = "{name}"
[[light]]
kind = "directional"
direction = [0, -1, 0]
intensity = 0
[[material]]
name = "white"
transfer = "opaque"
roughness = 1
[[shape]]
kind = "plane"
material = "white"
scale = [40, 1, 40]
""")
            out = HERE / "out" / name
            gobo("render", path, "--exr", "-o", out)
            shown = OpenEXR.File(str(out / "frame_0000.exr"), separate_channels=True).channels()
            found = numpy.stack([shown[channel].pixels for channel in "RGB"], -1).reshape(-1, 3).astype(float)
            # 4 % of the light is mirrored head-on, in the same colours; a texel of the sky is 1.4 degrees high.
            row(BULLET, name, program, "light of a white floor, share", numpy.abs(found / light - 1).max(), 0.02)

        attempt(BULLET, name, program, check)


def main():
    for make in (glass, blender, sky):
        attempt(BULLET, make.__name__, "", make)


if __name__ == "__main__":
    main()
    sys.exit(bool(WRONG))
