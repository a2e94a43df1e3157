//! The look-up of light for a host's shaders, in its shading language.
use super::{
    export::{BindingEntry, binding_entry},
    failure::Failure,
    files, output,
    translate::{Kernel, translate},
    values::Target,
};
use gobo::shadows::look_up_text;
use serde::Serialize;
use std::path::Path;

/// A text of the manifest.
#[derive(Serialize)]
pub(super) struct LookUp {
    file: String,
    /// Nodes of the maps' curves; 0 without curves.
    nodes: u32,
    /// Whether some caster may have the `gain` or the `over` transfer.
    gain: bool,
    bindings: Vec<BindingEntry>,
}

const PREFIX: &str = "gobo_";

/// Uses every function, so that none is removed. Parts that only a whole shader needs are around it.
const PROBE: &str = "
@compute @workgroup_size(1)
fn gobo_probe(@builtin(global_invocation_id) id: vec3<u32>) {
    let position = vec3<f32>(id);
    _ = gobo_light_through(id.x, position, position);
    _ = gobo_light_at(id.x, position);
}
";
/// Macro around the parts that only a whole shader needs.
const GUARD: &str = "GOBO_PROBE";

/// Writes a text for each kind of maps. None for SPIR-V: it cannot be combined with other sources.
pub(super) fn write(target: Target, out: &Path) -> Result<Vec<LookUp>, Failure> {
    let mut texts = Vec::new();
    if target == Target::Spirv {
        return Ok(texts);
    }
    for (nodes, gain) in
        [(0, false), (4, false), (4, true), (8, false), (8, true), (16, false), (16, true)]
    {
        let wrong = |reason| Failure::Wrong(format!("the look-up of light: {reason}"));
        let (wgsl, bindings) = look_up_text(nodes, gain, 0, PREFIX)?;
        let kernel = Kernel::new("gobo_probe", wgsl.clone() + PROBE, &[], target).map_err(wrong)?;
        let translation = translate(&kernel).map_err(wrong)?;
        let text = match target {
            Target::Wgsl => wgsl,
            _ => guarded(&String::from_utf8_lossy(&translation.source)),
        };
        let extension = match target {
            Target::Glsl => "glsl",
            _ => target.extension(),
        };
        let file = format!("light_n{nodes}{}.{extension}", if gain { "_gain" } else { "" });
        output::write(&out.join(&file), text.as_bytes())?;
        files::print(&out.join(&file).display().to_string())?;
        let bindings =
            bindings.iter().map(|it| binding_entry(it, &kernel, &translation.slots)).collect();
        texts.push(LookUp { file, nodes, gain, bindings });
    }
    Ok(texts)
}

/// The text with the parts of a whole shader, and the probe, inside guards.
fn guarded(text: &str) -> String {
    let whole =
        ["#version", "#extension GL_ARB_compute_shader", "layout(local_size_x", "precision "];
    let lines = text.lines().filter(|line| !whole.iter().any(|start| line.starts_with(start)));
    let (mut part, mut probe) = (String::new(), String::new());
    let starts = ["void main()", "[numthreads(", "kernel void gobo_probe("];
    for line in lines {
        let is_probe = !probe.is_empty() || starts.iter().any(|start| line.starts_with(start));
        let to = if is_probe { &mut probe } else { &mut part };
        *to += line;
        *to += "\n";
    }
    format!("{}\n\n#ifdef {GUARD}\n{probe}#endif\n", part.trim())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_has_no_entry_point_unless_it_is_asked_for() {
        let glsl = "#version 450 core\nlayout(local_size_x = 1, local_size_y = 1) in;\n\nfloat f() {\n}\n\n\
                    void main() {\n    f();\n}\n";
        let wanted = "float f() {\n}\n\n#ifdef GOBO_PROBE\nvoid main() {\n    f();\n}\n#endif\n";
        assert_eq!(guarded(glsl), wanted);
    }
}
