//! Lines of `--json`.
use gobo::model::{Counters, SoftLight};
use gobo_picture::Frame;
use serde::{Serialize, Serializer};
use std::path::Path;

/// One line of `--json`.
#[derive(Serialize)]
struct FrameReport<'a> {
    frame: u32,
    /// Texels and viewpoints chosen for lights with a size.
    soft: &'a [SoftLight],
    picture: std::borrow::Cow<'a, str>,
    #[serde(flatten)]
    counters: &'a Counters,
    /// Phase and its time on the wall clock [ms].
    #[serde(serialize_with = "as_map")]
    milliseconds: &'a [(&'static str, f64)],
    /// Stage and its time [ms].
    #[serde(serialize_with = "as_map")]
    stages: &'a [(&'static str, f64)],
    /// Stage of the picture and its time [ms].
    #[serde(serialize_with = "as_map")]
    picture_stages: &'a [(&'static str, f64)],
    /// Buffer or texture and its size [bytes].
    #[serde(serialize_with = "as_map")]
    bytes: &'a [(&'static str, u64)],
    /// Sum over all buffers and textures.
    peak_bytes: u64,
}

/// `milliseconds`: phases of the command since the last line.
pub(super) fn json(
    index: u32,
    picture: &Path,
    frame: &Frame,
    soft: &[SoftLight],
    milliseconds: &[(&'static str, f64)],
) -> String {
    let report = FrameReport {
        frame: index,
        soft,
        picture: picture.to_string_lossy(),
        counters: &frame.counters,
        milliseconds,
        picture_stages: &frame.picture_stages,
        stages: &frame.stages,
        bytes: &frame.memory,
        peak_bytes: frame.memory.iter().map(|&(_, bytes)| bytes).sum(),
    };
    serde_json::to_string(&report).expect("plain data is JSON")
}

/// JSON line of a frame that was skipped because it exists.
pub(super) fn kept_json(index: u32, picture: &Path) -> String {
    let picture = picture.to_string_lossy();
    serde_json::json!({ "frame": index, "picture": picture, "kept": true }).to_string()
}

/// Serializes entries in order; values of equal names are added.
pub(super) fn as_map<T, S>(entries: &[(&'static str, T)], serializer: S) -> Result<S::Ok, S::Error>
where
    T: Copy + Serialize + std::ops::AddAssign,
    S: Serializer,
{
    let mut sums: Vec<(&str, T)> = Vec::with_capacity(entries.len());
    for &(name, value) in entries {
        match sums.iter_mut().find(|(known, _)| *known == name) {
            Some((_, sum)) => *sum += value,
            None => sums.push((name, value)),
        }
    }
    serializer.collect_map(sums)
}

#[cfg(test)]
mod tests {
    use super::*;
    use gobo::records::Picture;

    #[test]
    fn a_report_has_every_figure() {
        let frame = Frame {
            picture: Picture { size: glam::UVec2::ONE, rgb: vec![[0; 3]], light: Vec::new() },
            debug: Vec::new(),
            maps: Vec::new(),
            counters: Counters { pairs: 7, skipped: [("radius", 2)].into(), ..Default::default() },
            stages: vec![("sort", 1.5), ("bin", 1.0), ("sort", 0.5)],
            picture_stages: vec![("shade", 3.0)],
            memory: vec![("pairs", 56), ("sums", 8)],
        };
        let sun = SoftLight { light: "sun".to_owned(), asked: 900, size: 1024, viewpoints: 5 };
        let line = json(3, Path::new("out/frame_0003.png"), &frame, &[sun], &[("kernels", 9.5)]);
        assert!(!line.contains('\n'));
        let value: serde_json::Value = serde_json::from_str(&line).unwrap();
        assert_eq!(value["frame"], 3);
        assert_eq!(value["picture"], "out/frame_0003.png");
        let sun =
            serde_json::json!({ "light": "sun", "asked": 900, "size": 1024, "viewpoints": 5 });
        assert_eq!(value["soft"], serde_json::json!([sun]));
        assert_eq!(value["pairs"], 7);
        assert_eq!(value["skipped"]["radius"], 2);
        assert_eq!(value["stages"], serde_json::json!({ "sort": 2.0, "bin": 1.0 }));
        assert_eq!(value["picture_stages"], serde_json::json!({ "shade": 3.0 }));
        assert_eq!(value["milliseconds"], serde_json::json!({ "kernels": 9.5 }));
        assert_eq!(value["bytes"], serde_json::json!({ "pairs": 56, "sums": 8 }));
        assert_eq!(value["peak_bytes"], 64);
        for name in [
            "casters",
            "views_rendered",
            "views_kept",
            "views_searched",
            "culled",
            "hidden",
            "visible",
            "segments",
            "scattered",
            "overflowed",
            "shrunk",
            "nodes_dropped",
            "short_tiles",
            "cluster_lights",
            "clusters_overflowed",
            "masks",
            "unmasked_lights",
            "levels_made",
            "pictures_drawn",
            "capacities_grown",
        ] {
            assert_eq!(value[name], 0, "{name}");
        }
    }
}
