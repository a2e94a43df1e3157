//! `gobo light`: share of each light that reaches given points.
use super::{
    arguments::LightArguments,
    failure::Failure,
    files::{self, Pending},
    memory::Needs,
    npy::{self, Fault},
};
use gobo::{glam::Vec3, model::ReceiverPoint, render::Renderer, scene};
use std::{
    fs::{self, File},
    io::{self, BufReader, Read},
    path::Path,
};

/// Largest coordinate of a point, like that of scenes [m].
const FARTHEST: f32 = 1e7;

pub(crate) fn run(arguments: &LightArguments) -> Result<(), Failure> {
    let path = &arguments.points;
    let length = length(path)?;
    let mut load = scene::LoadOptions::default();
    load.set.clone_from(&arguments.set);
    load.emitters = false;
    let mut scene = scene::load_as(&arguments.scene, &load)?;
    // A point has at least three numbers.
    let count = length / size_of::<Vec3>() as u64;
    Needs { points: count, ..Needs::of(arguments.backend()) }.check(&scene)?;
    let points = File::open(path).map_err(|error| unreadable(path, &error)).and_then(|file| {
        let read = points(BufReader::new(file), length);
        read.map_err(|(message, help)| Failure::refused(path, message, help))
    })?;
    files::warn(&scene.notes);
    let without = points.iter().filter(|point| point.normal == Vec3::ZERO).count();
    if without > 0 && scene.lights.iter().any(|light| light.area().is_some()) {
        tracing::warn!(
            "{without} points have no normal: where they lie on a surface, it shadows them in rings under a light with a \
             source; give rows of a position and a unit normal"
        );
    }
    scene.set_time(f64::from(arguments.frame) / arguments.fps);
    let mut renderer = Renderer::new(arguments.backend(), arguments.adapter.as_deref())?;
    tracing::info!("looking light up with {}", renderer.device());
    let shares = renderer.light_points(&scene, &points)?;
    let shape = [points.len(), scene.lights.len(), 3];
    let out = Pending::new(&arguments.out)?;
    let failed = |source| Failure::file(&arguments.out, source);
    let writer = out.writer().map_err(failed)?;
    npy::write(writer, &shape, shares.as_flattened().iter().copied()).map_err(failed)?;
    out.finish()?;
    files::print(&arguments.out.display().to_string())
}

fn unreadable(path: &Path, error: &io::Error) -> Failure {
    Failure::refused(path, error.to_string(), "check the name, and that the file may be read")
}

/// Length of the file [bytes].
fn length(path: &Path) -> Result<u64, Failure> {
    let metadata = fs::metadata(path).map_err(|error| unreadable(path, &error))?;
    if !metadata.is_file() {
        let help = "name an array that numpy.save wrote";
        return Err(Failure::refused(path, "is no plain file", help));
    }
    Ok(metadata.len())
}

/// Reads the points of a file of `length` bytes.
fn points(file: impl Read, length: u64) -> Result<Vec<ReceiverPoint>, Fault> {
    let mut array = npy::Reader::new(file, length)?;
    let &[rows, columns @ (3 | 6)] = &array.shape[..] else {
        let message = format!("its shape is {:?}", array.shape);
        return Err((message, "N x 3 positions or N x 6 positions and normals are needed"));
    };
    let mut points = Vec::with_capacity(rows);
    for row in 0..rows {
        let position = array.next::<3>()?;
        let normal = if columns == 6 { array.next::<3>()? } else { [0.0; 3] };
        points.push(point(position.into(), normal.into()).ok_or_else(|| {
            let values = &[position, normal].concat()[..columns];
            let help =
                "positions must be finite and within 10000000 m, normals finite; remove or mend it";
            (format!("row {row} is {values:?}"), help)
        })?);
    }
    Ok(points)
}

/// `None` if a number is not finite or a position is too far away.
fn point(position: Vec3, normal: Vec3) -> Option<ReceiverPoint> {
    let is_near = position.is_finite() && position.abs().max_element() <= FARTHEST;
    // A normal of length zero is none.
    let normal = if normal == Vec3::ZERO { normal } else { normal.try_normalize()? };
    is_near.then_some(ReceiverPoint { position, normal })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_points() {
        let parsed = |bytes: &[u8]| points(bytes, bytes.len() as u64);
        let bytes = npy::encode(&[1, 6], [1.0, 2.0, 3.0, 0.0, -2.0, 0.0].into_iter());
        let read = parsed(&bytes).unwrap();
        let expected = ReceiverPoint { position: Vec3::new(1.0, 2.0, 3.0), normal: Vec3::NEG_Y };
        assert_eq!(read, [expected]);
        let bytes = npy::encode(&[2, 3], [0.5; 6].into_iter());
        let plain = ReceiverPoint { position: Vec3::splat(0.5), normal: Vec3::ZERO };
        assert_eq!(parsed(&bytes).unwrap(), [plain; 2]);
        assert_eq!(parsed(&npy::encode(&[0, 3], [].into_iter())).unwrap(), []);
    }

    #[test]
    fn what_is_no_point_names_its_row() {
        let refused = |shape: &[usize], values: &[f32]| {
            let bytes = npy::encode(shape, values.iter().copied());
            let (message, help) = points(&bytes[..], bytes.len() as u64).unwrap_err();
            format!("{message}: {help}")
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
