//! As much Vulkan as a frame needs: host-visible buffers, images that stay in one layout, compute pipelines,
//! and one command buffer at a time. Objects live until the process ends.
use crate::Failure;
use ash::vk;

pub struct Vulkan {
    // Loaded as long as the device is used.
    _loaded: (ash::Entry, ash::Instance),
    pub device: ash::Device,
    queue: vk::Queue,
    pool: vk::CommandPool,
    memory: vk::PhysicalDeviceMemoryProperties,
    pub name: String,
}

#[derive(Clone, Copy)]
pub struct Buffer {
    pub buffer: vk::Buffer,
    pub size: u64,
    mapped: *mut u8,
}

#[derive(Clone, Copy)]
pub struct Image {
    image: vk::Image,
    pub format: Format,
    /// Width, height and layers [texels].
    pub size: [u32; 3],
}

/// Format of a texture.
#[derive(Clone, Copy)]
pub struct Format {
    pub vk: vk::Format,
    /// Bytes per texel.
    pub bytes: u32,
}

impl Format {
    pub fn named(name: &str) -> Result<Self, Failure> {
        let (vk, bytes) = match name {
            "r32uint" => (vk::Format::R32_UINT, 4),
            "rg32uint" => (vk::Format::R32G32_UINT, 8),
            "rgba32uint" => (vk::Format::R32G32B32A32_UINT, 16),
            "r32float" => (vk::Format::R32_SFLOAT, 4),
            "rgba16float" => (vk::Format::R16G16B16A16_SFLOAT, 8),
            "rgba8unorm-srgb" => (vk::Format::R8G8B8A8_SRGB, 4),
            _ => return Err(format!("this example knows no {name}").into()),
        };
        Ok(Self { vk, bytes })
    }

    fn is_stored(self) -> bool {
        self.vk != vk::Format::R8G8B8A8_SRGB
    }
}

impl Vulkan {
    /// Opens the first device; `GOBO_ASH_DEVICE` may name part of another one's name.
    pub fn new() -> Result<Self, Failure> {
        let wanted = std::env::var("GOBO_ASH_DEVICE").unwrap_or_default();
        // SAFETY: Vulkan is loaded once, and all its objects live as long as the process.
        unsafe {
            let entry = ash::Entry::load()?;
            let application = vk::ApplicationInfo::default().api_version(vk::API_VERSION_1_3);
            let info = vk::InstanceCreateInfo::default().application_info(&application);
            let instance = entry.create_instance(&info, None)?;
            let name_of = |device: &vk::PhysicalDevice| {
                let properties = instance.get_physical_device_properties(*device);
                let name = properties.device_name_as_c_str().unwrap_or_default();
                name.to_string_lossy().into_owned()
            };
            let devices = instance.enumerate_physical_devices()?;
            let physical = devices
                .into_iter()
                .find(|device| name_of(device).contains(&wanted))
                .ok_or("there is no Vulkan device: on Debian, mesa-vulkan-drivers has one")?;
            let families = instance.get_physical_device_queue_family_properties(physical);
            let computes = |family: &vk::QueueFamilyProperties| {
                family.queue_flags.contains(vk::QueueFlags::COMPUTE)
            };
            let family = families.iter().position(computes).ok_or("no queue computes")? as u32;
            let queues = [vk::DeviceQueueCreateInfo::default()
                .queue_family_index(family)
                .queue_priorities(&[1.0])];
            // `rg32uint` as storage is one of the extended formats.
            let features = vk::PhysicalDeviceFeatures::default()
                .shader_storage_image_extended_formats(true)
                .robust_buffer_access(true);
            let mut robust =
                vk::PhysicalDeviceImageRobustnessFeatures::default().robust_image_access(true);
            let mut zeroed = vk::PhysicalDeviceZeroInitializeWorkgroupMemoryFeatures::default()
                .shader_zero_initialize_workgroup_memory(true);
            let info = vk::DeviceCreateInfo::default()
                .queue_create_infos(&queues)
                .enabled_features(&features)
                .push_next(&mut zeroed)
                .push_next(&mut robust);
            let device = instance.create_device(physical, &info, None)?;
            let queue = device.get_device_queue(family, 0);
            let info = vk::CommandPoolCreateInfo::default().queue_family_index(family);
            let pool = device.create_command_pool(&info, None)?;
            let memory = instance.get_physical_device_memory_properties(physical);
            let name = name_of(&physical);
            let _loaded = (entry, instance);
            Ok(Self { _loaded, device, queue, pool, memory, name })
        }
    }

    fn allocate(
        &self,
        needs: vk::MemoryRequirements,
        flags: vk::MemoryPropertyFlags,
    ) -> Result<vk::DeviceMemory, Failure> {
        let types = self.memory.memory_types_as_slice();
        let fits = |(i, kind): &(usize, &vk::MemoryType)| {
            needs.memory_type_bits >> i & 1 == 1 && kind.property_flags.contains(flags)
        };
        let (index, _) = types.iter().enumerate().find(fits).ok_or("no memory fits")?;
        let info = vk::MemoryAllocateInfo::default()
            .allocation_size(needs.size)
            .memory_type_index(index as u32);
        // SAFETY: the type is one of the device's, and nothing is freed.
        Ok(unsafe { self.device.allocate_memory(&info, None)? })
    }

    /// A buffer of zeros.
    pub fn buffer(&self, size: u64) -> Result<Buffer, Failure> {
        let size = size.max(16).next_multiple_of(4);
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER
            | vk::BufferUsageFlags::UNIFORM_BUFFER
            | vk::BufferUsageFlags::INDIRECT_BUFFER
            | vk::BufferUsageFlags::TRANSFER_SRC
            | vk::BufferUsageFlags::TRANSFER_DST;
        let info = vk::BufferCreateInfo::default().size(size).usage(usage);
        let flags = vk::MemoryPropertyFlags::HOST_VISIBLE | vk::MemoryPropertyFlags::HOST_COHERENT;
        // SAFETY: the memory is the buffer's alone, large enough and mapped once, as a whole.
        let buffer = unsafe {
            let buffer = self.device.create_buffer(&info, None)?;
            let memory =
                self.allocate(self.device.get_buffer_memory_requirements(buffer), flags)?;
            self.device.bind_buffer_memory(buffer, memory, 0)?;
            let whole = vk::MemoryMapFlags::empty();
            let mapped = self.device.map_memory(memory, 0, vk::WHOLE_SIZE, whole)?.cast();
            Buffer { buffer, size, mapped }
        };
        buffer.write(&vec![0; size as usize]);
        Ok(buffer)
    }

    /// An image in the layout `GENERAL` from here on; its texels must be written.
    pub fn image(&self, format: Format, size: [u32; 3]) -> Result<Image, Failure> {
        let size = size.map(|edge| edge.max(1));
        let mut usage = vk::ImageUsageFlags::SAMPLED
            | vk::ImageUsageFlags::TRANSFER_SRC
            | vk::ImageUsageFlags::TRANSFER_DST;
        if format.is_stored() {
            usage |= vk::ImageUsageFlags::STORAGE;
        }
        let info = vk::ImageCreateInfo::default()
            .image_type(vk::ImageType::TYPE_2D)
            .format(format.vk)
            .extent(vk::Extent3D { width: size[0], height: size[1], depth: 1 })
            .mip_levels(1)
            .array_layers(size[2])
            .samples(vk::SampleCountFlags::TYPE_1)
            .usage(usage);
        // SAFETY: the memory is the image's alone, and large enough.
        let image = unsafe {
            let image = self.device.create_image(&info, None)?;
            let needs = self.device.get_image_memory_requirements(image);
            let memory = self.allocate(needs, vk::MemoryPropertyFlags::DEVICE_LOCAL)?;
            self.device.bind_image_memory(image, memory, 0)?;
            image
        };
        let image = Image { image, format, size };
        self.run(|commands| {
            let barrier = vk::ImageMemoryBarrier::default()
                .image(image.image)
                .new_layout(vk::ImageLayout::GENERAL)
                .dst_access_mask(vk::AccessFlags::TRANSFER_WRITE)
                .subresource_range(image.range());
            // SAFETY: `commands` is being recorded, and nothing else uses the image.
            unsafe {
                self.device.cmd_pipeline_barrier(
                    commands,
                    vk::PipelineStageFlags::TOP_OF_PIPE,
                    vk::PipelineStageFlags::TRANSFER,
                    vk::DependencyFlags::empty(),
                    &[],
                    &[],
                    &[barrier],
                );
            }
        })?;
        Ok(image)
    }

    /// Writes an image row by row, layer by layer; missing bytes at the end are zero.
    pub fn write_image(&self, image: &Image, bytes: &[u8]) -> Result<(), Failure> {
        let mut whole = bytes.to_vec();
        whole.resize(image.bytes(), 0);
        let staging = self.buffer(whole.len() as u64)?;
        staging.write(&whole);
        self.run(|commands| {
            let (layout, regions) = (vk::ImageLayout::GENERAL, [image.region()]);
            // SAFETY: `commands` is being recorded; the buffer has a texel for each of the image's.
            unsafe {
                self.device.cmd_copy_buffer_to_image(
                    commands,
                    staging.buffer,
                    image.image,
                    layout,
                    &regions,
                );
            }
        })
    }

    /// Records a copy from a buffer, at an offset and with bytes per row (0: as many as a row of `size` has),
    /// to a part of an image.
    pub fn copy_to_image(
        &self,
        commands: vk::CommandBuffer,
        (from, offset, row): (&Buffer, u64, u32),
        to: &Image,
        [x, y, layer]: [u32; 3],
        [width, height, layers]: [u32; 3],
    ) {
        let layers = vk::ImageSubresourceLayers::default()
            .aspect_mask(vk::ImageAspectFlags::COLOR)
            .base_array_layer(layer)
            .layer_count(layers);
        let region = vk::BufferImageCopy::default()
            .buffer_offset(offset)
            .buffer_row_length(row / to.format.bytes)
            .image_subresource(layers)
            .image_offset(vk::Offset3D { x: x as i32, y: y as i32, z: 0 })
            .image_extent(vk::Extent3D { width, height, depth: 1 });
        // SAFETY: `commands` is being recorded, and the region is within buffer and image.
        unsafe {
            let layout = vk::ImageLayout::GENERAL;
            self.device.cmd_copy_buffer_to_image(
                commands,
                from.buffer,
                to.image,
                layout,
                &[region],
            );
        }
    }

    pub fn read_image(&self, image: &Image) -> Result<Vec<u8>, Failure> {
        let staging = self.buffer(image.bytes() as u64)?;
        self.run(|commands| {
            let (layout, regions) = (vk::ImageLayout::GENERAL, [image.region()]);
            // SAFETY: `commands` is being recorded; the buffer has room for all of the image's texels.
            unsafe {
                self.device.cmd_copy_image_to_buffer(
                    commands,
                    image.image,
                    layout,
                    staging.buffer,
                    &regions,
                );
            }
        })?;
        let mut bytes = staging.read();
        bytes.truncate(image.bytes());
        Ok(bytes)
    }

    /// Records, submits and waits.
    pub fn run(&self, record: impl FnOnce(vk::CommandBuffer)) -> Result<(), Failure> {
        let info = vk::CommandBufferAllocateInfo::default()
            .command_pool(self.pool)
            .level(vk::CommandBufferLevel::PRIMARY)
            .command_buffer_count(1);
        let once = vk::CommandBufferBeginInfo::default()
            .flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: the command buffer is this function's alone, and finished before it returns.
        unsafe {
            let all = self.device.allocate_command_buffers(&info)?;
            self.device.begin_command_buffer(all[0], &once)?;
            record(all[0]);
            self.device.end_command_buffer(all[0])?;
            let submits = [vk::SubmitInfo::default().command_buffers(&all)];
            self.device.queue_submit(self.queue, &submits, vk::Fence::null())?;
            self.device.queue_wait_idle(self.queue)?;
            self.device.free_command_buffers(self.pool, &all);
        }
        Ok(())
    }

    /// Makes all earlier writes visible to all later commands.
    pub fn barrier(&self, commands: vk::CommandBuffer) {
        let all = vk::AccessFlags::MEMORY_READ | vk::AccessFlags::MEMORY_WRITE;
        let barriers = [vk::MemoryBarrier::default().src_access_mask(all).dst_access_mask(all)];
        let stages = vk::PipelineStageFlags::ALL_COMMANDS;
        let none = vk::DependencyFlags::empty();
        // SAFETY: `commands` is being recorded.
        unsafe {
            self.device.cmd_pipeline_barrier(commands, stages, stages, none, &barriers, &[], &[]);
        }
    }
}

impl Buffer {
    /// Writes from the buffer's start.
    pub fn write(&self, bytes: &[u8]) {
        let count = bytes.len().min(self.size as usize);
        // SAFETY: this many bytes are mapped, and no command runs.
        unsafe { std::ptr::copy_nonoverlapping(bytes.as_ptr(), self.mapped, count) }
    }

    pub fn read(&self) -> Vec<u8> {
        // SAFETY: this many bytes are mapped, and no command runs.
        unsafe { std::slice::from_raw_parts(self.mapped, self.size as usize).to_vec() }
    }
}

impl Image {
    pub fn bytes(&self) -> usize {
        let [width, height, layers] = self.size.map(|edge| edge as usize);
        width * height * layers * self.format.bytes as usize
    }

    fn range(&self) -> vk::ImageSubresourceRange {
        vk::ImageSubresourceRange::default()
            .aspect_mask(vk::ImageAspectFlags::COLOR)
            .level_count(1)
            .layer_count(self.size[2])
    }

    fn region(&self) -> vk::BufferImageCopy {
        let layers = vk::ImageSubresourceLayers::default()
            .aspect_mask(vk::ImageAspectFlags::COLOR)
            .layer_count(self.size[2]);
        let [width, height, _] = self.size;
        vk::BufferImageCopy::default().image_subresource(layers).image_extent(vk::Extent3D {
            width,
            height,
            depth: 1,
        })
    }

    /// A view for a binding of a 2D texture, or of an array.
    pub fn view(&self, vulkan: &Vulkan, is_array: bool) -> Result<vk::ImageView, Failure> {
        let kind =
            if is_array { vk::ImageViewType::TYPE_2D_ARRAY } else { vk::ImageViewType::TYPE_2D };
        let info = vk::ImageViewCreateInfo::default()
            .image(self.image)
            .view_type(kind)
            .format(self.format.vk)
            .subresource_range(self.range());
        // SAFETY: the image lives as long as the process.
        Ok(unsafe { vulkan.device.create_image_view(&info, None)? })
    }
}
