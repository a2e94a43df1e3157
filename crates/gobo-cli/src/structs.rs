//! Layouts of the structs in kernels' bindings, for `frame.json`.
use gobo::{
    gpu::Kernel,
    records::{CasterRecord, Field, GpuLayout, TriangleRecord},
};
use naga::{Module, TypeInner};
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;

/// Layouts of all structs of the kernels, and of the records that the host writes.
pub(super) fn structs<'a>(kernels: impl Iterator<Item = &'a Kernel>) -> Map<String, Value> {
    let mut found = BTreeMap::new();
    kernels.filter_map(Kernel::module).for_each(|module| add_structs(module, &mut found));
    found.insert(CasterRecord::NAME.to_owned(), host_struct::<CasterRecord>());
    found.insert(TriangleRecord::NAME.to_owned(), host_struct::<TriangleRecord>());
    found.into_iter().collect()
}

fn host_struct<T: GpuLayout>() -> Value {
    let field =
        |Field { name, offset, size }| json!({ "name": name, "offset": offset, "size": size });
    let fields: Vec<_> = T::fields().into_iter().map(field).collect();
    json!({ "size": T::SIZE, "fields": fields })
}

/// Adds the structs in buffers, and those nested in them.
fn add_structs(module: &Module, found: &mut BTreeMap<String, Value>) {
    let mut layouter = naga::proc::Layouter::default();
    if layouter.update(module.to_ctx()).is_err() {
        return;
    }
    let bound = module.global_variables.iter().filter(|(_, global)| global.binding.is_some());
    let mut pending: Vec<_> = bound.map(|(_, global)| global.ty).collect();
    while let Some(ty) = pending.pop() {
        match &module.types[ty].inner {
            &TypeInner::Array { base, .. } => pending.push(base),
            TypeInner::Struct { members, span } => {
                pending.extend(members.iter().map(|member| member.ty));
                let field = |member: &naga::StructMember| {
                    json!({
                        "name": member.name,
                        "type": type_name(module, member.ty),
                        "offset": member.offset,
                        "size": layouter[member.ty].size,
                    })
                };
                let fields: Vec<_> = members.iter().map(field).collect();
                let name = module.types[ty].name.clone().unwrap_or_default();
                found.insert(name, json!({ "size": span, "fields": fields }));
            }
            _ => {}
        }
    }
}

/// Name of a type in WGSL.
fn type_name(module: &Module, ty: naga::Handle<naga::Type>) -> String {
    let scalar = |scalar: naga::Scalar| match scalar.kind {
        naga::ScalarKind::Sint => "i32",
        naga::ScalarKind::Float => "f32",
        _ => "u32",
    };
    match module.types[ty].inner {
        TypeInner::Scalar(of) | TypeInner::Atomic(of) => scalar(of).to_owned(),
        TypeInner::Vector { size, scalar: of } => format!("vec{}<{}>", size as u32, scalar(of)),
        TypeInner::Matrix { columns, rows, scalar: of } => {
            format!("mat{}x{}<{}>", columns as u32, rows as u32, scalar(of))
        }
        TypeInner::Array { base, size: naga::ArraySize::Constant(count), .. } => {
            format!("array<{}, {count}>", type_name(module, base))
        }
        TypeInner::Array { base, .. } => format!("array<{}>", type_name(module, base)),
        _ => module.types[ty].name.clone().unwrap_or_default(),
    }
}
