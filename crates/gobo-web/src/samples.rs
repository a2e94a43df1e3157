//! Files and native pictures for the test in the browser: `samples FOLDER WIDTH HEIGHT` writes a file of each
//! kind that visitors drop, and `expected.js`: the picture of each, and of the page's own scene, drawn by a
//! native device.
#[cfg(not(target_arch = "wasm32"))]
#[path = "../../../tests/common/splats.rs"]
#[allow(dead_code, reason = "tests write more kinds of files")]
mod splats;
#[cfg(not(target_arch = "wasm32"))]
#[path = "../../../tests/common/vdb.rs"]
#[allow(dead_code, reason = "tests write more kinds of files")]
mod vdb;

#[cfg(not(target_arch = "wasm32"))]
mod native {
    use super::{
        splats::{self, Stored},
        vdb::{Format, VdbGrid, file, scaled},
    };
    use gobo::{Gpu, Scene, Shadows, glam::IVec3};
    use gobo_scene as scene;
    use gobo_web::{Knobs, Show, picture, stained_glass};
    use std::{error::Error, fmt::Write as _, fs, path::Path};

    /// A ring of coloured splats.
    fn ring() -> Vec<Stored> {
        let splat = |i: u32| {
            let angle = f64::from(i) * std::f64::consts::TAU / 48.0;
            let (sine, cosine) = angle.sin_cos();
            let hue = |shift: f64| 0.5 + 0.45 * (angle + shift).cos();
            Stored {
                center: [cosine, 0.8 + 0.4 * (3.0 * angle).sin(), sine],
                sigma: [0.05, 0.16, 0.03],
                rotation: [(0.5 * angle).cos(), 0.0, (0.5 * angle).sin(), 0.0],
                opacity: 0.75,
                color: [hue(0.0), hue(2.1), hue(4.2)],
            }
        };
        (0..48).map(splat).collect()
    }

    /// A ball of fog.
    fn fog() -> Vec<u8> {
        let mut grid = VdbGrid { transform: scaled(0.08), ..VdbGrid::default() };
        for z in -12..12 {
            for y in -12..12 {
                for x in -12..12 {
                    let voxel = IVec3::new(x, y, z);
                    let away = voxel.as_vec3().length() / 12.0;
                    if away < 1.0 {
                        grid.set(voxel, 3.0 * (1.0 - away));
                    }
                }
            }
        }
        file(Format::default(), &[grid])
    }

    /// Particles as simulations write them.
    fn particles() -> String {
        let mut text = "ply\nformat ascii 1.0\nelement vertex 200\n".to_owned();
        for name in ["x", "y", "z", "radius", "red", "green", "blue", "alpha"] {
            let _ = writeln!(text, "property float {name}");
        }
        text += "end_header\n";
        for i in 0..200_u8 {
            let (angle, height) = (f32::from(i) * 2.4, f32::from(i) / 200.0);
            let (sine, cosine) = angle.sin_cos();
            let far = 0.2 + 0.8 * height;
            let _ = writeln!(
                text,
                "{} {} {} 0.12 {} {} {} 0.5",
                far * cosine,
                0.2 + 1.6 * height,
                far * sine,
                0.9 - 0.8 * height,
                0.3 + 0.2 * sine,
                0.2 + 0.7 * height
            );
        }
        text
    }

    /// Edge of a map \[texels\].
    const EDGE: u32 = 128;

    fn files() -> Result<[(&'static str, Vec<u8>); 6], Box<dyn Error>> {
        let glass = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/gallery/wine_glass.glb");
        Ok([
            ("particles.ply", particles().into_bytes()),
            ("splats.ply", splats::ply("binary_little_endian", &ring(), 0)),
            ("ring.spz", splats::spz(3, &ring())),
            ("ring.sog", splats::sog(&ring())),
            ("glass.glb", fs::read(glass)?),
            ("fog.vdb", fog()),
        ])
    }

    /// Halves of red, green and blue of a scene's first map, row by row.
    fn first_map(gpu: &Gpu, show: &mut Show) -> Result<Vec<u16>, Box<dyn Error>> {
        show.set_most_texels(EDGE);
        let maps = show.shade_maps(&Knobs::default())?.maps().clone();
        let size = show.map_views()[0].size;
        let slot = &maps.slots[0];
        let texels: Vec<[u16; 4]> = gpu.read_texture(&maps.filters);
        let edge = maps.filters.width();
        let row = |y: u32| {
            let first =
                (slot.layer * maps.filters.height() + slot.origin[1] + y) * edge + slot.origin[0];
            texels[first as usize..(first + size.x) as usize]
                .iter()
                .flat_map(|texel| &texel[..3])
                .copied()
        };
        Ok((0..size.y).flat_map(row).collect())
    }

    pub(super) fn main() -> Result<(), Box<dyn Error>> {
        let arguments: Vec<String> = std::env::args().skip(1).collect();
        let (folder, picture_size) = match &arguments[..] {
            [folder] => (folder, None),
            [folder, width, height] => (folder, Some([width.parse()?, height.parse()?])),
            _ => return Err("samples FOLDER [WIDTH HEIGHT]".into()),
        };
        let folder = Path::new(folder);
        fs::create_dir_all(folder)?;
        let gpu = Gpu::headless()?;
        let shadows = Shadows::new(&gpu.device, &gpu.queue, &gpu.adapter)?;
        let mut module = format!("export const EDGE = {EDGE};\nexport default {{\n");
        let mut add = |name: &str, scene: Scene| -> Result<(), Box<dyn Error>> {
            let mut show = Show::new(&gpu.device, &gpu.queue, shadows.another(), scene)?;
            if let Some(size) = picture_size {
                // As the page does on software adapters.
                show.set_most_texels(512);
                let on = (&gpu.device, &gpu.queue);
                let knobs = Knobs::default();
                let shown = pollster::block_on(picture(on, &mut show, size, &knobs))?;
                writeln!(module, "{name:?}: {shown:?},")?;
            } else {
                writeln!(module, "{name:?}: {:?},", first_map(&gpu, &mut show)?)?;
            }
            Ok(gpu.check()?)
        };
        if picture_size.is_some() {
            add("stained glass", stained_glass()?)?;
        }
        for (name, bytes) in files()? {
            let path = folder.join(name);
            fs::write(&path, bytes)?;
            add(name, scene::load(&path)?)?;
        }
        let name = if picture_size.is_some() { "expected.js" } else { "maps.js" };
        fs::write(folder.join(name), module + "};\n")?;
        Ok(())
    }
}

#[cfg(not(target_arch = "wasm32"))]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    native::main()
}

#[cfg(target_arch = "wasm32")]
fn main() {}
