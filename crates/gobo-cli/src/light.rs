//! `gobo light`: share of each light that reaches given points.
use super::{
    arguments::LightArguments,
    curves,
    failure::Failure,
    files, inputs,
    memory::Needs,
    npy::{self, NpyFault},
    output::{self, Output},
};
use gobo::{Scene, glam::Vec3, model::ReceiverPoint};
use gobo_picture::{PointLookUp, Receivers};
use gobo_scene as scene;
use std::{
    fs::{self, File},
    io::{self, BufReader, Read},
    path::Path,
};

/// Largest coordinate of a point, like that of scenes [m].
const FARTHEST: f32 = 1e7;
/// Most points in memory at a time: as many as a device looks up at once.
const MAX_POINTS: usize = 1 << 22;
/// Most shares in memory at a time: 256 MiB.
const MAX_SHARES: usize = (256 << 20) / size_of::<[f32; 3]>();

pub(crate) fn run(arguments: &LightArguments) -> Result<(), Failure> {
    let path = &arguments.points;
    let length = length(path)?;
    inputs::add(path);
    let mut load = scene::LoadOptions::default();
    load.set.clone_from(&arguments.moment.set);
    load.start = false;
    load.of_picture = false;
    let mut scene = scene::load_as(&arguments.scene, &load)?;
    Output::check(&arguments.out)?;
    let at_a_time = at_a_time(&scene);
    // A point has at least three numbers.
    let count = (length / size_of::<Vec3>() as u64).min(at_a_time as u64);
    Needs { points: count, ..Needs::of(arguments.moment.device.backend()) }.check(&scene)?;
    let refused = |(message, help)| Failure::refused(path, message, help);
    let open = || {
        let file = File::open(path).map_err(|error| unreadable(path, &error))?;
        Points::new(BufReader::new(file), length).map_err(refused)
    };
    // All points are read before the first look-up, which may take long.
    let (mut receivers, mut rows) = (Receivers::default(), 0);
    for point in open()? {
        receivers.add(point.map_err(refused)?.position);
        rows += 1;
    }
    files::warn(&scene.notes);
    scene.set_time(f64::from(arguments.moment.frame) / arguments.moment.fps);
    let mut renderer = arguments.moment.device.renderer()?;
    tracing::info!("looking light up with {}", renderer.device());
    curves::warn_before(&scene);
    let look_up = renderer.point_look_up(&scene, receivers)?;
    let out = Output::new(&arguments.out)?;
    let failed = |source| Failure::file(&arguments.out, source);
    let shape = [rows, scene.lights.len(), 3];
    let mut shares = npy::Writer::new(out.writer().map_err(failed)?, &shape).map_err(failed)?;
    let points = open()?.map(|point| point.map_err(refused));
    write_shares(look_up, points, at_a_time, |some| shares.add(some).map_err(failed))?;
    shares.finish().map_err(failed)?;
    out.finish()?;
    output::print_name(&arguments.out)
}

/// Number of points in memory at a time.
fn at_a_time(scene: &Scene) -> usize {
    (MAX_SHARES / scene.lights.len().max(1)).min(MAX_POINTS)
}

/// Looks up some points at a time.
fn write_shares(
    mut look_up: PointLookUp<'_>,
    mut points: impl Iterator<Item = Result<ReceiverPoint, Failure>>,
    at_a_time: usize,
    mut write: impl FnMut(&[f32]) -> Result<(), Failure>,
) -> Result<(), Failure> {
    loop {
        let some: Vec<_> = points.by_ref().take(at_a_time).collect::<Result<_, _>>()?;
        if some.is_empty() {
            return Ok(());
        }
        write(look_up.shares(&some)?.as_flattened())?;
    }
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

/// Points of a file, row by row.
struct Points<R> {
    array: npy::Reader<R>,
    has_normals: bool,
    row: usize,
    rows: usize,
}

impl<R: Read> Points<R> {
    /// `length`: of the file [bytes].
    fn new(file: R, length: u64) -> Result<Self, NpyFault> {
        let array = npy::Reader::new(file, length)?;
        let &[rows, columns @ (3 | 6)] = &array.shape[..] else {
            let message = format!("its shape is {:?}", array.shape);
            return Err((message, "N x 3 positions or N x 6 positions and normals are needed"));
        };
        Ok(Self { array, has_normals: columns == 6, row: 0, rows })
    }

    fn read(&mut self) -> Result<ReceiverPoint, NpyFault> {
        let position = self.array.next::<3>()?;
        let normal = if self.has_normals { self.array.next::<3>()? } else { [0.0; 3] };
        point(position.into(), normal.into()).ok_or_else(|| {
            let columns = if self.has_normals { 6 } else { 3 };
            let values = &[position, normal].concat()[..columns];
            let help =
                "positions must be finite and within 10000000 m, normals finite; remove or mend it";
            (format!("row {} is {values:?}", self.row), help)
        })
    }
}

impl<R: Read> Iterator for Points<R> {
    type Item = Result<ReceiverPoint, NpyFault>;

    fn next(&mut self) -> Option<Self::Item> {
        (self.row < self.rows).then(|| {
            let point = self.read();
            self.row += 1;
            point
        })
    }
}

/// `None` if a number is not finite or a position is too far away.
fn point(position: Vec3, normal: Vec3) -> Option<ReceiverPoint> {
    let is_near = position.is_finite() && position.abs().max_element() <= FARTHEST;
    // A normal of length zero counts as none.
    let normal = if normal == Vec3::ZERO { normal } else { normal.try_normalize()? };
    is_near.then_some(ReceiverPoint { position, normal })
}

#[cfg(test)]
mod tests {
    use super::*;
    use gobo::{Light, LightKind, Material, Particle, Shape, glam::Vec4};
    use gobo_picture::Renderer;

    fn points(bytes: &[u8]) -> Result<Vec<ReceiverPoint>, NpyFault> {
        Points::new(bytes, bytes.len() as u64)?.collect()
    }

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
            let bytes = npy::encode(shape, values.iter().copied());
            let (message, help) = points(&bytes).unwrap_err();
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

    /// Each point has the same bits, whatever the size of a part.
    #[test]
    fn points_come_back_in_order_whatever_a_part_is() {
        let kind = LightKind::Directional { direction: Vec3::new(-0.3, -1.0, -0.2) };
        let puff = Material { shape: Shape::Puff, ..Material::default() };
        let puffs = (0..9_u8).map(|i| Particle {
            center: Vec3::new(f32::from(i % 3), 1.0, f32::from(i / 3)) * 0.8,
            radius: 0.3,
            color: Vec4::new(0.9, 0.1 * f32::from(i), 0.3, 0.7),
            ..Particle::default()
        });
        let scene = Scene {
            lights: vec![Light { kind, ..Light::default() }],
            materials: vec![puff],
            particles: puffs.collect(),
            ..Scene::default()
        };
        let place = |i: u16| Vec3::new(f32::from(i * 37 % 101), -10.0, f32::from(i)) * 0.02;
        let all: Vec<_> =
            (0..100).map(|i| ReceiverPoint { position: place(i), ..Default::default() }).collect();
        let mut renderer = Renderer::on_cpu();
        let whole = renderer.light_points(&scene, &all).unwrap();
        assert!(whole.iter().any(|share| share[1] < 0.9) && whole.contains(&[1.0; 3]));
        for at_a_time in [1, 7, 99, 100, 4000] {
            let (mut receivers, mut shares) = (Receivers::default(), Vec::new());
            receivers.extend(all.iter().map(|point| point.position));
            let look_up = renderer.point_look_up(&scene, receivers).unwrap();
            let write = |some: &[f32]| {
                assert!(some.len() <= 3 * at_a_time);
                shares.extend_from_slice(some);
                Ok(())
            };
            write_shares(look_up, all.iter().map(|&point| Ok(point)), at_a_time, write).unwrap();
            assert_eq!(shares, whole.as_flattened(), "{at_a_time} at a time");
        }
    }

    #[test]
    fn memory_does_not_grow_with_the_file() {
        let with =
            |count: usize| Scene { lights: vec![Light::default(); count], ..Scene::default() };
        for count in [0, 1, 5, 64, 4096] {
            let at_a_time = at_a_time(&with(count));
            assert!(at_a_time > 1000 && at_a_time * count * size_of::<[f32; 3]>() <= 256 << 20);
        }
    }
}
