//! Transfer from a volume's values to density and colour: a window, a table of colours, and clipping.
use super::{
    SceneError,
    document::Numbers,
    error::quoted,
    keys::Keys,
    look_presets::PRESETS,
    plain::nearest,
    vdb::{Tree, VolumeFault},
};
use glam::{DAffine3, DVec3, DVec4, IVec3, Vec3};

/// A row of a table of colours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Row {
    pub(super) value: f32,
    pub(super) color: Vec3,
    /// Extinction relative to the volume's factor.
    pub(super) opacity: f32,
}

/// Most rows of a table: each visible row has bricks and a material of its own.
const MOST_ROWS: usize = 16;
/// Most clipping planes.
const MOST_PLANES: usize = 16;

/// Visible part of a volume, in its own space \[m\]: inside the box and above all planes.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Clip {
    corners: Option<[DVec3; 2]>,
    /// Unit normal, and the height of the origin above the plane \[m\].
    planes: Vec<DVec4>,
}

impl Clip {
    fn read(keys: &Keys<'_>) -> Result<Self, SceneError> {
        const BOX: &str = "give two corners: box = [[x, y, z], [x, y, z]]";
        const PLANES: &str = "give each as [x, y, z, d]: what is kept has x X + y Y + z Z + d >= 0";
        let rows = |key: &'static str, width: usize, help: &str| {
            let rows: Option<Vec<Vec<f64>>> = keys.given(key)?;
            let is_row = |row: &Vec<f64>| row.len() == width && row.iter().all(|v| v.abs() <= 1e7);
            match rows {
                Some(rows) if !rows.iter().all(is_row) => {
                    Err(keys.fault(key, format!("{key} is {rows:?}"), help))
                }
                rows => Ok(rows),
            }
        };
        let corners = match rows("box", 3, BOX)?.as_deref() {
            None => None,
            Some([one, other]) => {
                let [one, other] = [one, other].map(|row| DVec3::new(row[0], row[1], row[2]));
                Some([one.min(other), one.max(other)])
            }
            Some(_) => return Err(keys.fault("box", "box has not two corners", BOX)),
        };
        let mut planes = Vec::new();
        for row in rows("planes", 4, PLANES)?.unwrap_or_default() {
            let plane = DVec4::new(row[0], row[1], row[2], row[3]);
            let length = plane.truncate().length();
            if length < 1e-12 || planes.len() == MOST_PLANES {
                let help =
                    format!("give at most {MOST_PLANES} planes, each with a normal that is not 0");
                return Err(keys.fault("planes", "a plane too many, or without a normal", &help));
            }
            planes.push(plane / length);
        }
        Ok(Self { corners, planes })
    }

    /// Whether a point \[m\] is shown.
    fn has(&self, point: DVec3) -> bool {
        let is_within = |[low, high]: [DVec3; 2]| point.cmpge(low).all() && point.cmple(high).all();
        self.corners.is_none_or(is_within)
            && self.planes.iter().all(|plane| plane.dot(point.extend(1.0)) >= 0.0)
    }

    /// Whether all points are outside of one side, so that nothing between them is shown.
    fn lacks_all(&self, points: &[DVec3]) -> bool {
        let all =
            |is_outside: &dyn Fn(DVec3) -> bool| points.iter().all(|&point| is_outside(point));
        let beside = |axis: usize| {
            let is_beside = |[low, high]: [DVec3; 2]| {
                all(&|point| point[axis] < low[axis]) || all(&|point| point[axis] > high[axis])
            };
            self.corners.is_some_and(is_beside)
        };
        (0..3).any(beside)
            || self.planes.iter().any(|plane| all(&|point| plane.dot(point.extend(1.0)) < 0.0))
    }
}

/// Transfer from a volume's values to density and colour.
#[derive(Clone, Debug, Default)]
pub(super) struct Look {
    /// Values that are mapped to 0 and 1.
    window: Option<[f32; 2]>,
    /// Rows of a table of colours, by value.
    rows: Vec<Row>,
    /// Index of the row whose share is shown.
    row: Option<usize>,
    clip: Option<Clip>,
}

impl Look {
    pub(super) fn read(keys: &Keys<'_>) -> Result<Self, SceneError> {
        let window: Option<[f32; 2]> = keys.array("window")?;
        let is_range = |[low, high]: [f32; 2]| high > low && (high - low).is_finite();
        if let Some(wrong) = window.filter(|&window| !is_range(window)) {
            let help = "give the value that becomes 0, and a higher one that becomes 1";
            return Err(keys.fault("window", format!("window is {wrong:?}"), help));
        }
        let rows = rows(keys, window.is_some())?;
        let clip = keys.one("clip", Clip::read)?.map(toml::Spanned::into_inner);
        Ok(Self { window, rows, row: None, clip })
    }

    /// The transfer of each visible row of its table, with the row's colour; none without a table.
    pub(super) fn rows(&self) -> Vec<(Self, Vec3)> {
        let seen = self.rows.iter().enumerate().filter(|(_, row)| row.opacity > 0.0);
        seen.map(|(i, row)| (Self { row: Some(i), ..self.clone() }, row.color)).collect()
    }

    /// Whether densities differ from the values.
    pub(super) fn has_values(&self) -> bool {
        self.window.is_some() || !self.rows.is_empty()
    }

    /// Whether the volume is clipped.
    pub(super) fn is_clipped(&self) -> bool {
        self.clip.is_some()
    }

    /// Density of a value.
    pub(super) fn density(&self, value: f32) -> f32 {
        let value = match self.window {
            Some([low, high]) if value.is_finite() => {
                ((value - low) / (high - low)).clamp(0.0, 1.0)
            }
            _ => value,
        };
        let Some(i) = self.row else { return value };
        if value.is_nan() {
            return value;
        }
        // Between two rows the value belongs to both by shares; the first and last row continue beyond their
        // values.
        let share = |other: Option<&Row>| match other {
            None => 1.0,
            Some(other) => {
                let way = (value - other.value) / (self.rows[i].value - other.value);
                way.clamp(0.0, 1.0)
            }
        };
        let before = i.checked_sub(1).and_then(|i| self.rows.get(i));
        let side = if value < self.rows[i].value { before } else { self.rows.get(i + 1) };
        self.rows[i].opacity * share(side)
    }

    /// Whether a point of the volume's space \[m\] is shown.
    pub(super) fn has(&self, point: impl FnOnce() -> DVec3) -> bool {
        self.clip.as_ref().is_none_or(|clip| clip.has(point()))
    }

    /// Maps a tree's values to densities, and clips them. The value 0 is empty.
    pub(super) fn shown(
        &self,
        mut tree: Tree,
        volume_from_index: DAffine3,
    ) -> Result<Tree, VolumeFault> {
        if self.has_values() {
            for value in tree.values_mut().filter(|value| **value != 0.0) {
                *value = self.density(*value);
            }
        }
        let Some(clip) = &self.clip else { return Ok(tree) };
        let point = |voxel: IVec3| volume_from_index.transform_point3(voxel.as_dvec3());
        tree.cut(
            |voxel| clip.has(point(voxel)),
            |low, high| {
                let pick = |i: u32, axis: usize| if i >> axis & 1 == 0 { low } else { high }[axis];
                let corner = |i| point(IVec3::new(pick(i, 0), pick(i, 1), pick(i, 2)));
                let corners: [DVec3; 8] = std::array::from_fn(|i| corner(i as u32));
                match corners.iter().all(|&corner| clip.has(corner)) {
                    true => Some(true),
                    false if clip.lacks_all(&corners) => Some(false),
                    false => None,
                }
            },
        )
    }
}

/// The table of colours, or a preset by name.
fn rows(keys: &Keys<'_>, has_window: bool) -> Result<Vec<Row>, SceneError> {
    const KEY: &str = "colors";
    const HELP: &str =
        "give rows of a value, a colour and an opacity, as [300, [1, 0.9, 0.8], 0.5]";
    if let Some(Ok(name)) = keys.has(KEY).then(|| keys.given::<String>(KEY)) {
        let name = name.unwrap_or_default();
        let names = PRESETS.iter().map(|preset| preset.name);
        let Some(preset) = PRESETS.iter().find(|preset| preset.name == name) else {
            let known = names.clone().map(quoted).collect::<Vec<_>>().join(", ");
            let help = nearest(&name, names)
                .unwrap_or_else(|| format!("name one of {known}, or give rows"));
            return Err(keys.fault(
                KEY,
                format!("no table of colours is named {}", quoted(&name)),
                &help,
            ));
        };
        if preset.is_of_window != has_window {
            let help = if has_window {
                "remove the window: the table has Hounsfield units"
            } else {
                "add window = [low, high]: the table has shares of it"
            };
            let message = format!("the table {} takes values of another kind", quoted(&name));
            return Err(keys.fault(KEY, message, help));
        }
        return Ok((preset.rows)());
    }
    let Some(given) = keys.given::<Vec<Vec<Numbers>>>(KEY)? else { return Ok(Vec::new()) };
    let wrong = |message: String| keys.fault(KEY, message, HELP);
    let mut rows = Vec::new();
    for (row, place) in given.iter().zip(1..) {
        let [value, color, opacity] = &row[..] else {
            return Err(wrong(format!("row {place} of colors has {} parts, not 3", row.len())));
        };
        let (&[value], &[red, green, blue], &[opacity]) =
            (&value.values[..], &color.values[..], &opacity.values[..])
        else {
            return Err(wrong(format!("row {place} of colors is not of 1, 3 and 1 numbers")));
        };
        let shares = [red, green, blue, opacity];
        if !value.is_finite() || shares.iter().any(|share| !(0.0..=1.0).contains(share)) {
            let message =
                format!("row {place} of colors is out of range: colours and opacities are 0 to 1");
            return Err(wrong(message));
        }
        rows.push(Row { value, color: Vec3::new(red, green, blue), opacity });
    }
    if !rows.is_sorted_by(|one, next| one.value < next.value) {
        return Err(keys.fault(
            KEY,
            "values of colors do not ascend",
            "sort the rows by their values",
        ));
    }
    if !rows.iter().any(|row| row.opacity > 0.0) || rows.len() > MOST_ROWS {
        let help = format!("give at most {MOST_ROWS} rows, some of an opacity above 0");
        return Err(keys.fault(KEY, format!("colors has {} rows", rows.len()), &help));
    }
    Ok(rows)
}

/// Extinction and albedo per channel of matter with this colour, if a share `ahead` of its scattered light
/// goes straight on (Joseph, Wiscombe and Weinman 1976, "The delta-Eddington approximation", equation 13).
pub(super) fn delta_eddington(color: Vec3, ahead: f32) -> [Vec3; 2] {
    let extinction = 1.0 - color * ahead;
    let albedo = color * (1.0 - ahead) / extinction.max(Vec3::splat(1e-6));
    [extinction, albedo]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn presets_are_tables() {
        for preset in &PRESETS {
            let rows = (preset.rows)();
            assert!((2..=MOST_ROWS).contains(&rows.len()), "{}", preset.name);
            assert!(rows.is_sorted_by(|one, next| one.value < next.value), "{}", preset.name);
            for row in rows {
                let within = |share: f32| (0.0..=1.0).contains(&share);
                assert!(row.color.to_array().into_iter().all(within) && within(row.opacity));
                assert!(!preset.is_of_window || within(row.value), "{}", preset.name);
            }
        }
        assert!(PRESETS.iter().any(|preset| preset.is_of_window));
    }
}
