//! `gobo merge`: joins the maps of all shares of a scene's casters.
use super::{
    curves::{Curves, Take},
    failure::Failure,
    files, inputs,
    maps::Arrays,
    output::{self, Fill},
    part::{Array, Head, Part},
    sidecar,
};
use gobo::records::{CurveMap, added, resolved};
use gobo_reference::{curve::joined::joined, resolve::resolve};
use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

/// Texels of curves that are joined at a time, each with the nodes of all parts.
const BAND: u64 = 1 << 16;

pub(crate) fn run(paths: &[PathBuf], out: &Path) -> Result<(), Failure> {
    let parts = whole(paths)?;
    let head = &parts[0].head;
    let folder = out.join(sidecar::maps(head.frame));
    inputs::check_folder(&folder, |name| {
        name == "views.json" || head.names.iter().any(|stem| name.starts_with(&format!("{stem}.")))
    })?;
    files::create_dir(&folder)?;
    for view in 0..head.sizes.len() {
        let mut write = |name: &str, contents: Fill<'_>| output::fill(&folder.join(name), contents);
        merge(&parts, view, &mut write)?;
    }
    output::write(&folder.join("views.json"), head.views.as_bytes())?;
    files::print(&folder.display().to_string())
}

/// The parts in the order of their shares; fails unless each share is there once and all are of the same
/// maps.
fn whole(paths: &[PathBuf]) -> Result<Vec<Part>, Failure> {
    let mut parts = BTreeMap::<u32, Part>::new();
    for path in paths {
        let part = Part::open(path)?;
        inputs::add(path);
        let refused = |message, help| Err(Failure::refused(path, message, help));
        let [index, count] = part.head.share;
        if let Some(first) = parts.values().next()
            && let Some(difference) = difference(&part.head, &first.head)
        {
            let message = format!("{difference} than {}", first.path.display());
            return refused(message, "name parts of one job");
        }
        if let Some(Part { path: other, .. }) = parts.insert(index, part) {
            let message = format!("has share {index}/{count}, as {} has", other.display());
            return refused(message, "name each share once");
        }
    }
    let [_, count] = parts.values().next().map_or([0, 0], |part| part.head.share);
    if let Some(missing) = (0..count).find(|index| !parts.contains_key(index)) {
        let message = format!(
            "share {missing}/{count} is missing: name its part too, or write it by `gobo maps --casters \
             {missing}/{count}`"
        );
        return Err(Failure::Usage(message));
    }
    Ok(parts.into_values().collect())
}

/// Name of the property in which two parts of different jobs differ.
fn difference(head: &Head, other: &Head) -> Option<&'static str> {
    let mut same_share = head.clone();
    same_share.share[0] = other.share[0];
    if head.gobo != other.gobo {
        Some("was written by another version")
    } else if head.frame != other.frame {
        Some("is of another frame")
    } else if head.scene != other.scene {
        Some("is of another scene, or of other options,")
    } else if head.share[1] != other.share[1] {
        Some("is of another number of shares")
    } else {
        (same_share != *other).then_some("has other views")
    }
}

/// Writes the maps of a view.
fn merge(
    parts: &[Part],
    view: usize,
    write: &mut impl FnMut(&str, Fill<'_>) -> Result<(), Failure>,
) -> Result<(), Failure> {
    let head = &parts[0].head;
    let texels = head.texels(view);
    let mut sums = vec![[0; 4]; texels as usize];
    let mut opaque = vec![1.0_f32.to_bits(); texels as usize];
    for part in parts {
        let words = part.read(view, Array::Sums, 0..texels)?;
        for (sum, words) in sums.iter_mut().zip(words.chunks_exact(4)) {
            *sum = added(*sum, [words[0], words[1], words[2], words[3]]);
        }
        // Depths 0..=1 are ordered like their bits.
        for (depth, other) in opaque.iter_mut().zip(part.read(view, Array::Opaque, 0..texels)?) {
            *depth = other.min(*depth);
        }
    }
    let texel = |&sums: &[u32; 4]| {
        let (light, nearest) = resolved(sums);
        (resolve(light.into(), false), nearest)
    };
    let (filter, nearest): (Vec<_>, Vec<_>) = sums.iter().map(texel).unzip();
    let colored = parts[0].read(view, Array::Colored, 0..texels)?;
    let colored = colored.chunks_exact(3).map(|texel| [0, 1, 2].map(|i| f32::from_bits(texel[i])));
    let curve = (head.nodes > 0).then(|| joined_curves(parts, view)).transpose()?;
    let give = |take: Take<'_>| curve.as_ref().map_or(Ok(()), take);
    let arrays = Arrays {
        size: head.sizes[view],
        filter: &filter,
        nearest: &nearest,
        opaque: &opaque.into_iter().map(f32::from_bits).collect::<Vec<_>>(),
        colored: &colored.collect::<Vec<_>>(),
        curves: curve.as_ref().map(|curve| Curves { nodes: curve.nodes, give: &give }),
        caustics: Vec::new(),
    };
    arrays.write(write, &head.names[view])
}

fn joined_curves(parts: &[Part], view: usize) -> Result<CurveMap, Failure> {
    let nodes = parts[0].head.nodes;
    let texels = parts[0].head.texels(view);
    let mut packed = Vec::with_capacity(texels as usize * nodes);
    for first in (0..texels).step_by(BAND as usize) {
        let band = first..texels.min(first + BAND);
        let count = (band.end - band.start) as usize;
        let mut curves = Vec::with_capacity(parts.len());
        for part in parts {
            let words = part.read(view, Array::Curve, band.clone())?;
            curves.push(words.chunks_exact(2).map(|node| [node[0], node[1]]).collect::<Vec<_>>());
        }
        for texel in 0..count {
            let of_texel = curves.iter().map(|curve| &curve[texel * nodes..][..nodes]);
            packed.extend(joined(of_texel, nodes));
        }
    }
    Ok(CurveMap { nodes, gain: false, packed })
}
