//! A GPU's compiler: it compiles compute pipelines and says what they need, by `VK_KHR_pipeline_executable_properties`.
//! Without the GPU that is RADV (Mesa) on its null hardware: `RADV_FORCE_FAMILY` names the GPU, and the device has no
//! memory, so that nothing can run.
use crate::{
    Failure,
    manifest::Case,
    traffic::{Traffic, traffic, visit},
};
use ash::{khr::pipeline_executable_properties as properties, vk};
use std::{path::Path, time::Duration};

/// What a kernel needs on a GPU.
#[derive(Clone, Debug, PartialEq, serde::Deserialize, serde::Serialize)]
pub struct Needs {
    /// Vector registers of a lane.
    pub vgprs: u64,
    /// Vector registers kept in memory instead.
    pub spilled: u64,
    /// Workgroup memory [bytes].
    pub lds: u64,
    /// Waves that fit a SIMD.
    pub waves: u64,
    pub instructions: u64,
    /// Machine code [bytes].
    pub code: u64,
    pub traffic: Traffic,
    /// Instructions of a walk with which a wave visits a caster.
    pub visit: Option<u64>,
    /// Time of the compiler on a core [s].
    pub seconds: f64,
}

/// A driver's words on a kernel.
pub struct Said {
    /// By the driver's names.
    pub statistics: Vec<(String, f64)>,
    pub assembly: String,
    /// Time of the compiler on a core [s].
    pub seconds: f64,
}

pub struct Compiler {
    // Loaded as long as the device is used.
    _loaded: (ash::Entry, ash::Instance),
    device: ash::Device,
    properties: properties::Device,
    /// Of the GPU.
    pub name: String,
    /// Whether kernels may ask for subgroups of 32.
    has_32: bool,
}

/// Whose compiler it is.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Driver {
    Radv,
    /// That of this machine's first device which says what kernels need.
    Here,
}

impl Compiler {
    /// None if no device says what its kernels need.
    pub fn new(driver: Driver) -> Result<Option<Self>, Failure> {
        let mut vulkan13 = vk::PhysicalDeviceVulkan13Features::default();
        let mut vulkan12 = vk::PhysicalDeviceVulkan12Features::default();
        let mut vulkan11 = vk::PhysicalDeviceVulkan11Features::default();
        let mut executable = vk::PhysicalDevicePipelineExecutablePropertiesFeaturesKHR::default();
        // SAFETY: Vulkan is loaded once, what is passed outlives the calls, and what is made of it lives as
        // long as the process.
        unsafe {
            let entry = ash::Entry::load()?;
            let application = vk::ApplicationInfo::default().api_version(vk::API_VERSION_1_3);
            let info = vk::InstanceCreateInfo::default().application_info(&application);
            let instance = entry.create_instance(&info, None)?;
            let says = |&device: &vk::PhysicalDevice| {
                let extensions = instance.enumerate_device_extension_properties(device);
                let is = |it: &vk::ExtensionProperties| {
                    it.extension_name_as_c_str() == Ok(properties::NAME)
                };
                extensions.is_ok_and(|extensions| extensions.iter().any(is))
            };
            let devices = instance.enumerate_physical_devices()?;
            let Some(physical) = devices.into_iter().find(says) else { return Ok(None) };
            let mut sizes = vk::PhysicalDeviceSubgroupSizeControlProperties::default();
            let mut own = vk::PhysicalDeviceProperties2::default().push_next(&mut sizes);
            instance.get_physical_device_properties2(physical, &mut own);
            let name = own.properties.device_name_as_c_str()?.to_string_lossy().into_owned();
            if driver == Driver::Radv && !name.contains("RADV") {
                return Err(format!("{name} is not RADV").into());
            }
            let has_32 = (sizes.min_subgroup_size..=sizes.max_subgroup_size).contains(&32)
                && sizes.required_subgroup_size_stages.contains(vk::ShaderStageFlags::COMPUTE);
            let mut asked = vk::PhysicalDeviceFeatures2::default()
                .push_next(&mut vulkan13)
                .push_next(&mut vulkan12)
                .push_next(&mut vulkan11)
                .push_next(&mut executable);
            instance.get_physical_device_features2(physical, &mut asked);
            let enabled = asked.features;
            // Out of the first chain.
            vulkan13.p_next = std::ptr::null_mut();
            vulkan12.p_next = std::ptr::null_mut();
            vulkan11.p_next = std::ptr::null_mut();
            executable.p_next = std::ptr::null_mut();
            executable.pipeline_executable_info = vk::TRUE;
            vulkan12.buffer_device_address_capture_replay = vk::FALSE;
            let queues = [vk::DeviceQueueCreateInfo::default().queue_priorities(&[1.0])];
            let extensions = [properties::NAME.as_ptr()];
            let mut features = vk::PhysicalDeviceFeatures2::default()
                .features(enabled)
                .push_next(&mut vulkan13)
                .push_next(&mut vulkan12)
                .push_next(&mut vulkan11)
                .push_next(&mut executable);
            let info = vk::DeviceCreateInfo::default()
                .queue_create_infos(&queues)
                .enabled_extension_names(&extensions)
                .push_next(&mut features);
            let device = instance.create_device(physical, &info, None)?;
            let properties = properties::Device::new(&instance, &device);
            Ok(Some(Self { _loaded: (entry, instance), device, properties, name, has_32 }))
        }
    }

    /// Compiles a kernel for subgroups of 32 with RADV.
    pub fn compile(&self, dir: &Path, case: &Case) -> Result<Needs, Failure> {
        let Said { statistics: all, assembly, seconds } = self.compiled(dir, case)?;
        let named = |name: &str| {
            let found = all.iter().find(|(known, _)| known == name);
            found
                .map(|&(_, value)| value as u64)
                .ok_or_else(|| format!("RADV does not say {name:?}"))
        };
        Ok(Needs {
            vgprs: named("VGPRs")?,
            spilled: named("Spilled VGPRs")?,
            lds: named("LDS size")?,
            waves: named("Subgroups per SIMD")?,
            instructions: named("Instructions")?,
            code: named("Code size")?,
            traffic: traffic(&assembly),
            visit: visit(&assembly),
            seconds,
        })
    }

    /// Compiles a kernel, for subgroups of 32 where the device can be asked for them.
    pub fn compiled(&self, dir: &Path, case: &Case) -> Result<Said, Failure> {
        let file = dir.join(&case.file);
        let bytes = std::fs::read(&file).map_err(|error| format!("{}: {error}", file.display()))?;
        let words = ash::util::read_spv(&mut std::io::Cursor::new(bytes))?;
        let declared: Vec<_> = case
            .bindings
            .iter()
            .map(|&(number, kind)| {
                vk::DescriptorSetLayoutBinding::default()
                    .binding(number)
                    .descriptor_type(kind)
                    .descriptor_count(1)
                    .stage_flags(vk::ShaderStageFlags::COMPUTE)
            })
            .collect();
        // Each a VkBool32, side by side.
        let place = |(i, &(id, _)): (usize, &(u32, bool))| vk::SpecializationMapEntry {
            constant_id: id,
            offset: 4 * i as u32,
            size: 4,
        };
        let entries: Vec<_> = case.flags.iter().enumerate().map(place).collect();
        let values: Vec<u8> =
            case.flags.iter().flat_map(|&(_, is)| u32::from(is).to_le_bytes()).collect();
        let flags = vk::SpecializationInfo::default().map_entries(&entries).data(&values);
        let entry_point = std::ffi::CString::new(case.entry_point.as_str())?;
        let mut subgroup = vk::PipelineShaderStageRequiredSubgroupSizeCreateInfo::default()
            .required_subgroup_size(32);
        let clock = cpu_time()?;
        // SAFETY: the code was validated when it was exported, what is passed outlives the calls, and
        // nothing is used after it was destroyed.
        unsafe {
            let device = &self.device;
            let module = device
                .create_shader_module(&vk::ShaderModuleCreateInfo::default().code(&words), None)?;
            let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&declared);
            let sets = [device.create_descriptor_set_layout(&info, None)?];
            let info = vk::PipelineLayoutCreateInfo::default().set_layouts(&sets);
            let layout = device.create_pipeline_layout(&info, None)?;
            let mut stage = vk::PipelineShaderStageCreateInfo::default()
                .stage(vk::ShaderStageFlags::COMPUTE)
                .module(module)
                .name(&entry_point)
                .specialization_info(&flags);
            if self.has_32 {
                stage = stage.push_next(&mut subgroup);
            }
            let info = [vk::ComputePipelineCreateInfo::default()
                .flags(
                    vk::PipelineCreateFlags::CAPTURE_STATISTICS_KHR
                        | vk::PipelineCreateFlags::CAPTURE_INTERNAL_REPRESENTATIONS_KHR,
                )
                .stage(stage)
                .layout(layout)];
            let made = device.create_compute_pipelines(vk::PipelineCache::null(), &info, None);
            let pipeline = made.map_err(|(_, error)| error)?[0];
            let seconds = (cpu_time()? - clock).as_secs_f64();
            let info = vk::PipelineExecutableInfoKHR::default().pipeline(pipeline);
            let all = self.properties.get_pipeline_executable_statistics(&info)?;
            let assembly = self.assembly(&info)?;
            device.destroy_pipeline(pipeline, None);
            device.destroy_pipeline_layout(layout, None);
            device.destroy_descriptor_set_layout(sets[0], None);
            device.destroy_shader_module(module, None);
            let value = |it: &vk::PipelineExecutableStatisticKHR<'_>| match it.format {
                vk::PipelineExecutableStatisticFormatKHR::FLOAT64 => it.value.f64,
                vk::PipelineExecutableStatisticFormatKHR::INT64 => it.value.i64 as f64,
                _ => it.value.u64 as f64,
            };
            let name = |it: &vk::PipelineExecutableStatisticKHR<'_>| {
                it.name_as_c_str()
                    .map(|name| name.to_string_lossy().into_owned())
                    .unwrap_or_default()
            };
            let statistics = all.iter().map(|it| (name(it), value(it))).collect();
            Ok(Said { statistics, assembly, seconds })
        }
    }

    /// The compiled kernel's machine code as text; empty if the driver shows none.
    ///
    /// # Safety
    /// The executable's pipeline is alive, and captured its internal representations.
    unsafe fn assembly(&self, info: &vk::PipelineExecutableInfoKHR<'_>) -> Result<String, Failure> {
        // SAFETY: the caller's; the second call has room for as many bytes as the first one named.
        unsafe {
            let device = self.device.handle();
            let get = self.properties.fp().get_pipeline_executable_internal_representations_khr;
            let mut count = 0;
            get(device, info, &mut count, std::ptr::null_mut()).result()?;
            let mut all =
                vec![vk::PipelineExecutableInternalRepresentationKHR::default(); count as usize];
            get(device, info, &mut count, all.as_mut_ptr()).result()?;
            let mut texts: Vec<_> = all.iter().map(|it| vec![0_u8; it.data_size]).collect();
            for (it, text) in all.iter_mut().zip(&mut texts) {
                it.p_data = text.as_mut_ptr().cast();
            }
            get(device, info, &mut count, all.as_mut_ptr()).result()?;
            let is = |it: &vk::PipelineExecutableInternalRepresentationKHR<'_>| {
                it.name_as_c_str().is_ok_and(|name| name == c"Assembly")
            };
            let found = all.iter().zip(texts).find(|(it, _)| is(it));
            Ok(found.map_or_else(String::new, |(_, text)| {
                String::from_utf8_lossy(&text).trim_end_matches('\0').to_owned()
            }))
        }
    }
}

/// Time of this thread on a core: other processes do not count.
fn cpu_time() -> Result<Duration, Failure> {
    let stat = std::fs::read_to_string("/proc/thread-self/schedstat")?;
    Ok(Duration::from_nanos(stat.split(' ').next().unwrap_or_default().parse()?))
}
