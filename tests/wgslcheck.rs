#[test]
fn all_valid() {
    use naga::valid::*;
    let mut bad = 0;
    for d in gobo::stage::KERNELS {
        let w = d.wgsl();
        match naga::front::wgsl::parse_str(&w) {
            Err(e) => { bad += 1; let l = e.location(&w).map(|l| d.locate(l.offset as usize)); println!("{} {:?}: {}", d.name, l, e.emit_to_string(&w)); }
            Ok(m) => {
                let caps = if d.tier == gobo::gpu::Tier::Core { Capabilities::SHADER_FLOAT16_IN_FLOAT32 } else { Capabilities::SHADER_FLOAT16_IN_FLOAT32 | Capabilities::SUBGROUP | Capabilities::TEXTURE_ATOMIC };
                let mut v = Validator::new(ValidationFlags::all(), caps);
                v.subgroup_stages(ShaderStages::COMPUTE).subgroup_operations(SubgroupOperationSet::all());
                if let Err(e) = v.validate(&m) { bad += 1; println!("{}: {}", d.name, e.emit_to_string_with_path(&w, d.name)); }
            }
        }
    }
    assert_eq!(bad, 0);
}
