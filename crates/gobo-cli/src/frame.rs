//! A scene's frame as a recording: its resources with their contents, its kernels, its commands, and the
//! resulting maps, bit for bit. For engines without wgpu: `docs/export.md`.
use super::{
    export::{binding_entry, format_name},
    failure::Failure,
    files, inputs,
    memory::Needs,
    output,
    structs::structs,
    translate::{self, translate},
    values::Target,
};
use gobo::{
    Error, Gpu, Prepared, Shadows,
    frame::{Command, Commands, Dispatch, Work},
    gpu::{Kernel, Resource, Selection, Tier, printed},
    host::Input,
    model::Scene,
    view::shadow_views,
    wgpu::{Buffer, Extent3d, TexelCopyTextureInfoBase, Texture, TextureDimension},
};
use gobo_scene as scene;
use serde_json::{Map, Value, json};
use std::{collections::HashMap, path::Path};

/// Writes the files to `out`, and returns the contents of `frame.json`.
pub(super) fn write(
    target: Target,
    path: &Path,
    set: &[(String, String)],
    out: &Path,
) -> Result<Value, Failure> {
    let scene = scene::load_with(path, set)?;
    files::warn(&scene.notes);
    Needs { maps: true, ..Needs::default() }.check(&scene)?;
    let extension = format!(".{}", target.extension());
    inputs::check_folder(out, |name| {
        let is_of_frame = name.starts_with("frame/");
        is_of_frame || name.ends_with(&extension) || ["frame.json", "manifest.json"].contains(&name)
    })?;
    files::create_dir(&out.join("frame"))?;
    let mut tiers = Map::new();
    for &tier in Tier::ALL {
        let gpu = Gpu::new(&Selection { tier: Some(tier), ..Selection::default() })?;
        if gpu.tier != tier {
            tracing::warn!("no frame of the {tier} tier: {}", gpu.tier_reason);
            continue;
        }
        let folder = format!("frame/{tier}");
        files::create_dir(&out.join(&folder))?;
        let (resources, kernels) = (Vec::new(), Vec::new());
        let recording = Recording {
            gpu: &gpu,
            target,
            out,
            folder,
            resources,
            kernels,
            names: HashMap::new(),
            taken: HashMap::new(),
        };
        tiers.insert(tier.to_string(), recording.of(&scene)?);
    }
    Ok(json!({ "gobo": env!("CARGO_PKG_VERSION"), "language": target.version(), "tiers": tiers }))
}

/// A frame of new maps with room for all pairs, prepared but not yet recorded.
fn prepared(gpu: &Gpu, scene: &Scene) -> Result<Prepared, Error> {
    let (casters, views) = (scene.casters(), shadow_views(scene));
    let shadows = || Shadows::on_tier(&gpu.device, &gpu.queue, &gpu.adapter, gpu.tier);
    let (mut counting, mut made) = (shadows()?, shadows()?);
    let prepared = counting.prepare(&casters, &views, &scene.shadow)?;
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    prepared.record_counts(&mut encoder)?;
    gpu.queue.submit([encoder.finish()]);
    gpu.check()?;
    made.grow_from(&prepared.counters()?);
    made.prepare(&casters, &views, &scene.shadow)
}

/// The recording of a tier.
struct Recording<'a> {
    gpu: &'a Gpu,
    target: Target,
    out: &'a Path,
    /// Folder of its files in `out`.
    folder: String,
    /// Entries of `frame.json`.
    resources: Vec<Value>,
    kernels: Vec<(Kernel, String, Value)>,
    names: HashMap<Resource, String>,
    /// Number of resources and kernels by name; numbers tell those of one name apart.
    taken: HashMap<String, u32>,
}

impl Recording<'_> {
    fn of(mut self, scene: &Scene) -> Result<Value, Failure> {
        let prepared = prepared(self.gpu, scene)?;
        let maps = prepared.maps();
        let mut textures = vec![
            ("filters", &maps.filters),
            ("nearests", &maps.nearests),
            ("opaques", &maps.opaques),
        ];
        if maps.nodes > 0 {
            textures.push(("curves", &maps.curves));
        }
        for (name, texture) in &textures {
            self.texture(name, texture)?;
        }
        let commands = self.commands(prepared.commands())?;
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        prepared.record(&mut encoder)?;
        self.gpu.queue.submit([encoder.finish()]);
        self.gpu.check()?;
        let layers = maps.filters.depth_or_array_layers();
        let mut results = Map::new();
        for (name, texture) in textures {
            let bytes: Vec<u8> = self.gpu.try_read_texture(texture)?;
            let result = json!({
                "resource": self.texture(name, texture)?,
                "file": self.file(&format!("{name}.made.bin"), &bytes)?,
                "layers_of_view": texture.depth_or_array_layers() / layers,
            });
            results.insert(name.to_owned(), result);
        }
        let placed = shadow_views(scene).into_iter().zip(&maps.slots);
        let views: Vec<_> = placed
            .map(|(view, slot)| {
                json!({
                    "layer": slot.layer,
                    "origin": slot.origin.to_array(),
                    "size": view.size.to_array(),
                })
            })
            .collect();
        let structs = structs(self.kernels.iter().map(|(kernel, _, _)| kernel));
        let kernels: Vec<_> = self.kernels.into_iter().map(|(_, _, entry)| entry).collect();
        Ok(json!({
            "resources": self.resources,
            "kernels": kernels,
            "commands": commands,
            "maps": results,
            "views": views,
            "structs": structs,
        }))
    }

    fn commands(&mut self, commands: &Commands) -> Result<Vec<Value>, Failure> {
        commands.iter().map(|command| self.command(command)).collect()
    }

    fn command(&mut self, command: &Command) -> Result<Value, Failure> {
        let mut value = match command {
            Command::Pass { dispatches, .. } => {
                let all: Result<Vec<_>, _> =
                    dispatches.iter().map(|dispatch| self.dispatch(dispatch)).collect();
                json!({ "dispatches": all? })
            }
            Command::Clear { buffer, .. } => json!({ "clear": self.buffer("cleared", buffer)? }),
            Command::CopyBuffer { from, to, size, .. } => json!({ "copy_buffer": {
                "from": self.buffer("copied", &from.0)?, "from_offset": from.1,
                "to": self.buffer("copied", &to.0)?, "to_offset": to.1,
                "size": size,
            } }),
            Command::CopyBufferToTexture { from: (buffer, layout), to, size, .. } => {
                json!({ "copy_to_texture": {
                    "from": self.buffer("copied", buffer)?, "from_offset": layout.offset,
                    "bytes_per_row": layout.bytes_per_row,
                    "to": self.copied(to)?, "size": extent(*size),
                } })
            }
            Command::CopyTexture { from, to, size, .. } => json!({ "copy_texture": {
                "from": self.copied(from)?, "to": self.copied(to)?, "size": extent(*size),
            } }),
        };
        value["label"] = command.label().into();
        Ok(value)
    }

    fn copied(&mut self, copied: &TexelCopyTextureInfoBase<Texture>) -> Result<Value, Failure> {
        let name = self.texture("copied", &copied.texture)?;
        let origin = [copied.origin.x, copied.origin.y, copied.origin.z];
        Ok(json!({ "texture": name, "level": copied.mip_level, "origin": origin }))
    }

    fn dispatch(&mut self, dispatch: &Dispatch) -> Result<Value, Failure> {
        let mut bound = Map::new();
        for (name, resource) in dispatch.bound.resources() {
            let resource = match resource {
                Resource::Buffer(buffer) => self.buffer(name, buffer)?,
                Resource::Texture(texture) => self.texture(name, texture)?,
                Resource::View(view) => {
                    if view.texture().mip_level_count() > 1 {
                        let problem =
                            "its maps have smaller levels, of which one is bound at a time";
                        return Err(Error::Invalid { what: Input::Frame, index: 0, problem }.into());
                    }
                    self.texture(name, view.texture())?
                }
            };
            bound.insert((*name).to_owned(), resource.into());
        }
        let mut value = json!({ "kernel": self.kernel(&dispatch.kernel)?, "bind": bound });
        match &dispatch.work {
            Work::Groups(groups) => value["groups"] = json!(groups),
            Work::Indirect(counts, offset) => {
                let buffer = self.buffer("dispatches", counts)?;
                value["indirect"] = json!({ "buffer": buffer, "offset": offset });
            }
        }
        Ok(value)
    }

    fn unique(&mut self, name: &str) -> String {
        let count = self.taken.entry(name.to_owned()).or_default();
        *count += 1;
        if *count == 1 { name.to_owned() } else { format!("{name}_{count}") }
    }

    fn kernel(&mut self, kernel: &Kernel) -> Result<String, Failure> {
        if let Some((_, id, _)) = self.kernels.iter().find(|(known, _, _)| known == kernel) {
            return Ok(id.clone());
        }
        let id = self.unique(kernel.name());
        let wrong = |reason: String| Failure::Wrong(format!("{id}: {reason}"));
        let module = kernel.module().ok_or_else(|| wrong("it calls the host".to_owned()))?;
        let wgsl = printed(module).map_err(wrong)?;
        let source = translate::Kernel::new(kernel.entry(), wgsl, &[], self.target);
        let source = source.map_err(wrong)?;
        let translated = translate(&source).map_err(wrong)?;
        let file = self.file(&format!("{id}.{}", self.target.extension()), &translated.source)?;
        let bindings = kernel.bindings().iter();
        let bindings: Vec<_> =
            bindings.map(|it| binding_entry(it, &source, &translated.slots)).collect();
        let value = json!({
            "id": id,
            "file": file,
            "entry_point": translated.entry_point,
            "workgroup_size": translated.workgroup_size,
            "features": translated.features,
            "bindings": bindings,
        });
        self.kernels.push((kernel.clone(), id.clone(), value));
        Ok(id)
    }

    fn buffer(&mut self, name: &str, buffer: &Buffer) -> Result<String, Failure> {
        let resource = Resource::Buffer(buffer.clone());
        if let Some(known) = self.names.get(&resource) {
            return Ok(known.clone());
        }
        let bytes: Vec<u8> = self.gpu.try_read(buffer)?;
        let value = json!({ "kind": "buffer", "size": buffer.size() });
        self.resource(name, resource, value, &bytes)
    }

    fn texture(&mut self, name: &str, texture: &Texture) -> Result<String, Failure> {
        let resource = Resource::Texture(texture.clone());
        if let Some(known) = self.names.get(&resource) {
            return Ok(known.clone());
        }
        let bytes: Vec<u8> = self.gpu.try_read_texture(texture)?;
        let dimension = match texture.dimension() {
            TextureDimension::D3 => "3d",
            _ => "2d",
        };
        let value = json!({
            "kind": "texture",
            "format": format_name(texture.format()),
            "dimension": dimension,
            "size": extent(texture.size()),
        });
        self.resource(name, resource, value, &bytes)
    }

    fn resource(
        &mut self,
        name: &str,
        resource: Resource,
        mut value: Value,
        bytes: &[u8],
    ) -> Result<String, Failure> {
        let name = self.unique(name);
        value["name"] = name.clone().into();
        if bytes.iter().any(|byte| *byte != 0) {
            value["initial"] = self.file(&format!("{name}.bin"), bytes)?.into();
        }
        self.resources.push(value);
        self.names.insert(resource, name.clone());
        Ok(name)
    }

    /// Writes a file, and returns its name in `frame.json`.
    fn file(&self, name: &str, bytes: &[u8]) -> Result<String, Failure> {
        let name = format!("{}/{name}", self.folder);
        output::write(&self.out.join(&name), bytes).map(|()| name)
    }
}

fn extent(size: Extent3d) -> [u32; 3] {
    [size.width, size.height, size.depth_or_array_layers]
}
