//! Results as one self-contained page: plots as inline SVG, and the numbers.
use super::{
    case::Case,
    measure::Row,
    report::{Report, short},
};
use std::fmt::Write as _;

const COLORS: [&str; 10] = [
    "#1f77b4", "#d62728", "#2ca02c", "#9467bd", "#ff7f0e", "#17becf", "#8c564b", "#e377c2",
    "#7f7f7f", "#bcbd22",
];
const WIDTH: f64 = 900.0;
/// Approximate width of a character of the labels [px].
const CHARACTER: f64 = 6.5;

pub(super) fn page(report: &Report) -> String {
    let Report { adapter, driver, tier, clock, rows, .. } = report;
    let heading = escape(&format!("{adapter}, {driver}, tier {tier}, {clock} clock"));
    let shares = |row: &Row| row.compute.stages.clone();
    let memory = |row: &Row| {
        row.compute
            .bytes
            .iter()
            .map(|&(name, bytes)| (name, bytes as f64 / f64::from(1 << 20)))
            .collect()
    };
    let mut page = format!(
        "<!doctype html>\n<html lang=\"en\"><meta charset=\"utf-8\"><title>gobo bench</title>\n\
         <style>body{{font:14px sans-serif;max-width:{WIDTH}px;margin:2em auto}}\
         text{{font:11px sans-serif}}td,th{{padding:2px 8px;text-align:right}}</style>\n\
         <h1>gobo bench</h1><p>{heading}</p>\n"
    );
    page += "<h2>Time of a frame's translucent pass</h2>\n";
    page += &times(rows);
    page += "<h2>Share of each stage</h2>\n";
    page += &bars(rows, shares, true, "%");
    page += "<h2>Memory [MiB]</h2>\n";
    page += &bars(rows, memory, false, "MiB");
    page += "<h2>Numbers</h2>\n";
    page += &table(rows);
    page + "</html>\n"
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// Name of a line in the first plot: the parameters that are constant along it.
fn series(row: &Row) -> String {
    let case = &row.case;
    let Case { shape, footprint, opacity, layout, .. } = case;
    let (plural, layout) = (shape.plural(), layout.name());
    let mut name = format!("{plural} of {footprint} texels, opacity {opacity}, {layout}");
    if case.lights > 1 {
        let _ = write!(name, ", {} lights", case.lights);
    }
    let _ = write!(name, ", {}²", case.size);
    name
}

fn text(svg: &mut String, x: f64, y: f64, anchor: &str, content: &str) {
    let content = escape(content);
    let _ = writeln!(svg, r#"<text x="{x:.1}" y="{y:.1}" text-anchor="{anchor}">{content}</text>"#);
}

fn line(svg: &mut String, from: (f64, f64), to: (f64, f64), color: &str) {
    let ((x1, y1), (x2, y2)) = (from, to);
    let _ = writeln!(
        svg,
        r#"<line x1="{x1:.1}" y1="{y1:.1}" x2="{x2:.1}" y2="{y2:.1}" stroke="{color}"/>"#
    );
}

fn rect(svg: &mut String, x: f64, y: f64, (width, height): (f64, u32), color: &str) {
    let _ = writeln!(
        svg,
        r#"<rect x="{x:.1}" y="{y:.1}" width="{width:.1}" height="{height}" fill="{color}"/>"#
    );
}

/// Grid lines per decade.
const STEPS: [f64; 3] = [1.0, 2.0, 5.0];

/// A logarithmic axis.
struct Axis {
    /// Powers of ten at its ends.
    low: i32,
    high: i32,
    /// Position of its low end, and its length [px].
    start: f64,
    length: f64,
}

impl Axis {
    fn new(values: impl Iterator<Item = f64>, start: f64, length: f64) -> Self {
        let (low, high) = values
            .filter(|value| *value > 0.0)
            .map(f64::log10)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
        let (low, high) = if low > high {
            (0, 1)
        } else {
            (low.floor() as i32, (high.ceil() as i32).max(low.floor() as i32 + 1))
        };
        Self { low, high, start, length }
    }

    fn at(&self, value: f64) -> f64 {
        let part = value.max(1e-9).log10() - f64::from(self.low);
        self.start + self.length * part / f64::from(self.high - self.low)
    }

    /// Values of grid lines, and whether they are labelled: between decades only if there are few.
    fn marks(&self) -> impl Iterator<Item = (f64, bool)> {
        let (low, high) = (self.low, self.high);
        let decade = |decade: i32| STEPS.map(|step| step * 10f64.powi(decade));
        let marks = (low..high).flat_map(decade).chain([10f64.powi(high)]);
        marks.map(move |mark| (mark, high - low < 4 || mark.log10().fract() == 0.0))
    }
}

/// Milliseconds of compute and of the raster pipeline.
fn ms(row: &Row) -> [Option<f64>; 2] {
    [Some(row.compute.compute_ms), row.raster.as_ref().map(|raster| raster.raster_ms)]
}

/// Milliseconds over casters, both logarithmic: compute as full lines and discs, raster as dashed
/// lines and rings.
fn times(rows: &[Row]) -> String {
    let (left, top, width, height) = (60.0, 24.0, 530.0, 380.0);
    let (right, bottom) = (left + width, top + height);
    let x_axis = Axis::new(rows.iter().map(|row| f64::from(row.case.casters)), left, width);
    let y_axis = Axis::new(rows.iter().flat_map(ms).flatten(), bottom, -height);
    let mut svg = format!("<svg width=\"{WIDTH}\" height=\"450\">\n");
    for (mark, is_labelled) in x_axis.marks() {
        let x = x_axis.at(mark);
        line(&mut svg, (x, top), (x, bottom), "#ddd");
        if is_labelled {
            text(&mut svg, x, bottom + 15.0, "middle", &short(mark.round() as u32));
        }
    }
    for (mark, _) in y_axis.marks() {
        let y = y_axis.at(mark);
        line(&mut svg, (left, y), (right, y), "#ddd");
        // Numbers like 10^-3 are printed without rounding errors.
        text(&mut svg, left - 5.0, y + 4.0, "end", &format!("{}", (mark * 1e9).round() / 1e9));
    }
    text(&mut svg, left + width / 2.0, bottom + 35.0, "middle", "casters");
    text(&mut svg, left, top - 10.0, "end", "time [ms]");
    let mut names: Vec<String> = Vec::new();
    for row in rows {
        let name = series(row);
        if !names.contains(&name) {
            names.push(name);
        }
    }
    for (index, name) in names.iter().enumerate() {
        let color = COLORS[index % COLORS.len()];
        let mut of_series: Vec<&Row> = rows.iter().filter(|row| series(row) == *name).collect();
        of_series.sort_by_key(|row| row.case.casters);
        for (pipeline, dash) in [(0, ""), (1, r#" stroke-dasharray="5 4""#)] {
            let point = |row: &&Row| {
                let ms = ms(row)[pipeline]?;
                Some((x_axis.at(f64::from(row.case.casters)), y_axis.at(ms)))
            };
            polyline(
                &mut svg,
                &of_series.iter().filter_map(point).collect::<Vec<_>>(),
                color,
                dash,
            );
        }
        let y = top + 15.0 * (index + 1) as f64;
        line(&mut svg, (right + 15.0, y - 4.0), (right + 35.0, y - 4.0), color);
        text(&mut svg, right + 40.0, y, "start", name);
    }
    let y = top + 15.0 * (names.len() + 2) as f64;
    text(&mut svg, right + 15.0, y, "start", "full lines, discs: compute");
    text(&mut svg, right + 15.0, y + 15.0, "start", "dashed lines, rings: raster");
    svg + "</svg>\n"
}

/// A line through points: full with discs, or dashed with rings.
fn polyline(svg: &mut String, points: &[(f64, f64)], color: &str, dash: &str) {
    let list: Vec<_> = points.iter().map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
    let list = list.join(" ");
    let _ = writeln!(
        svg,
        r#"<polyline points="{list}" fill="none" stroke="{color}" stroke-width="2"{dash}/>"#
    );
    let fill = if dash.is_empty() { color } else { "white" };
    for (x, y) in points {
        let _ = writeln!(
            svg,
            r#"<circle cx="{x:.1}" cy="{y:.1}" r="3.5" fill="{fill}" stroke="{color}"/>"#
        );
    }
}

/// Number of parts with a colour of their own.
const PARTS: usize = COLORS.len() - 1;

/// One stacked bar per row. `relative`: bars are normalised to the same length.
fn bars(
    rows: &[Row],
    parts: impl Fn(&Row) -> Vec<(&'static str, f64)>,
    relative: bool,
    unit: &str,
) -> String {
    let mut sums: Vec<(&'static str, f64)> = Vec::new();
    let mut most: f64 = 0.0;
    for row in rows {
        let parts = parts(row);
        most = most.max(parts.iter().map(|(_, value)| value).sum());
        for (name, value) in parts {
            match sums.iter_mut().find(|(known, _)| *known == name) {
                Some((_, sum)) => *sum += value,
                None => sums.push((name, value)),
            }
        }
    }
    sums.sort_by(|a, b| b.1.total_cmp(&a.1));
    let color_of =
        |name: &str| sums.iter().take(PARTS).position(|(known, _)| *known == name).unwrap_or(PARTS);
    let label = |row: &Row| format!("{} x {}", short(row.case.casters), series(row));
    let longest = rows.iter().map(|row| label(row).len()).max().unwrap_or(0);
    let left = (longest as f64 * CHARACTER).min(WIDTH / 2.0);
    let width = WIDTH - left - 60.0;
    let bottom = 20.0 * rows.len() as f64;
    let height = bottom + 60.0;
    let mut svg = format!("<svg width=\"{WIDTH}\" height=\"{height}\">\n");
    for (index, row) in rows.iter().enumerate() {
        let parts = parts(row);
        let total: f64 = parts.iter().map(|(_, value)| value).sum();
        let whole = if relative { total } else { most };
        let y = 20.0 * index as f64;
        text(&mut svg, left - 5.0, y + 13.0, "end", &label(row));
        let mut widths = [0.0; COLORS.len()];
        for (name, value) in parts {
            widths[color_of(name)] += value / whole.max(1e-9) * width;
        }
        let mut x = left;
        for (part, color) in widths.into_iter().zip(COLORS) {
            rect(&mut svg, x, y, (part, 16), color);
            x += part;
        }
        if !relative {
            text(&mut svg, x + 4.0, y + 13.0, "start", &format!("{total:.0} {unit}"));
        }
    }
    for part in [0.0, 0.25, 0.5, 0.75, 1.0].into_iter().filter(|_| relative) {
        let x = left + part * width;
        line(&mut svg, (x, 0.0), (x, bottom), "#fff");
        text(&mut svg, x, bottom + 12.0, "middle", &format!("{:.0} {unit}", part * 100.0));
    }
    let mut names: Vec<&str> = sums.iter().take(PARTS).map(|(name, _)| *name).collect();
    if sums.len() > PARTS {
        names.push("others");
    }
    legend(&mut svg, &names, bottom + 35.0);
    svg + "</svg>\n"
}

/// Names beside their colours, in rows from `y` on.
fn legend(svg: &mut String, names: &[&str], mut y: f64) {
    let mut x = 10.0;
    for (name, color) in names.iter().zip(COLORS) {
        let wide = name.len() as f64 * CHARACTER + 30.0;
        if x + wide > WIDTH {
            (x, y) = (10.0, y + 18.0);
        }
        rect(svg, x, y - 10.0, (11.0, 11), color);
        text(svg, x + 15.0, y, "start", name);
        x += wide;
    }
}

fn table(rows: &[Row]) -> String {
    let mut table = String::from(
        "<table><tr><th>casters</th><th>case</th><th>compute [ms]</th><th>raster [ms]</th>\
         <th>ratio</th><th>pairs</th><th>scattered</th><th>overflowed</th></tr>\n",
    );
    for row in rows {
        let (raster, ratio) = match &row.raster {
            Some(raster) => (format!("{:.3}", raster.raster_ms), format!("{:.2}", raster.ratio)),
            None => (String::new(), String::new()),
        };
        let _ = writeln!(
            table,
            "<tr><td>{}</td><td>{}</td><td>{:.3}</td><td>{raster}</td><td>{ratio}</td><td>{}</td>\
             <td>{}</td><td>{}</td></tr>",
            row.case.casters,
            escape(&series(row)),
            row.compute.compute_ms,
            row.compute.pairs,
            row.compute.scattered,
            row.compute.overflowed,
        );
    }
    table + "</table>\n"
}
