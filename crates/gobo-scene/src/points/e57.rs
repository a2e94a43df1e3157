//! E57 (ASTM E2807): the scans of a file, each placed by its pose.
use super::{DAMAGED, Fault, Point, Points, Room, linear};
use e57::{CartesianCoordinate, E57Reader};
use glam::DVec3;
use std::io::Cursor;

pub(super) fn read(bytes: &[u8], room: Room) -> Result<Points, Fault> {
    let bad = |error: e57::Error| (format!("not a valid E57 file: {error}"), DAMAGED);
    let mut file = E57Reader::new(Cursor::new(bytes)).map_err(bad)?;
    let scans = file.pointclouds();
    let count = scans.iter().fold(0, |sum: u64, scan| sum.saturating_add(scan.records));
    room.check(count)?;
    let mut points = Points::default();
    points.reserve(count as usize)?;
    for scan in &scans {
        let mut reader = file.pointcloud_simple(scan).map_err(bad)?;
        reader.intensity_to_color(false);
        for point in reader {
            let point = point.map_err(bad)?;
            let CartesianCoordinate::Valid { x, y, z } = point.cartesian else {
                points.skip("no echo");
                continue;
            };
            points.push(Point {
                position: DVec3::new(x, y, z),
                color: point.color.map(|color| linear([color.red, color.green, color.blue])),
                intensity: point.intensity.filter(|echo| echo.is_finite()),
                class: None,
            });
        }
    }
    if !file.images().is_empty() {
        points.notes.push(format!("{} images are not read", file.images().len()));
    }
    Ok(points)
}
