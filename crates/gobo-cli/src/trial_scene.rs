//! The scene of `gobo info --try`: casters of all kinds under lights of all kinds, with curves.

pub(super) const SCENE: &str = r#"
[camera]
eye = [2.9, 2.35, 4.1]
target = [0.05, 0.75, 0.1]
size = [96, 64]
samples = 1

[shadow]
detail = false
size = 64
receiver = "curve"
nodes = 8

[environment]
ambient = [0.16, 0.18, 0.22]
background = [0.42, 0.52, 0.68]

[[light]]
name = "sun"
kind = "directional"
direction = [0.43, -0.95, 0.37]
intensity = 2.2

[[light]]
name = "spot"
kind = "spot"
position = [2.9, 3.1, 1.7]
direction = [-0.8, -0.75, -0.4]
angle = 51
color = [1, 0.7, 0.4]
intensity = 24

[[light]]
name = "lamp"
kind = "point"
position = [-1.45, 2.15, 1.3]
color = [0.5, 0.7, 1]
intensity = 9
size = 32

[[material]]
name = "solid"
transfer = "opaque"
tint = [0.7, 0.68, 0.62, 1]

[[material]]
name = "dots"
transfer = "dither"
tint = [0.4, 0.6, 0.5, 0.5]

[[material]]
name = "smoke"
transfer = "smoke"
tint = [0.6, 0.66, 0.9, 0.09]

[[material]]
name = "squares"
shape = "quad"
profile = "flat"
transfer = "stain"
tint = [0.9, 0.8, 0.4, 0.1]

[[material]]
name = "puffs"
shape = "puff"
tint = [0.3, 0.8, 0.9, 0.4]

[[material]]
name = "rose"
tint = [0.95, 0.3, 0.45, 0.85]
transmission = 1

[[material]]
name = "amber"
attenuation_color = [0.95, 0.55, 0.1]
attenuation_distance = 0.5

[[material]]
name = "hair"
transfer = "filter"
tint = [0.3, 0.2, 0.1, 0.9]

[[shape]]
kind = "plane"
material = "solid"
scale = [9, 1, 9]

[[shape]]
kind = "box"
material = "solid"
translation = [0.95, 0.3, -0.85]
rotation = [0, 31, 0]
scale = [0.6, 0.6, 0.6]

[[shape]]
name = "head"
kind = "sphere"
material = "solid"
level = 3
translation = [-0.95, 0.37, -0.35]
scale = [0.7, 0.7, 0.7]

[[shape]]
kind = "pane"
material = "dots"
translation = [-1.7, 0.62, 0.35]
rotation = [0, 63, 0]
scale = [0.8, 1.1, 1]

[[shape]]
kind = "pane"
material = "rose"
translation = [1.3, 0.57, 0.52]
rotation = [3, -41, 0]
scale = [0.8, 1.1, 1]

[[shape]]
kind = "sphere"
material = "amber"
level = 3
translation = [0.25, 0.43, 0.95]
scale = [0.75, 0.75, 0.75]

[[particles]]
generate = { kind = "cloud", count = 300, seed = 3, center = [0.15, 1.35, 0.2], extent = [2.2, 0.9, 1.6], radius = 0.13 }
material = "smoke"

[[particles]]
generate = { kind = "dust", count = 60, seed = 5, min = [-1.3, 0.9, -1.1], max = [1.2, 1.9, 0.9], radius = 0.09 }
material = "squares"

[[particles]]
generate = { kind = "dust", count = 20, seed = 7, min = [-0.8, 0.3, -1.3], max = [0.9, 1.4, 0.2], radius = 0.16 }
material = "puffs"

[[splats]]
generate = { kind = "cloud", count = 80, seed = 12, center = [-0.35, 0.95, 0.75], extent = [0.9, 0.7, 0.7], radius = 0.1 }
cast = "own"

[[splats]]
generate = { kind = "smoke", count = 60, seed = 6, base = [1.7, 0, -0.4], height = 1.5, spread = 0.25, radius = 0.14 }
opacity = "medium"
density = 6

[[strands]]
generate = { kind = "fur", on = "head", count = 120, segments = 3, length = 0.22, radius = 0.012, droop = 0.3, seed = 2 }
material = "hair"

[[volume]]
generate = { kind = "cloud", seed = 3, size = [0.9, 0.5, 0.7], voxels = 24 }
density = { factor = 9 }
translation = [0.7, 1.75, -0.5]
"#;
