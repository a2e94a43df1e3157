//! Uploads of a scene's frame, and its maps, bit for bit: reference for engines without wgpu.
use super::{failure::Failure, files, memory::Needs};
use gobo::{
    Gpu, Maps, Shadows,
    error::Error,
    gpu::{Selection, Tier},
    scene,
    shadows::frame::{ListUploads, Uploads},
    stage::formula::{Number, Numbers},
    view::shadow_views,
};
use serde_json::{Map, Value, json};
use std::path::Path;

/// Writes the arrays to `out`, and returns their entries for `frame.json`.
pub(super) fn write(path: &Path, set: &[(String, String)], out: &Path) -> Result<Value, Failure> {
    let scene = scene::load_with(path, set)?;
    files::warn(&scene.notes);
    Needs { maps: true, ..Needs::default() }.check(&scene)?;
    let dir = out.join("frame");
    files::create_dir(&dir)?;
    // Name in `frame.json`.
    let file = |name: &str, bytes: &[u8]| {
        files::write(&dir.join(name), bytes).map(|()| format!("frame/{name}"))
    };
    let views = shadow_views(&scene);
    let casters = scene.casters();
    let (mut maps, mut frame) = (Map::new(), Value::Null);
    for (tier, of) in [("core", Tier::Core), ("native", Tier::Native)] {
        let gpu = match Gpu::new(&Selection { tier: Some(of), ..Selection::default() }) {
            Ok(gpu) => gpu,
            Err(reason) if of == Tier::Native => {
                tracing::warn!("no maps of the native tier: {reason}");
                continue;
            }
            Err(reason) => return Err(reason.into()),
        };
        let mut shadows = Shadows::on_tier(&gpu.device, &gpu.queue, &gpu.adapter, gpu.tier)?;
        // The exported steps scatter what does not fit.
        shadows.configure(|config| config.parts = false);
        let prepared = loop {
            let prepared = shadows.prepare(&casters, &views, &scene.shadow)?;
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            prepared.record(&mut encoder);
            gpu.queue.submit([encoder.finish()]);
            gpu.check()?;
            if !shadows.grow_from(prepared.counters()?) {
                break prepared;
            }
        };
        let mut written = Map::new();
        for (name, bytes) in bits(&gpu, prepared.maps())? {
            written.insert(name.to_owned(), file(&format!("{tier}.{name}.bin"), &bytes)?.into());
        }
        maps.insert(tier.to_owned(), written.into());
        if tier == "core" {
            let uploads = shadows.uploads(&casters, &views)?;
            frame = describe(&uploads, &file)?;
        }
    }
    frame["maps"] = maps.into();
    Ok(frame)
}

/// Each map, row by row, layer by layer.
fn bits(gpu: &Gpu, maps: &Maps) -> Result<Vec<(&'static str, Vec<u8>)>, Error> {
    let mut all = vec![
        ("filters", gpu.try_read_texture(&maps.filters)?),
        ("nearests", gpu.try_read_texture(&maps.nearests)?),
        ("opaques", gpu.try_read_texture(&maps.opaques)?),
    ];
    if maps.nodes > 0 {
        all.push(("curves", gpu.try_read_texture::<u8>(&maps.curves)?));
    }
    Ok(all)
}

fn describe(
    uploads: &Uploads,
    file: &impl Fn(&str, &[u8]) -> Result<String, Failure>,
) -> Result<Value, Failure> {
    let given = [
        Number::Width,
        Number::Height,
        Number::Layers,
        Number::CasterCount,
        Number::TriangleCount,
        Number::ImageWidth,
        Number::ImageHeight,
        Number::ImageCount,
    ];
    let arrays = json!({
        "casters": file("casters.bin", &uploads.casters)?,
        "triangles": file("triangles.bin", &uploads.triangles)?,
        "materials": file("materials.bin", &uploads.materials)?,
        "images": file("images.bin", &uploads.images)?,
    });
    let mut batches = Vec::new();
    for (i, batch) in uploads.batches.iter().enumerate() {
        let views = file(&format!("{i}.views.bin"), bytemuck::cast_slice(&batch.views))?;
        let mut lists = Vec::new();
        for (name, list) in ["blocking", "filtering"].into_iter().zip(&batch.lists) {
            let of = |what: &str| format!("{i}.{name}.{what}.bin");
            lists.push(list_entry(name, list, |what, bytes| file(&of(what), bytes))?);
        }
        batches.push(json!({ "uploads": { "views": views }, "lists": lists }));
    }
    Ok(json!({
        "numbers": numbers(&uploads.numbers, &given),
        "uploads": arrays,
        "batches": batches,
    }))
}

fn list_entry(
    name: &str,
    list: &ListUploads,
    file: impl Fn(&str, &[u8]) -> Result<String, Failure>,
) -> Result<Value, Failure> {
    let given = [
        Number::ViewCount,
        Number::TileCount,
        Number::ParticleChunks,
        Number::TriangleChunks,
        Number::TinyChunks,
        Number::FootprintCount,
        Number::SetupCount,
        Number::FirstSetup,
        Number::PairCapacity,
        Number::SegmentLength,
        Number::Nodes,
        Number::Changes,
        Number::Scatter,
        Number::IncludeNonCasters,
        Number::ByDistance,
    ];
    let conditions: Vec<_> = list.conditions.iter().map(|it| it.name()).collect();
    let traits: Vec<_> = list.traits.iter().map(|it| it.name()).collect();
    let constants: Map<_, _> =
        list.constants.iter().map(|&(name, value)| (name.to_owned(), value.into())).collect();
    Ok(json!({
        "name": name,
        "numbers": numbers(&list.numbers, &given),
        "conditions": conditions,
        "traits": traits,
        "constants": constants,
        "uploads": {
            "particle_chunks": file("particle_chunks", bytemuck::cast_slice(&list.particle_chunks))?,
            "triangle_chunks": file("triangle_chunks", bytemuck::cast_slice(&list.triangle_chunks))?,
            "tiny_chunks": file("tiny_chunks", bytemuck::cast_slice(&list.tiny_chunks))?,
        },
    }))
}

fn numbers(numbers: &Numbers, given: &[Number]) -> Map<String, Value> {
    given.iter().map(|&it| (it.name().to_owned(), numbers.get(it).into())).collect()
}
