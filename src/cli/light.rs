//! `gobo light`: share of each light that reaches given points.
use super::{arguments::LightArguments, failure::Failure, files, memory::Needs, npy};
use gobo::{glam::Vec3, model::ReceiverPoint, render::Renderer, scene};
use std::{fs, path::Path};

/// Largest coordinate of a point, like that of scenes [m].
const FARTHEST: f32 = 1e7;

pub(crate) fn run(arguments: &LightArguments) -> Result<(), Failure> {
    let length = length(&arguments.points)?;
    let mut load = scene::LoadOptions::default();
    load.set.clone_from(&arguments.set);
    load.emitters = false;
    let mut scene = scene::load_as(&arguments.scene, &load)?;
    // A point has at least three numbers; the file itself is read as a whole.
    let count = length / size_of::<Vec3>() as u64;
    Needs { points: count, ..Needs::of(arguments.backend()) }.check(&scene)?;
    let points = read(&arguments.points)?;
    files::warn(&scene.notes);
    scene.set_time(f64::from(arguments.frame) / arguments.fps);
    let mut renderer = Renderer::new(arguments.backend(), arguments.adapter.as_deref())?;
    tracing::info!("looking light up with {}", renderer.device());
    let shares = renderer.light_points(&scene, &points)?;
    let values = shares.as_flattened().iter().copied();
    let bytes = npy::encode(&[points.len(), scene.lights.len(), 3], values);
    files::write(&arguments.out, &bytes)?;
    files::print(&arguments.out.display().to_string())
}

fn refused(path: &Path, reason: impl std::fmt::Display) -> Failure {
    Failure::Usage(format!("{}: {reason}", path.display()))
}

/// Length of the file [bytes].
fn length(path: &Path) -> Result<u64, Failure> {
    let metadata = fs::metadata(path).map_err(|error| refused(path, error))?;
    if !metadata.is_file() {
        return Err(refused(path, "is no plain file: name an array that numpy.save wrote"));
    }
    Ok(metadata.len())
}

fn read(path: &Path) -> Result<Vec<ReceiverPoint>, Failure> {
    let bytes = fs::read(path).map_err(|error| refused(path, error))?;
    points(&bytes).map_err(|reason| refused(path, reason))
}

/// Parses the points of a file.
fn points(bytes: &[u8]) -> Result<Vec<ReceiverPoint>, String> {
    let (shape, values) = npy::decode(bytes)?;
    let &[_, columns @ (3 | 6)] = &shape[..] else {
        return Err(format!(
            "its shape is {shape:?}: N x 3 positions or N x 6 positions and normals are needed"
        ));
    };
    let rows = values.chunks_exact(columns).enumerate();
    rows.map(|(row, values)| point(values).ok_or_else(|| refusal(row, values))).collect()
}

/// `None` if a number is not finite or a position is too far away.
fn point(row: &[f32]) -> Option<ReceiverPoint> {
    let position = Vec3::from_slice(row);
    let normal = row.get(3..).filter(|rest| !rest.is_empty()).map_or(Vec3::ZERO, Vec3::from_slice);
    let is_near = position.abs().max_element() <= FARTHEST;
    // A normal of length zero is none.
    let normal = if normal == Vec3::ZERO { normal } else { normal.try_normalize()? };
    (position.is_finite() && is_near).then_some(ReceiverPoint { position, normal })
}

fn refusal(row: usize, values: &[f32]) -> String {
    format!(
        "row {row} is {values:?}: positions must be finite and within {FARTHEST:.0} m, normals \
         finite; remove or mend it"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_points() {
        let bytes = npy::encode(&[1, 6], [1.0, 2.0, 3.0, 0.0, -2.0, 0.0].into_iter());
        let read = points(&bytes).unwrap();
        let expected = ReceiverPoint { position: Vec3::new(1.0, 2.0, 3.0), normal: Vec3::NEG_Y };
        assert_eq!(read, [expected]);
        let bytes = npy::encode(&[2, 3], [0.5; 6].into_iter());
        let plain = ReceiverPoint { position: Vec3::splat(0.5), normal: Vec3::ZERO };
        assert_eq!(points(&bytes).unwrap(), [plain; 2]);
        assert_eq!(points(&npy::encode(&[0, 3], [].into_iter())).unwrap(), []);
    }

    #[test]
    fn what_is_no_point_names_its_row() {
        let refused = |shape: &[usize], values: &[f32]| {
            points(&npy::encode(shape, values.iter().copied())).unwrap_err()
        };
        for bad in [f32::NAN, f32::INFINITY, 2e7] {
            let error = refused(&[2, 3], &[0.0, 0.0, 0.0, 0.0, bad, 0.0]);
            assert!(error.starts_with("row 1 "), "{error}");
        }
        let error = refused(&[1, 6], &[0.0, 0.0, 0.0, f32::NAN, 1.0, 0.0]);
        assert!(error.starts_with("row 0 "), "{error}");
        for shape in [&[6][..], &[3, 2], &[1, 2, 3], &[1, 4]] {
            let values = vec![0.0; shape.iter().product()];
            assert!(refused(shape, &values).contains("N x 3"), "{shape:?}");
        }
    }
}
