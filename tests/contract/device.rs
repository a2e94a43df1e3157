//! Devices: tiers, read-back, and errors that are values.
use crate::common::{gpu, own_gpu};
use gobo::{
    Error,
    gpu::{Backend, Gpu, Selection, Tier},
    wgpu,
};

#[test]
fn core_asks_for_nothing() {
    let gpu = Gpu::new(&Selection { tier: Some(Tier::Core), ..Default::default() }).unwrap();
    assert_eq!(gpu.tier, Tier::Core);
    assert_eq!(gpu.tier_reason, "core: as asked for");
    assert!(!gpu.device.features().intersects(Tier::Native.features()));
    assert_eq!(gpu.device.limits().max_compute_invocations_per_workgroup, 256);
}

#[test]
fn tiers_have_the_features_of_their_kernels_and_no_other_tiers() {
    for &tier in Tier::ALL {
        let gpu = gpu(tier);
        let of_tiers = Tier::Native.features() & gpu.device.features();
        assert_eq!(of_tiers, tier.features(), "{}", gpu.tier_reason);
    }
    assert_eq!(gpu(Tier::Subgroups).tier_reason, "subgroups: as asked for");
    assert_eq!(gpu(Tier::Native).tier_reason, "native: TEXTURE_ATOMIC, SUBGROUP");
}

#[test]
fn names_and_backends_select() {
    let open = |backend, name: &str| {
        Gpu::new(&Selection { backend, adapter: Some(name.to_owned()), tier: None })
    };
    let name = gpu(Tier::Native).adapter.name;
    assert_eq!(open(Backend::Auto, &name.to_uppercase()).unwrap().adapter.name, name);
    match open(Backend::Auto, "no such adapter") {
        Err(Error::Adapter { wanted: Some(wanted), found }) => {
            assert_eq!(wanted, "no such adapter");
            assert!(found.contains(&name), "{found:?}");
        }
        other => panic!("{other:?}"),
    }
    assert!(matches!(open(Backend::Cpu, ""), Err(Error::Adapter { .. })));
}

#[test]
fn texels_come_back_as_they_went() {
    let gpu = gpu(Tier::Native);
    // Rows of 7 texels are not a multiple of the copy's row pitch.
    let texels: Vec<[u32; 2]> = (0..7 * 5 * 3).map(|i| [i, !i]).collect();
    let texture = gpu.texture_array("texels", [7, 5, 3], wgpu::TextureFormat::Rg32Uint);
    gpu.write_texture(&texture, &texels);
    assert_eq!(gpu.try_read_texture::<[u32; 2]>(&texture).unwrap(), texels);
    assert_ne!(
        gpu.try_read_texture::<[u32; 2]>(&texture).unwrap()[1..],
        texels[..texels.len() - 1]
    );
}

/// Two layers of 128 MiB and a little more, where a buffer has 256 MiB at most.
#[test]
#[ignore = "takes 0.8 GB: make test-all"]
fn a_texture_larger_than_any_buffer_comes_back() {
    let gpu = gpu(Tier::Core);
    let (width, height) = (8192, 4100);
    assert!(2 * 4 * u64::from(width * height) > gpu.device.limits().max_buffer_size);
    let texture = gpu.texture_array("texels", [width, height, 2], wgpu::TextureFormat::R32Uint);
    let corners = [(0, 0, 0), (width - 1, height - 1, 0), (0, 0, 1), (width - 1, height - 1, 1)];
    for (value, (x, y, z)) in (1_u32..).zip(corners) {
        gpu.queue.write_texture(
            wgpu::TexelCopyTextureInfo {
                origin: wgpu::Origin3d { x, y, z },
                ..texture.as_image_copy()
            },
            &value.to_le_bytes(),
            wgpu::TexelCopyBufferLayout::default(),
            wgpu::Extent3d { width: 1, height: 1, depth_or_array_layers: 1 },
        );
    }
    let texels: Vec<u32> = gpu.try_read_texture(&texture).unwrap();
    assert_eq!(texels.len(), 2 * (width * height) as usize);
    for (value, (x, y, z)) in (1..).zip(corners) {
        assert_eq!(texels[((z * height + y) * width + x) as usize], value);
    }
    assert_eq!(texels.iter().filter(|&&texel| texel > 0).count(), corners.len());
}

#[test]
fn a_refused_command_is_an_error_once() {
    let gpu = own_gpu(Tier::Native);
    let usage = wgpu::BufferUsages::STORAGE;
    let unreadable = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("unreadable"),
        size: 16,
        usage,
        mapped_at_creation: false,
    });
    assert!(gpu.check().is_ok());
    assert!(matches!(gpu.try_read::<u32>(&unreadable), Err(Error::Refused(_))));
    assert!(gpu.check().is_ok());
    let readable = gpu.upload("readable", &[1u32; 4], usage | wgpu::BufferUsages::COPY_SRC);
    assert_eq!(gpu.try_read::<u32>(&readable).unwrap(), [1; 4]);
}
