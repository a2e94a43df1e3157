//! A frame of gobo's without wgpu and without gobo: it reads only the output of `gobo export --target spirv
//! --scene SCENE -o DIR`. It runs the frame of each tier, and fails if a texel's bits differ from gobo's own
//! maps.
//!
//! `cargo run -- DIR`, or `make ash` in the repository.
mod frame;
mod kernel;
mod vulkan;

use frame::{Frame, each};
use serde_json::Value;
use std::path::{Path, PathBuf};
use vulkan::{Image, Vulkan};

pub type Failure = Box<dyn std::error::Error>;

fn main() -> Result<(), Failure> {
    let dir: PathBuf = std::env::args_os().nth(1).ok_or("which folder? gobo-ash DIR")?.into();
    let frames: Value = serde_json::from_slice(&read(&dir.join("frame.json"))?)?;
    let vulkan = Vulkan::new()?;
    println!("on {}", vulkan.name);
    let mut differing = 0;
    for (tier, value) in frames["tiers"].as_object().into_iter().flatten() {
        let frame = Frame::new(&vulkan, &dir, value)?;
        frame.run()?;
        for (name, map) in value["maps"].as_object().into_iter().flatten() {
            let image = frame.image(&map["resource"])?;
            let wanted = read(&dir.join(map["file"].as_str().ok_or("a map has no file")?))?;
            let got = vulkan.read_image(&image)?;
            let (different, texels) = compare(&value["views"], map, &image, &got, &wanted)?;
            // The comparison notices a single bit.
            let mut wrong = got.clone();
            wrong.iter_mut().for_each(|byte| *byte ^= 1);
            let seen = compare(&value["views"], map, &image, &wrong, &got)?;
            assert_eq!(seen, (texels, texels));
            println!("{tier:6}: {name}: {different} of {texels} texels differ");
            differing += different;
        }
    }
    if differing > 0 {
        return Err(format!("{differing} texels differ").into());
    }
    Ok(())
}

pub fn read(path: &Path) -> Result<Vec<u8>, Failure> {
    Ok(std::fs::read(path).map_err(|error| format!("{}: {error}", path.display()))?)
}

/// Number of texels of the views that differ, and their total. Between the views an atlas may hold anything.
fn compare(
    views: &Value,
    map: &Value,
    image: &Image,
    got: &[u8],
    wanted: &[u8],
) -> Result<(usize, usize), Failure> {
    if got.len() != wanted.len() {
        return Err(format!("{} bytes instead of {}", got.len(), wanted.len()).into());
    }
    let whole = |value: &Value| value.as_u64().unwrap_or_default() as usize;
    let [width, height, _] = image.size.map(|edge| edge as usize);
    // A view has several layers of a curve.
    let per_view = whole(&map["layers_of_view"]);
    let texel = image.format.bytes as usize;
    let (mut different, mut texels) = (0, 0);
    for view in each(views) {
        let [x, y, across, down] =
            [&view["origin"][0], &view["origin"][1], &view["size"][0], &view["size"][1]].map(whole);
        let first = whole(&view["layer"]) * per_view;
        let rows = (first..first + per_view).flat_map(|layer| (y..y + down).map(move |y| (layer, y)));
        for (layer, row) in rows {
            let start = ((layer * height + row) * width + x) * texel;
            let range = start..start + across * texel;
            let pairs =
                got[range.clone()].chunks_exact(texel).zip(wanted[range].chunks_exact(texel));
            texels += across;
            different += pairs.filter(|(a, b)| a != b).count();
        }
    }
    if texels == 0 {
        return Err("nothing was compared".into());
    }
    Ok((different, texels))
}
