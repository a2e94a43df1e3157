//! `--preview`: all frames of a job as one animated PNG, or through ffmpeg as one video.
use super::{
    claim::Claim,
    failure::Failure,
    files::{folder, temporaries},
    output::Output,
};
use gobo::{glam::UVec2, records::Picture};
use std::{
    fs::File,
    io::{self, Read as _, Write as _},
    path::Path,
    process::{Child, Command, Stdio},
};

/// Most frames of an animated PNG.
const MAX: usize = i32::MAX as usize;
/// Mark of a preview's origin: only files with it are overwritten.
const MARK: &str = "gobo --preview";

/// Frames so far, in a temporary file until the last one is added.
pub(super) struct Preview {
    file: Output,
    encoder: Encoder,
    size: UVec2,
    /// `None` for a device or pipe.
    _claim: Option<Claim>,
}

enum Encoder {
    Png(png::Writer<File>),
    Video(Ffmpeg),
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Format {
    Png,
    Mp4,
}

impl Preview {
    /// Refuses a name that no preview can have, before the frames are rendered.
    pub(super) fn check(path: &Path, out: &Path) -> Result<(), Failure> {
        format(path)?;
        check_name(path, out)?;
        if path.is_dir() {
            return Err(taken(path));
        }
        Output::check(path)
    }

    /// `out`: folder of the frames; `frames`: their number; `fps`: frames per second.
    pub(super) fn new(path: &Path, size: UVec2, frames: usize, fps: f64) -> Result<Self, Failure> {
        let format = format(path)?;
        if format == Format::Png && frames > MAX {
            let message = format!("{frames} frames, but an animated PNG has at most {MAX}");
            return Err(Failure::refused(path, message, "name an .mp4, or fewer frames"));
        }
        let claim = if Output::is_stream(path)? { None } else { Some(claimed(path, format)?) };
        let file = Output::new(path)?;
        let encoder = match format {
            Format::Png => {
                let writer = file.writer().map_err(|source| Failure::file(path, source))?;
                let start = || {
                    let mut encoder = png::Encoder::new(writer, size.x, size.y);
                    encoder.set_color(png::ColorType::Rgb);
                    encoder.set_depth(png::BitDepth::Eight);
                    encoder.add_text_chunk("Software".to_owned(), MARK.to_owned())?;
                    encoder.set_animated(frames as u32, 0)?;
                    let [seconds, per] = delay(fps);
                    encoder.set_frame_delay(seconds, per)?;
                    encoder.write_header()
                };
                Encoder::Png(start().map_err(|error| Failure::file(path, error.into()))?)
            }
            Format::Mp4 => Encoder::Video(Ffmpeg::start(path, file.temporary(), size, fps)?),
        };
        Ok(Self { file, encoder, size, _claim: claim })
    }

    pub(super) fn add(&mut self, picture: &Picture) -> Result<(), Failure> {
        self.add_rgb(picture.rgb.as_flattened())
    }

    /// Adds a frame that exists already.
    pub(super) fn add_file(&mut self, file: &Path) -> Result<(), Failure> {
        let unlike =
            |message: String| Failure::refused(file, message, "remove it, to render it again");
        let image = image::open(file).map_err(|error| unlike(error.to_string()))?.into_rgb8();
        if UVec2::from(image.dimensions()) != self.size {
            return Err(unlike("has another size than the scene's pictures".to_owned()));
        }
        self.add_rgb(image.as_raw())
    }

    fn add_rgb(&mut self, rgb: &[u8]) -> Result<(), Failure> {
        match &mut self.encoder {
            Encoder::Png(writer) => {
                writer.write_image_data(rgb).map_err(|error| failed(self.file.path(), error))
            }
            Encoder::Video(ffmpeg) => ffmpeg.add(self.file.path(), rgb),
        }
    }

    /// Gives the file its final name.
    pub(super) fn finish(self) -> Result<(), Failure> {
        match self.encoder {
            Encoder::Png(writer) => {
                writer.finish().map_err(|error| failed(self.file.path(), error))?;
            }
            Encoder::Video(ffmpeg) => ffmpeg.finish(self.file.path())?,
        }
        self.file.finish()
    }
}

/// A process that reads pictures and writes a video.
struct Ffmpeg(Child);

impl Ffmpeg {
    fn start(path: &Path, temporary: &Path, size: UVec2, fps: f64) -> Result<Self, Failure> {
        let mut command = Command::new("ffmpeg");
        command.args(["-loglevel", "error", "-y", "-f", "rawvideo", "-pixel_format", "rgb24"]);
        command.args(["-video_size", &format!("{}x{}", size.x, size.y)]);
        command.args(["-framerate", &fps.to_string(), "-i", "-"]);
        // Most players expect chroma at half resolution, which needs even sides, and a stated colour matrix.
        let filter = "pad=ceil(iw/2)*2:ceil(ih/2)*2,scale=out_color_matrix=bt709:out_range=tv";
        command.args(["-vf", filter, "-pix_fmt", "yuv420p", "-colorspace", "bt709"]);
        command.args(["-metadata", &format!("comment={MARK}"), "-f", "mp4"]).arg(temporary);
        command.stdin(Stdio::piped()).stdout(Stdio::null());
        command.spawn().map(Self).map_err(|error| match error.kind() {
            io::ErrorKind::NotFound => {
                let message = "ffmpeg writes videos, and is not installed";
                Failure::refused(path, message, "install it, or name a .png")
            }
            _ => Failure::Wrong(format!("{}: ffmpeg does not start: {error}", path.display())),
        })
    }

    fn add(&mut self, path: &Path, rgb: &[u8]) -> Result<(), Failure> {
        let input = self.0.stdin.as_mut();
        let written = input.map_or(Ok(()), |input| input.write_all(rgb));
        written.map_err(|error| {
            Failure::Wrong(format!("{}: ffmpeg takes no frame: {error}", path.display()))
        })
    }

    fn finish(mut self, path: &Path) -> Result<(), Failure> {
        // Closes its input.
        drop(self.0.stdin.take());
        let status = self.0.wait().map_err(|source| Failure::file(path, source))?;
        if status.success() {
            return Ok(());
        }
        Err(Failure::Wrong(format!("{}: ffmpeg failed: {status}", path.display())))
    }
}

impl Drop for Ffmpeg {
    /// An incomplete video is removed.
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn format(path: &Path) -> Result<Format, Failure> {
    let extension = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    match extension.as_str() {
        "png" | "apng" => Ok(Format::Png),
        "mp4" => Ok(Format::Mp4),
        _ => {
            let message = format!("no kind of preview: {extension:?}");
            Err(Failure::refused(path, message, "name a .png or an .mp4"))
        }
    }
}

/// Refuses the names of frames and of the files beside them.
fn check_name(path: &Path, out: &Path) -> Result<(), Failure> {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let is_beside = match (folder(path).canonicalize(), out.canonicalize()) {
        (Ok(of_preview), Ok(of_frames)) => of_preview == of_frames,
        _ => false,
    };
    if is_beside && name.to_ascii_lowercase().starts_with("frame_") {
        return Err(Failure::refused(path, "is the name of a frame", "name the preview otherwise"));
    }
    Ok(())
}

fn taken(path: &Path) -> Failure {
    let help = "remove it, or name another file";
    Failure::refused(path, "exists, and is no preview of gobo", help)
}

/// A claim to write a file that is a preview, or does not exist.
fn claimed(path: &Path, format: Format) -> Result<Claim, Failure> {
    if !is_free(path, format).map_err(|source| Failure::file(path, source))? {
        return Err(taken(path));
    }
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let Some(claim) = Claim::attempt(folder(path), &name)? else {
        let help = "wait for that, or name another file";
        return Err(Failure::refused(path, "another process is writing it", help));
    };
    claim.sweep(temporaries(folder(path), &format!("{name}.")));
    Ok(claim)
}

/// Whether the name is unused, or that of an earlier preview.
fn is_free(path: &Path, format: Format) -> io::Result<bool> {
    match path.metadata() {
        Ok(_) => {}
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(true),
        Err(error) => return Err(error),
    }
    let mut file = File::open(path)?;
    let mut head = [0; 8];
    let is_format = file.read_exact(&mut head).is_ok()
        && match format {
            Format::Png => head == *b"\x89PNG\r\n\x1a\n",
            Format::Mp4 => head[4..] == *b"ftyp",
        };
    // An animated PNG has the mark in its head, a video in its tail.
    let mut bytes = Vec::new();
    match format {
        Format::Png => file.take(4096).read_to_end(&mut bytes)?,
        Format::Mp4 => file.read_to_end(&mut bytes)?,
    };
    Ok(is_format && bytes.windows(MARK.len()).any(|window| window == MARK.as_bytes()))
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
