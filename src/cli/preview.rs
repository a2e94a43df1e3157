//! `--preview`: all frames of a job as one animated PNG.
use super::{failure::Failure, files};
use gobo::{glam::UVec2, records::Picture};
use std::{
    cell::RefCell,
    io,
    path::{Path, PathBuf},
    rc::Rc,
};

/// Frames so far; the file is written after the last one.
pub(super) struct Preview {
    path: PathBuf,
    writer: png::Writer<Bytes>,
    bytes: Bytes,
    size: UVec2,
}

/// Bytes of the file, shared by its writer and the preview.
#[derive(Clone, Default)]
struct Bytes(Rc<RefCell<Vec<u8>>>);

impl io::Write for Bytes {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.borrow_mut().extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Preview {
    /// `frames`: number of frames; `fps`: frames per second.
    pub(super) fn new(path: &Path, size: UVec2, frames: u32, fps: f64) -> Result<Self, Failure> {
        let bytes = Bytes::default();
        let mut encoder = png::Encoder::new(bytes.clone(), size.x, size.y);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        let [seconds, per] = delay(fps);
        let mut start = || {
            encoder.set_animated(frames, 0)?;
            encoder.set_frame_delay(seconds, per)
        };
        start().map_err(|error| failed(path, error))?;
        let writer = encoder.write_header().map_err(|error| failed(path, error))?;
        Ok(Self { path: path.to_owned(), writer, bytes, size })
    }

    pub(super) fn add(&mut self, picture: &Picture) -> Result<(), Failure> {
        self.add_rgb(picture.rgb.as_flattened())
    }

    /// Adds a frame that exists already.
    pub(super) fn add_file(&mut self, file: &Path) -> Result<(), Failure> {
        let unlike = |message: String| Failure::Usage(format!("{}: {message}", file.display()));
        let image = image::open(file).map_err(|error| unlike(error.to_string()))?.into_rgb8();
        if UVec2::from(image.dimensions()) != self.size {
            return Err(unlike("has another size than the scene's pictures".to_owned()));
        }
        self.add_rgb(image.as_raw())
    }

    fn add_rgb(&mut self, rgb: &[u8]) -> Result<(), Failure> {
        self.writer.write_image_data(rgb).map_err(|error| failed(&self.path, error))
    }

    /// Writes the file atomically.
    pub(super) fn finish(self) -> Result<(), Failure> {
        self.writer.finish().map_err(|error| failed(&self.path, error))?;
        files::write(&self.path, &self.bytes.0.borrow())
    }
}

fn failed(path: &Path, error: png::EncodingError) -> Failure {
    Failure::file(path, error.into())
}

/// Duration of a frame [s], as numerator and denominator.
fn delay(fps: f64) -> [u16; 2] {
    // Integer rates are exact; for others both numbers are as large as 16 bits allow.
    let per = if fps.fract() == 0.0 { fps } else { 6e4 * fps.min(1.0) };
    [(per / fps).round() as u16, per.round().max(1.0) as u16]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn delays_are_those_of_the_rate() {
        for fps in [24.0, 25.0, 1.0, 1000.0, 0.5, 0.001, 29.97, 23.976, 12.5] {
            let [seconds, per] = delay(fps).map(f64::from);
            assert!((seconds / per * fps - 1.0).abs() < 1e-3, "{fps}: {seconds}/{per}");
        }
        assert_eq!(delay(24.0), [1, 24]);
    }
}
