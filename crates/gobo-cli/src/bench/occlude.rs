//! Benchmark of opaque triangles against a depth-only raster pass.
//!
//! The compute frame is complete: it also fills the (empty) filter map, which the raster pass does not
//! have.
use super::{
    case::Case,
    measure::{Bench, Held, RasterRow, Row},
    raster::{
        agree::{Difference, agree_on_depth},
        depth::DepthPass,
    },
};
use crate::failure::Failure;
use gobo::model::{Casters, Material, Transfer};

/// Largest share of texels with different depths: a rasterizer snaps corners to 1/256 texel, so texels this
/// close to an edge may fall on either side. For an equilateral triangle of bounding side `side`, perimeter
/// over area is about 8 / side.
fn limit(side: f32) -> f64 {
    0.002 + 8.0 / f64::from(side) / 256.0
}

impl Bench {
    pub(super) fn run_occlude(&mut self, case: Case) -> Result<Row, Failure> {
        let (triangles, views) =
            tracing::debug_span!("generate").in_scope(|| (case.triangles(), case.views()));
        let material = Material { transfer: Transfer::Opaque, ..Material::default() };
        let materials = [material];
        let casters =
            Casters { triangles: &triangles, materials: &materials, ..Casters::default() };
        let prepared = self.prepare(&casters, &views)?;
        let opaques: Vec<f32> = self.gpu.try_read_texture(&prepared.maps().opaques)?;
        let width = prepared.maps().opaques.width() as usize;
        let size = case.size as usize;
        let ours: Vec<f32> =
            opaques.chunks_exact(width).take(size).flat_map(|row| &row[..size]).copied().collect();
        let raster = DepthPass::new(&self.gpu, &triangles, &views[0]);
        self.clock.time(&self.gpu, |encoder| raster.record(encoder))?;
        let theirs = raster.read(&self.gpu)?;
        let share = agree_on_depth(&ours, &theirs, limit(case.footprint)).map_err(|wrong| {
            Failure::Wrong(format!("{case}: the depths differ, no time is given: {wrong}"))
        })?;
        let times = self.times(&prepared, &[&|encoder| raster.record(encoder)])?;
        let row = RasterRow {
            raster_ms: times[1].median,
            raster_min: times[1].min,
            raster_max: times[1].max,
            ratio: times[1].median / times[0].median,
            raster_one_pass_ms: times[1].median,
            raster_two_pass_ms: None,
            raster_geometry: "triangles",
            held: Held {
                difference: Difference { depth_share: share, ..Difference::default() },
                difference_float: None,
            },
        };
        self.row(case, &prepared, times[0], Some(row))
    }
}
