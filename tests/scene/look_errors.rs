//! Error of classification before interpolation, on a scan with thin bones and a thin skin.
use crate::common::{files::read, scenes::Chance};
use gobo::{
    glam::{DVec3, UVec3},
    model::Grid,
};

/// Opacities of the table `body`, by value.
const BODY: [(f64, f64); 5] =
    [(-400.0, 0.0), (-100.0, 0.01), (60.0, 0.04), (250.0, 0.15), (1000.0, 1.0)];
/// Extinction at opacity 1 [1/m].
const FACTOR: f64 = 400.0;

fn opacity(value: f64) -> f64 {
    let after = BODY.iter().position(|&(at, _)| at > value).unwrap_or(BODY.len());
    let Some(&(low, start)) = after.checked_sub(1).and_then(|i| BODY.get(i)) else { return 0.0 };
    let Some(&(high, end)) = BODY.get(after) else { return start };
    start + (end - start) * (value - low) / (high - low)
}

/// Sum of voxel grids.
struct Field {
    size: usize,
    values: Vec<f64>,
}

impl Field {
    fn of(grids: &[Grid], size: usize) -> Self {
        let mut values = vec![0.0; size * size * size];
        for grid in grids {
            for brick in &grid.bricks {
                let voxels = brick.voxels().expect("no box");
                for i in 0..512_u32 {
                    let own = UVec3::new(i % 8, i / 8 % 8, i / 64);
                    let at = brick.origin + own.as_ivec3();
                    if at.min_element() >= 0 && at.max_element() < size as i32 {
                        let [x, y, z] = at.to_array().map(|at| at as usize);
                        values[(z * size + y) * size + x] +=
                            f64::from(voxels.at(own)) * f64::from(grid.factor);
                    }
                }
            }
        }
        Self { size, values }
    }

    fn at(&self, point: DVec3, of_voxel: impl Fn(f64) -> f64) -> f64 {
        let (cell, part) = (point.floor(), point.fract());
        let corner = |i: usize| {
            let up = DVec3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2) as f64);
            let weights = up * part + (1.0 - up) * (1.0 - part);
            let [x, y, z] = (cell + up).to_array().map(|at| at as usize);
            let value = self.values[(z * self.size + y) * self.size + x];
            weights.element_product() * of_voxel(value)
        };
        (0..8).map(corner).sum()
    }
}

/// Mean and 99th percentile of the light's difference along rays from front to back.
fn errors(voxels: u32) -> [f64; 2] {
    let chest = |keys: &str| {
        let table =
            format!("[[volume]]\ngenerate = {{ kind = \"chest\", voxels = {voxels} }}\n{keys}");
        read(&table).unwrap_or_else(|error| panic!("{error}"))
    };
    let (values, shown) = (chest("window = [-1000, 1600]\n"), chest("colors = \"body\"\n"));
    let size = voxels as usize + 2;
    let (values, shown) = (Field::of(&values.grids, size), Field::of(&shown.grids, size));
    let edge = 0.4 / f64::from(voxels);
    let (width, depth) = (0.36 / edge, 0.26 / edge);
    let mut chance = Chance::new(5);
    let mut differences = Vec::new();
    for _ in 0..400 {
        let mut axis = |size: f64| 1.0 + f64::from(chance.unit()) * (size - 4.0);
        let (x, y) = (axis(width), axis(f64::from(voxels)));
        let steps = (depth as usize - 2) * 8;
        let (mut before, mut after) = (0.0, 0.0);
        for i in 0..steps {
            let point = DVec3::new(x, y, 0.0625 + i as f64 / 8.0);
            before += shown.at(point, |density| density) * edge / 8.0;
            after += opacity(values.at(point, |share| share) * 2600.0 - 1000.0) * edge / 8.0;
        }
        differences.push(((-FACTOR * before).exp() - (-FACTOR * after).exp()).abs());
    }
    differences.sort_unstable_by(f64::total_cmp);
    [differences.iter().sum::<f64>() / 400.0, differences[396]]
}

#[test]
fn voxels_are_classified_before_they_are_interpolated() {
    let [coarse, fine] = [64, 160].map(errors);
    // docs/grids.md states them.
    assert!(coarse[0] < 0.03 && coarse[1] < 0.3, "{coarse:?}");
    assert!(fine[0] < 0.007 && fine[1] < 0.13, "{fine:?}");
    assert!(fine[0] < coarse[0] && fine[0] > 1e-5, "{fine:?}, {coarse:?}");
}
