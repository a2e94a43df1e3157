//! `--preview`: all frames of a job as one animated PNG.
use super::{failure::Failure, files::Pending};
use gobo::{glam::UVec2, records::Picture};
use std::{fs::File, path::Path};

/// Most frames of an animated PNG.
const MOST: usize = i32::MAX as usize;

/// Frames so far, in a temporary file until the last one is there.
pub(super) struct Preview {
    file: Pending,
    writer: png::Writer<File>,
    size: UVec2,
}

impl Preview {
    /// `frames`: number of frames; `fps`: frames per second.
    pub(super) fn new(path: &Path, size: UVec2, frames: usize, fps: f64) -> Result<Self, Failure> {
        if frames > MOST {
            let message = format!("{frames} frames, but an animated PNG has at most {MOST}");
            return Err(Failure::Usage(format!("{}: {message}", path.display())));
        }
        let file = Pending::new(path)?;
        let writer = file.writer().map_err(|source| Failure::file(path, source))?;
        let mut encoder = png::Encoder::new(writer, size.x, size.y);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        let [seconds, per] = delay(fps);
        let mut start = || {
            encoder.set_animated(frames as u32, 0)?;
            encoder.set_frame_delay(seconds, per)
        };
        start().map_err(|error| failed(path, error))?;
        let writer = encoder.write_header().map_err(|error| failed(path, error))?;
        Ok(Self { file, writer, size })
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
        self.writer.write_image_data(rgb).map_err(|error| failed(self.file.path(), error))
    }

    /// Gives the file its name.
    pub(super) fn finish(self) -> Result<(), Failure> {
        self.writer.finish().map_err(|error| failed(self.file.path(), error))?;
        self.file.finish()
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
