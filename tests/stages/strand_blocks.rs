//! Blocks of texels that subgroups cull strands for: whatever a block's shape and a device's rounding, none
//! with a texel that meets a strand is passed by.
use crate::common::scenes::{Chance, view_from_origin};
use gobo::{
    glam::{UVec2, Vec2, Vec4},
    model::{Material, Projection, Shape, Strand, StrandVertex, Transfer},
    records::{Capsules, CasterRecord, Footprint, GpuMaterial, GpuView},
};
use gobo_reference::{
    capsule::{CapsuleSetup, capsule_hit, capsule_touches, project_capsule},
    project::{ProjectParams, Projected},
};

const SIZE: u32 = 64;
/// Columns and rows of blocks of subgroups of 4 to 64, and of one texel.
pub(super) const SHAPES: [[u32; 2]; 8] =
    [[1, 1], [4, 1], [8, 1], [8, 2], [8, 4], [8, 8], [8, 16], [16, 16]];
/// Largest rounding of a projected length, as a share of it: some units in the last place.
const ROUNDING: f32 = 4.0 * f32::EPSILON;

fn view(projection: Projection, near: f32) -> GpuView {
    view_from_origin(projection, SIZE, [near, 10.0], 8.0)
}

/// A strand of three vertices around the light or before it, straight to sharply bent.
fn random(chance: &mut Chance) -> Strand {
    let around = [0.3, 1.0, 4.0][chance.below(3)];
    let mut position = chance.vec3(-around, around);
    let mut radius = 0.002 * 100.0_f32.powf(chance.unit());
    let vertices = (0..3).map(|_| {
        let vertex = StrandVertex { position, radius, color: Vec4::new(0.5, 0.5, 0.5, 0.9) };
        position += chance.vec3(-1.0, 1.0) * [0.05, 1.0, 10.0][chance.below(3)];
        radius *= chance.within(0.5, 1.5);
        vertex
    });
    Strand { vertices: vertices.collect(), material: 0, id: 0 }
}

/// The footprint as other roundings may give it.
fn rounded(footprint: Footprint, chance: &mut Chance) -> Footprint {
    let half = Vec2::new(f32::from_bits(footprint.red_green), f32::from_bits(footprint.blue_slope));
    let most = (footprint.center.abs().max_element() + half.abs().max_element()) * ROUNDING;
    let mut off = || Vec2::new(chance.within(-most, most), chance.within(-most, most));
    let (center, half) = (footprint.center + off(), half + off());
    Footprint { center, red_green: half.x.to_bits(), blue_slope: half.y.to_bits(), ..footprint }
}

#[test]
fn no_block_of_a_strand_is_passed_by() {
    let material = Material { shape: Shape::Capsule, ..Material::default() };
    let of_material = GpuMaterial::new(&material, &[]);
    let params = ProjectParams { scatter: false, include_non_casters: false, by_distance: false };
    let mut chance = Chance::new(7);
    let views = [0.1, 0.01, 0.001].map(|near| view(Projection::Perspective, near));
    for view in views.into_iter().chain([view(Projection::Orthographic, 0.0)]) {
        // Blocks that a strand meets, and that are visited for it.
        let (mut met, mut visited) = (0, 0);
        for _ in 0..2000 {
            let capsules = Capsules::new(&[random(&mut chance)]);
            for (record, particle) in capsules.records.iter().zip(&capsules.particles) {
                let caster = CasterRecord::new(particle, &material);
                let projected =
                    project_capsule(&view, 0, (&caster, 0), record, &of_material, params);
                let setup = CapsuleSetup::new(&view, record);
                let color = Vec4::new(0.5, 0.5, 0.5, 0.9);
                let is_hit = |x: u32, y: u32| {
                    let texel = UVec2::new(x, y).as_vec2() + 0.5;
                    capsule_hit(&view, &setup, Transfer::Filter, color, texel, 1.0).is_some()
                };
                let hits: Vec<_> = (0..SIZE * SIZE).map(|i| is_hit(i % SIZE, i / SIZE)).collect();
                if projected == Projected::INVISIBLE {
                    assert!(!hits.contains(&true), "{record:?}");
                    continue;
                }
                let footprint = rounded(projected.footprint, &mut chance);
                for shape in SHAPES {
                    for (x, y) in (0..SIZE)
                        .step_by(shape[1] as usize)
                        .flat_map(|y| (0..SIZE).step_by(shape[0] as usize).map(move |x| (x, y)))
                    {
                        let is_met = (y..y + shape[1])
                            .any(|y| (x..x + shape[0]).any(|x| hits[(y * SIZE + x) as usize]));
                        let lo = UVec2::new(x, y).as_vec2() + 0.5;
                        let hi = lo + UVec2::from(shape).as_vec2() - 1.0;
                        let touches = capsule_touches(&footprint, lo, hi);
                        assert!(
                            touches || !is_met,
                            "{shape:?} at {x}, {y}: {record:?} {footprint:?}"
                        );
                        met += u32::from(is_met);
                        visited += u32::from(touches);
                    }
                }
            }
        }
        println!("{met} of {visited}");
        // Strands around the light may be anywhere.
        assert!(met > 100_000 && visited < 10 * met, "{met} of {visited}");
    }
}
