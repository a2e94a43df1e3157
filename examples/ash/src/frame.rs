//! Runs a frame of `frame.json`.
use crate::{
    Failure,
    kernel::{Groups, Kernel, Resource},
    read,
    vulkan::{Buffer, Format, Image, Vulkan},
};
use ash::vk;
use serde_json::Value;
use std::{collections::HashMap, path::Path};

/// A frame with its resources and kernels.
pub struct Frame<'a> {
    vulkan: &'a Vulkan,
    value: &'a Value,
    resources: HashMap<&'a str, Resource>,
    kernels: HashMap<&'a str, Kernel>,
}

pub fn each(value: &Value) -> impl Iterator<Item = &Value> {
    value.as_array().into_iter().flatten()
}

fn text(value: &Value) -> &str {
    value.as_str().unwrap_or_default()
}

fn number(value: &Value) -> u64 {
    value.as_u64().unwrap_or_default()
}

impl<'a> Frame<'a> {
    pub fn new(vulkan: &'a Vulkan, dir: &Path, value: &'a Value) -> Result<Self, Failure> {
        let mut resources = HashMap::new();
        for resource in each(&value["resources"]) {
            let bytes = match resource["initial"].as_str() {
                Some(file) => read(&dir.join(file))?,
                None => Vec::new(),
            };
            let made = match text(&resource["kind"]) {
                "buffer" => {
                    let buffer = vulkan.buffer(number(&resource["size"]))?;
                    buffer.write(&bytes);
                    Resource::Buffer(buffer)
                }
                "texture" => {
                    let format = Format::named(text(&resource["format"]))?;
                    let size = [0, 1, 2].map(|i| number(&resource["size"][i]) as u32);
                    let image = vulkan.image(format, size)?;
                    vulkan.write_image(&image, &bytes)?;
                    Resource::Image(image)
                }
                kind => return Err(format!("this example knows no {kind}").into()),
            };
            resources.insert(text(&resource["name"]), made);
        }
        let mut kernels = HashMap::new();
        for kernel in each(&value["kernels"]) {
            kernels.insert(text(&kernel["id"]), Kernel::new(vulkan, dir, kernel)?);
        }
        Ok(Self { vulkan, value, resources, kernels })
    }

    fn resource(&self, name: &Value) -> Result<Resource, Failure> {
        Ok(*self.resources.get(text(name)).ok_or_else(|| format!("there is no {name}"))?)
    }

    fn buffer(&self, name: &Value) -> Result<Buffer, Failure> {
        match self.resource(name)? {
            Resource::Buffer(buffer) => Ok(buffer),
            Resource::Image(_) => Err(format!("{name} is no buffer").into()),
        }
    }

    pub fn image(&self, name: &Value) -> Result<Image, Failure> {
        match self.resource(name)? {
            Resource::Image(image) => Ok(image),
            Resource::Buffer(_) => Err(format!("{name} is no texture").into()),
        }
    }

    /// Runs all commands in order; each sees the writes of those before.
    pub fn run(&self) -> Result<(), Failure> {
        let mut result = Ok(());
        self.vulkan.run(|commands| {
            result = each(&self.value["commands"])
                .try_for_each(|command| self.record(commands, command));
        })?;
        result
    }

    fn record(&self, commands: vk::CommandBuffer, command: &Value) -> Result<(), Failure> {
        for dispatch in each(&command["dispatches"]) {
            let id = text(&dispatch["kernel"]);
            let kernel = self.kernels.get(id).ok_or_else(|| format!("there is no kernel {id}"))?;
            let bound = |name: &str| {
                let resource = self.resource(&dispatch["bind"][name]);
                resource.map_err(|error| format!("{id} binds {name}: {error}").into())
            };
            let groups = match &dispatch["indirect"] {
                Value::Null => {
                    Groups::Counts([0, 1, 2].map(|i| number(&dispatch["groups"][i]) as u32))
                }
                counts => {
                    Groups::Indirect(self.buffer(&counts["buffer"])?, number(&counts["offset"]))
                }
            };
            let set = kernel.bind(self.vulkan, bound)?;
            kernel.record(self.vulkan, commands, set, &groups);
        }
        self.vulkan.barrier(commands);
        let (clear, copy) = (&command["clear"], &command["copy_buffer"]);
        if clear.is_string() {
            let buffer = self.buffer(clear)?;
            // SAFETY: `commands` is being recorded.
            unsafe {
                let size = vk::WHOLE_SIZE;
                self.vulkan.device.cmd_fill_buffer(commands, buffer.buffer, 0, size, 0);
            }
        }
        if copy.is_object() {
            let (from, to) = (self.buffer(&copy["from"])?, self.buffer(&copy["to"])?);
            let region = vk::BufferCopy {
                src_offset: number(&copy["from_offset"]),
                dst_offset: number(&copy["to_offset"]),
                size: number(&copy["size"]),
            };
            // SAFETY: `commands` is being recorded, and the region is within both buffers.
            unsafe {
                let device = &self.vulkan.device;
                device.cmd_copy_buffer(commands, from.buffer, to.buffer, &[region]);
            }
        }
        let copy = &command["copy_to_texture"];
        if copy.is_object() {
            let (from, to) = (self.buffer(&copy["from"])?, self.image(&copy["to"]["texture"])?);
            let part = |value: &Value| [0, 1, 2].map(|i| number(&value[i]) as u32);
            let (origin, size) = (part(&copy["to"]["origin"]), part(&copy["size"]));
            let row = number(&copy["bytes_per_row"]) as u32;
            self.vulkan.copy_to_image(
                commands,
                (&from, number(&copy["from_offset"]), row),
                &to,
                origin,
                size,
            );
        }
        if command["copy_texture"].is_object() {
            return Err("this example copies no texture to another".into());
        }
        Ok(())
    }
}
