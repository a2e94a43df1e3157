//! The gallery as one self-contained page: pictures, maps, times and counts.
use crate::{Fallible, Plate, preview};
use base64::{Engine as _, engine::general_purpose::STANDARD};
use gobo_picture::{Frame, ViewMaps};
use image::{ImageFormat, RgbImage};
use std::{fmt::Write as _, io::Cursor, time::Duration};

/// Views per scene whose maps are shown.
const VIEWS: usize = 3;
const STYLE: &str = "body{font:15px/1.5 sans-serif;background:#111;color:#ddd;max-width:980px;\
    margin:2em auto;\
     padding:0 1em}h1,h2{font-weight:normal}img{display:block}.picture{width:100%;height:auto}\
     .maps{display:flex;gap:8px;flex-wrap:wrap}figure{margin:8px 0}figcaption{font-size:12px;color:#999}\
     summary{color:#999;cursor:pointer}pre{font-size:12px;white-space:pre-wrap;color:#999}";

pub(super) fn page(plates: &[Plate], device: &str, whole: Duration) -> String {
    let mut page = format!(
        "<!doctype html>\n<html lang=\"en\"><meta charset=\"utf-8\"><title>gobo: the gallery</title>\n\
         <style>{STYLE}</style>\n<h1>gobo: the gallery</h1>\n<p>{} pictures in {:.0} s on {}.</p>\n",
        plates.len(),
        whole.as_secs_f64(),
        escape(device)
    );
    for plate in plates {
        page += &plate.section;
    }
    page + "</html>\n"
}

/// A scene's heading, picture, description, maps, times and counts.
pub(super) fn section(
    name: &str,
    about: &str,
    image: &RgbImage,
    frame: &Frame,
    time: Duration,
) -> Fallible<String> {
    let size = frame.picture.size;
    let mut html = format!("<h2 id=\"{name}\">{name}</h2>\n");
    html += &picture(image, name, "picture")?;
    let _ = writeln!(
        html,
        "<p>{}</p>\n<p>{:.1} s, {} x {} pixels, {} casters, {} shadow views, {:.0} MiB</p>",
        escape(about),
        time.as_secs_f64(),
        size.x,
        size.y,
        frame.counters.casters,
        frame.maps.len(),
        frame.memory.iter().map(|&(_, bytes)| bytes).sum::<u64>() as f64 / f64::from(1 << 20),
    );
    html += "<div class=\"maps\">\n";
    for maps in most_colored(&frame.maps) {
        for (what, image) in
            [("filter", preview::filter(maps)), ("nearest depth", preview::nearest(maps))]
        {
            let shown = picture(&image, what, "map")?;
            let view = escape(maps.view.name);
            let _ =
                writeln!(html, "<figure>{shown}<figcaption>{what}, {view}</figcaption></figure>");
        }
    }
    html += "</div>\n<details><summary>times and counts</summary>\n<pre>";
    for (stage, ms) in &frame.stages {
        let _ = writeln!(html, "{stage}: {ms:.1} ms");
    }
    let counters = serde_json::to_string(&frame.counters)?;
    Ok(html + &escape(&counters) + "</pre></details>\n")
}

/// Views with the most tinted texels.
fn most_colored(maps: &[ViewMaps]) -> Vec<&ViewMaps> {
    let tinted = |maps: &&ViewMaps| {
        let share = |f: &&[f32; 3]| f.iter().any(|&light| light < 0.95);
        maps.filter.iter().filter(share).count()
    };
    let mut order: Vec<&ViewMaps> = maps.iter().collect();
    order.sort_by_cached_key(|maps| std::cmp::Reverse(tinted(maps)));
    order.truncate(VIEWS);
    order
}

fn picture(image: &RgbImage, alt: &str, class: &str) -> Fallible<String> {
    let mut bytes = Cursor::new(Vec::new());
    image.write_to(&mut bytes, ImageFormat::Png)?;
    let (width, height) = image.dimensions();
    let data = STANDARD.encode(bytes.into_inner());
    Ok(format!(
        "<img class=\"{class}\" alt=\"{alt}\" width=\"{width}\" height=\"{height}\" \
         src=\"data:image/png;base64,{data}\">"
    ))
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
