//! Pipelines of exported kernels, and their bindings.
use crate::{
    Failure,
    vulkan::{Buffer, Image, Vulkan},
};
use ash::vk;
use serde_json::Value;
use std::path::Path;

/// A kernel of the frame.
pub struct Kernel {
    pipeline: vk::Pipeline,
    layout: vk::PipelineLayout,
    set_layout: vk::DescriptorSetLayout,
    pub bindings: Vec<Binding>,
}

pub struct Binding {
    pub name: String,
    number: u32,
    kind: vk::DescriptorType,
    is_array: bool,
}

#[derive(Clone, Copy)]
pub enum Resource {
    Buffer(Buffer),
    Image(Image),
}

/// Workgroups of a dispatch.
pub enum Groups {
    Counts([u32; 3]),
    Indirect(Buffer, u64),
}

fn text(value: &Value) -> &str {
    value.as_str().unwrap_or_default()
}

fn binding(value: &Value) -> Result<Binding, Failure> {
    let kind = match text(&value["kind"]) {
        "uniform" => vk::DescriptorType::UNIFORM_BUFFER,
        "storage" => vk::DescriptorType::STORAGE_BUFFER,
        "storage_texture" => vk::DescriptorType::STORAGE_IMAGE,
        "texture" => vk::DescriptorType::SAMPLED_IMAGE,
        kind => return Err(format!("this example binds no {kind}").into()),
    };
    Ok(Binding {
        name: text(&value["name"]).to_owned(),
        number: value["binding"].as_u64().unwrap_or_default() as u32,
        kind,
        is_array: text(&value["dimension"]) == "2d-array",
    })
}

impl Kernel {
    /// `entry`: one of `kernels`.
    pub fn new(vulkan: &Vulkan, dir: &Path, entry: &Value) -> Result<Self, Failure> {
        let id = text(&entry["id"]);
        let file = entry["file"].as_str().ok_or_else(|| format!("{id} has no file"))?;
        let bytes = std::fs::read(dir.join(file)).map_err(|error| format!("{file}: {error}"))?;
        let words = ash::util::read_spv(&mut std::io::Cursor::new(bytes))?;
        let bindings = entry["bindings"].as_array().into_iter().flatten();
        let bindings = bindings.map(binding).collect::<Result<Vec<_>, _>>()?;
        let declared: Vec<_> = bindings
            .iter()
            .map(|it| {
                vk::DescriptorSetLayoutBinding::default()
                    .binding(it.number)
                    .descriptor_type(it.kind)
                    .descriptor_count(1)
                    .stage_flags(vk::ShaderStageFlags::COMPUTE)
            })
            .collect();
        let name = std::ffi::CString::new(text(&entry["entry_point"]))?;
        // SAFETY: the code is SPIR-V that was validated when it was exported, all pointers live until the
        // calls return, and nothing is destroyed.
        unsafe {
            let device = &vulkan.device;
            let module = device
                .create_shader_module(&vk::ShaderModuleCreateInfo::default().code(&words), None)?;
            let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&declared);
            let set_layout = device.create_descriptor_set_layout(&info, None)?;
            let set_layouts = [set_layout];
            let info = vk::PipelineLayoutCreateInfo::default().set_layouts(&set_layouts);
            let layout = device.create_pipeline_layout(&info, None)?;
            let stage = vk::PipelineShaderStageCreateInfo::default()
                .stage(vk::ShaderStageFlags::COMPUTE)
                .module(module)
                .name(&name);
            let info = [vk::ComputePipelineCreateInfo::default().stage(stage).layout(layout)];
            let pipelines = device.create_compute_pipelines(vk::PipelineCache::null(), &info, None);
            let pipeline = pipelines.map_err(|(_, error)| format!("{id}: {error}"))?[0];
            Ok(Self { pipeline, layout, set_layout, bindings })
        }
    }

    /// `resource`: the resource with a binding's name.
    pub fn bind(
        &self,
        vulkan: &Vulkan,
        resource: impl Fn(&str) -> Result<Resource, Failure>,
    ) -> Result<vk::DescriptorSet, Failure> {
        let kinds = [
            vk::DescriptorType::UNIFORM_BUFFER,
            vk::DescriptorType::STORAGE_BUFFER,
            vk::DescriptorType::STORAGE_IMAGE,
            vk::DescriptorType::SAMPLED_IMAGE,
        ];
        let sizes = kinds.map(|ty| vk::DescriptorPoolSize { ty, descriptor_count: 32 });
        let info = vk::DescriptorPoolCreateInfo::default().max_sets(1).pool_sizes(&sizes);
        // SAFETY: the set comes from a pool of its own and is written before anything uses it.
        let set = unsafe {
            let pool = vulkan.device.create_descriptor_pool(&info, None)?;
            let layouts = [self.set_layout];
            let info = vk::DescriptorSetAllocateInfo::default()
                .descriptor_pool(pool)
                .set_layouts(&layouts);
            vulkan.device.allocate_descriptor_sets(&info)?[0]
        };
        for Binding { name, number, kind, is_array } in &self.bindings {
            let write = vk::WriteDescriptorSet::default()
                .dst_set(set)
                .dst_binding(*number)
                .descriptor_type(*kind);
            let is_image = matches!(
                *kind,
                vk::DescriptorType::STORAGE_IMAGE | vk::DescriptorType::SAMPLED_IMAGE
            );
            let (images, buffers);
            let write = match (resource(name)?, is_image) {
                (Resource::Buffer(buffer), false) => {
                    buffers = [vk::DescriptorBufferInfo::default()
                        .buffer(buffer.buffer)
                        .range(vk::WHOLE_SIZE)];
                    write.buffer_info(&buffers)
                }
                (Resource::Image(image), true) => {
                    images = [vk::DescriptorImageInfo::default()
                        .image_view(image.view(vulkan, *is_array)?)
                        .image_layout(vk::ImageLayout::GENERAL)];
                    write.image_info(&images)
                }
                _ => return Err(format!("{name} is bound as what it is not").into()),
            };
            // SAFETY: the set is not in use, and the descriptor is of its layout's kind.
            unsafe { vulkan.device.update_descriptor_sets(&[write], &[]) }
        }
        Ok(set)
    }

    /// Records the dispatch after all commands recorded before.
    pub fn record(
        &self,
        vulkan: &Vulkan,
        commands: vk::CommandBuffer,
        set: vk::DescriptorSet,
        groups: &Groups,
    ) {
        let device = &vulkan.device;
        let point = vk::PipelineBindPoint::COMPUTE;
        vulkan.barrier(commands);
        // SAFETY: `commands` is being recorded; the set has the pipeline's layout.
        unsafe {
            device.cmd_bind_pipeline(commands, point, self.pipeline);
            device.cmd_bind_descriptor_sets(commands, point, self.layout, 0, &[set], &[]);
            match groups {
                Groups::Counts([x, y, z]) => device.cmd_dispatch(commands, *x, *y, *z),
                Groups::Indirect(buffer, offset) => {
                    device.cmd_dispatch_indirect(commands, buffer.buffer, *offset);
                }
            }
        }
    }
}
