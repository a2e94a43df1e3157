//! A frame of gobo's without wgpu and without gobo: what `gobo export --target spirv --scene SCENE -o DIR`
//! wrote is all that it reads. It runs the frame on both tiers and in all profiles, and fails where a
//! texel's bits are not those of gobo's own maps.
//!
//! `cargo run -- DIR`, or `make ash` in the repository.
mod formula;
mod frame;
mod kernel;
mod vulkan;

use frame::{Frame, Kernels, MAPS};
use kernel::Resource;
use serde_json::Value;
use std::path::{Path, PathBuf};
use vulkan::{Image, Vulkan};

pub type Failure = Box<dyn std::error::Error>;

fn main() -> Result<(), Failure> {
    let dir: PathBuf = std::env::args_os().nth(1).ok_or("which folder? gobo-ash DIR")?.into();
    let [manifest, passes, frame] =
        ["manifest.json", "passes.json", "frame.json"].map(|name| json(&dir.join(name)));
    let (manifest, passes, frame) = (manifest?, passes?, frame?);
    let vulkan = Vulkan::new()?;
    println!("on {}", vulkan.name);
    let (mut differing, kernels) = (0, Kernels::default());
    for tier in ["core", "native"] {
        let expected = &frame["maps"][tier];
        if expected.is_null() {
            println!("{tier}: the device that exported had none");
            continue;
        }
        for profile in passes["profiles"].as_array().into_iter().flatten() {
            for all in [false, true] {
                let run = Frame {
                    vulkan: &vulkan,
                    dir: &dir,
                    manifest: &manifest,
                    passes: &passes,
                    frame: &frame,
                    tier,
                    profile,
                    all,
                    kernels: &kernels,
                };
                let maps = run.run()?;
                let steps = if all { "every step" } else { "the steps it needs" };
                for name in MAPS {
                    let Some(file) = expected[name].as_str() else { continue };
                    let Resource::Image(image) = maps[name] else { continue };
                    let wanted = read(&dir.join(file))?;
                    let got = vulkan.read_image(&image)?;
                    let (different, texels) =
                        compare(&passes, &frame, &dir, &image, &got, &wanted)?;
                    // The comparison sees a bit.
                    let mut wrong = got.clone();
                    wrong.iter_mut().for_each(|byte| *byte ^= 1);
                    let seen = compare(&passes, &frame, &dir, &image, &wrong, &got)?;
                    assert_eq!(seen, (texels, texels));
                    let profile = profile["name"].as_str().unwrap_or_default();
                    println!(
                        "{tier:6} {profile:6} {steps}: {name}: {different} of {texels} texels differ"
                    );
                    differing += different;
                }
            }
        }
    }
    if differing > 0 {
        return Err(format!("{differing} texels differ").into());
    }
    Ok(())
}

fn read(path: &Path) -> Result<Vec<u8>, Failure> {
    Ok(std::fs::read(path).map_err(|error| format!("{}: {error}", path.display()))?)
}

fn json(path: &Path) -> Result<Value, Failure> {
    Ok(serde_json::from_slice(&read(path)?)?)
}

/// How many texels of the views differ, of how many. Between the views an atlas holds anything.
fn compare(
    passes: &Value,
    frame: &Value,
    dir: &Path,
    image: &Image,
    got: &[u8],
    wanted: &[u8],
) -> Result<(usize, usize), Failure> {
    if got.len() != wanted.len() {
        return Err(format!("{} bytes instead of {}", got.len(), wanted.len()).into());
    }
    let view_struct = &passes["structs"]["GpuView"];
    let stride = view_struct["size"].as_u64().unwrap_or(1) as usize;
    let fields = view_struct["fields"].as_array().ok_or("GpuView has no fields")?;
    let offset = |name: &str| -> Result<usize, Failure> {
        let field = fields.iter().find(|field| field["name"] == name);
        let offset = field.and_then(|field| field["offset"].as_u64());
        Ok(offset.ok_or_else(|| format!("GpuView has no {name}"))? as usize)
    };
    let (size_at, origin_at, layer_at) = (offset("size")?, offset("origin")?, offset("layer")?);
    let [width, height, layers] = image.size.map(|edge| edge as usize);
    // Of a curve, each view has several.
    let per_view = layers / frame["numbers"]["layers"].as_u64().unwrap_or(1).max(1) as usize;
    let texel = image.format.bytes as usize;
    let (mut different, mut texels) = (0, 0);
    for batch in frame["batches"].as_array().into_iter().flatten() {
        let file = batch["uploads"]["views"].as_str().ok_or("a batch has no views")?;
        for view in read(&dir.join(file))?.chunks_exact(stride) {
            let word = |at: usize| [view[at], view[at + 1], view[at + 2], view[at + 3]];
            let whole = |at| u32::from_le_bytes(word(at)) as usize;
            let edge = |at| f32::from_le_bytes(word(at)) as usize;
            let (x, y) = (whole(origin_at), whole(origin_at + 4));
            let [across, down] = [edge(size_at), edge(size_at + 4)];
            let first = whole(layer_at) * per_view;
            for (layer, row) in (first..first + per_view)
                .flat_map(|layer| (y..y + down).map(move |row| (layer, row)))
            {
                let start = ((layer * height + row) * width + x) * texel;
                let range = start..start + across * texel;
                let pairs =
                    got[range.clone()].chunks_exact(texel).zip(wanted[range].chunks_exact(texel));
                texels += across;
                different += pairs.filter(|(a, b)| a != b).count();
            }
        }
    }
    if texels == 0 {
        return Err("nothing was compared".into());
    }
    Ok((different, texels))
}
