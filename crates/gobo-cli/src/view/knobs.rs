//! Settings behind the sliders.
use super::{
    orbit::Orbit,
    pick::Pick,
    request::{Facts, Look},
    time_line::TimeLine,
};
use eframe::egui::{ComboBox, DragValue, Slider, Ui};
use gobo::{
    Light, LightKind, Receiver, ShadowSettings,
    glam::{UVec2, Vec3},
    model::ShadowFilter,
};
use std::collections::BTreeMap;

/// State of the sliders, and of the camera.
pub(super) struct Knobs {
    pub(super) orbit: Orbit,
    exposure: f32,
    shadow: ShadowSettings,
    lights: Vec<Light>,
    /// Lights that differ from the file's.
    changed: BTreeMap<usize, Light>,
    /// Index of the light that is edited and whose maps are shown.
    pub(super) light: usize,
    pub(super) insets: bool,
    /// Whether both receivers are shown, side by side.
    pub(super) beside: bool,
    pub(super) pick: Option<Pick>,
    /// Time line of an animated scene.
    pub(super) line: Option<TimeLine>,
    /// Approximate size of the scene [m].
    reach: f32,
}

impl Knobs {
    pub(super) fn of(facts: &Facts) -> Self {
        Self {
            orbit: Orbit::of(&facts.camera),
            exposure: facts.exposure,
            shadow: facts.shadow,
            lights: facts.lights.clone(),
            changed: BTreeMap::new(),
            light: facts.lights.iter().position(|light| light.casts).unwrap_or(0),
            insets: true,
            beside: false,
            pick: None,
            line: facts.end.map(TimeLine::new),
            reach: (facts.bounds.max - facts.bounds.min).max_element().clamp(0.1, 1e6),
        }
    }

    pub(super) fn look(&self, size: UVec2) -> Look {
        Look {
            camera: self.orbit.camera(size),
            exposure: self.exposure,
            shadow: self.shadow,
            lights: self.changed.clone(),
            time: self.line.as_ref().map_or(0.0, |line| line.time),
            maps_of: self.insets.then_some(self.light),
            beside: self.beside,
            pick: self.pick,
        }
    }

    /// The settings after a file is read again: changes made in the window stay, unless the file changed the
    /// same value. `before`: properties of the former reading.
    pub(super) fn again(self, before: &Facts, facts: &Facts) -> Self {
        let mut new = Self::of(facts);
        if facts.camera == before.camera {
            new.orbit = self.orbit;
        }
        if facts.exposure.to_bits() == before.exposure.to_bits() {
            new.exposure = self.exposure;
        }
        if facts.shadow == before.shadow {
            new.shadow = self.shadow;
        }
        if facts.lights == before.lights {
            (new.lights, new.changed, new.light) = (self.lights, self.changed, self.light);
        } else if self.light < facts.lights.len() {
            new.light = self.light;
        }
        (new.insets, new.beside, new.pick) = (self.insets, self.beside, self.pick);
        new.line = facts.end.map(|end| match self.line {
            Some(line) => line.with_end(end),
            None => TimeLine::new(end),
        });
        new
    }

    /// Names of the lights.
    pub(super) fn light_names(&self) -> impl Iterator<Item = &str> {
        self.lights.iter().map(|light| light.name.as_str())
    }

    pub(super) fn show(&mut self, ui: &mut Ui) {
        ui.add(Slider::new(&mut self.exposure, -6.0..=6.0).text("exposure [stops]"));
        ui.separator();
        self.show_light(ui);
        ui.separator();
        self.show_shadow(ui);
    }

    fn show_light(&mut self, ui: &mut Ui) {
        let Some(name) = self.lights.get(self.light).map(|light| light.name.clone()) else {
            ui.label("no light");
            return;
        };
        ComboBox::from_label("light").selected_text(name).show_ui(ui, |ui| {
            for (index, light) in self.lights.iter().enumerate() {
                ui.selectable_value(&mut self.light, index, light.name.as_str());
            }
        });
        let light = &mut self.lights[self.light];
        let before = light.clone();
        match &mut light.kind {
            LightKind::Directional { direction } => show_direction(ui, direction),
            LightKind::Spot { position, direction, .. } => {
                show_direction(ui, direction);
                show_place(ui, position, self.reach);
            }
            LightKind::Point { position } => show_place(ui, position, self.reach),
        }
        let most = light.intensity.max(1.0) * 10.0;
        ui.add(Slider::new(&mut light.intensity, 0.0..=most).logarithmic(true).text("intensity"));
        ui.checkbox(&mut light.casts, "casts shadows");
        if *light != before {
            self.changed.insert(self.light, light.clone());
        }
    }

    fn show_shadow(&mut self, ui: &mut Ui) {
        let shadow = &mut self.shadow;
        let mut edge = shadow.size.max(1).ilog2();
        let slider = Slider::new(&mut edge, 6..=12)
            .custom_formatter(|edge, _| format!("{}", 1_u32 << (edge as u32)));
        if ui.add(slider.text("map size [texels]")).changed() {
            shadow.size = 1 << edge;
        }
        ui.horizontal(|ui| {
            ui.label("receiver");
            ui.selectable_value(&mut shadow.receiver, Receiver::Nearest, "nearest");
            ui.selectable_value(&mut shadow.receiver, Receiver::Curve, "curve");
            ui.checkbox(&mut self.beside, "side by side");
        });
        ui.add_enabled_ui(self.beside || shadow.receiver == Receiver::Curve, |ui| {
            ui.horizontal(|ui| {
                ui.label("nodes");
                for nodes in [4, 8, 16] {
                    ui.selectable_value(&mut shadow.nodes, nodes, nodes.to_string());
                }
            });
        });
        let filters = [
            ("none", ShadowFilter::None),
            ("bilinear", ShadowFilter::Bilinear),
            ("spline", ShadowFilter::Spline),
            ("PCF 5x5", ShadowFilter::Pcf { taps: 5 }),
            ("Vogel 16", ShadowFilter::Vogel { taps: 16, radius: 3.0 }),
        ];
        let known = filters.iter().find(|(_, filter)| *filter == shadow.filter);
        ComboBox::from_label("filter")
            .selected_text(known.map_or("the file's", |(name, _)| *name))
            .show_ui(ui, |ui| {
                for (name, filter) in filters {
                    ui.selectable_value(&mut shadow.filter, filter, name);
                }
            });
        let mut is_stated = shadow.bias.is_some();
        ui.checkbox(&mut is_stated, "bias in metres");
        shadow.bias = is_stated.then(|| shadow.bias.unwrap_or(0.01));
        if let Some(bias) = &mut shadow.bias {
            ui.add(Slider::new(bias, 0.0..=0.5).logarithmic(true).text("bias [m]"));
        }
        ui.add(Slider::new(&mut shadow.slope_bias, 0.0..=8.0).text("slope bias [texels]"));
        ui.add(Slider::new(&mut shadow.normal_bias, 0.0..=8.0).text("normal bias [texels]"));
    }
}

/// Sliders for the compass direction that light comes from, and for the elevation of its source.
fn show_direction(ui: &mut Ui, direction: &mut Vec3) {
    let from = -direction.normalize_or(Vec3::NEG_Y);
    let mut azimuth = from.x.atan2(from.z).to_degrees();
    let mut elevation = from.y.clamp(-1.0, 1.0).asin().to_degrees();
    let turned = ui.add(Slider::new(&mut azimuth, -180.0..=180.0).text("azimuth [deg]")).changed();
    let lifted =
        ui.add(Slider::new(&mut elevation, -89.0..=89.0).text("elevation [deg]")).changed();
    if turned || lifted {
        let (sine, cosine) = azimuth.to_radians().sin_cos();
        let (up, level) = elevation.to_radians().sin_cos();
        *direction = -Vec3::new(sine * level, up, cosine * level);
    }
}

fn show_place(ui: &mut Ui, place: &mut Vec3, reach: f32) {
    ui.horizontal(|ui| {
        for (name, value) in ["x ", "y ", "z "].into_iter().zip(place.as_mut()) {
            ui.add(DragValue::new(value).speed(reach * 0.002).prefix(name).max_decimals(3));
        }
        ui.label("[m]");
    });
}
