//! The panels around the picture.
use super::{
    app::App,
    inset,
    request::{Picked, receiver_name},
};
use eframe::egui::{
    Color32, ComboBox, Grid, ProgressBar, RichText, ScrollArea, Sense, Slider, Ui, vec2,
};
use gobo::Counters;

/// Colour of errors.
const RED: Color32 = Color32::from_rgb(255, 110, 100);

/// One line: the error, the kernels being compiled, or the device.
pub(super) fn show_status(app: &App, ui: &mut Ui) {
    ui.horizontal_wrapped(|ui| {
        if let Some(problem) = app.problem() {
            // Excerpts of files are marked below, so columns must align.
            ui.colored_label(RED, RichText::new(problem).monospace());
        } else if let Some((left, of, name)) = app.kernels {
            ui.spinner();
            ui.label(format!("kernels: {} of {of} made, {name}", of - left));
            ui.add(ProgressBar::new((of - left) as f32 / of as f32).desired_width(160.0));
        } else if app.shown.is_none() {
            ui.spinner();
            ui.label("the first picture is being made");
        } else {
            ui.label(&app.device);
        }
    });
}

pub(super) fn show_knobs(app: &mut App, ui: &mut Ui) {
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        ui.horizontal(|ui| {
            ui.heading(app.name());
            if ui.button("Read again").clicked() {
                app.read();
            }
        });
        if let Some(facts) = &app.facts {
            let (particles, triangles) = (facts.particles, facts.triangles);
            ui.label(format!(
                "{} particles, {} triangles",
                spaced(particles as u64),
                spaced(triangles as u64)
            ));
            for note in &facts.notes {
                ui.label(RichText::new(note).small().weak());
            }
        }
        ui.separator();
        ui.add(Slider::new(&mut app.scale, 0.1..=1.0).fixed_decimals(2).text("resolution"));
        if let Some(knobs) = &mut app.knobs {
            knobs.show(ui);
            ui.checkbox(&mut knobs.insets, "show the light's maps");
        }
        show_picked(app, ui);
        if app.shown.is_some() {
            ui.separator();
            show_times(app, ui);
            ui.separator();
            show_counters(app, ui);
        }
    });
}

/// Each light's share at the picked pixel.
fn show_picked(app: &mut App, ui: &mut Ui) {
    let (Some(knobs), Some(shown)) = (&mut app.knobs, &app.shown) else { return };
    ui.separator();
    let Some(picked) = shown.picked.as_ref().filter(|_| knobs.pick.is_some()) else {
        ui.label(RichText::new("click the picture: each light's share there").small().weak());
        return;
    };
    ui.horizontal(|ui| {
        ui.label("light at the point");
        if ui.small_button("clear").clicked() {
            knobs.pick = None;
        }
    });
    let Picked { surface: Some([_, at]), shares } = picked else {
        ui.label(RichText::new("no opaque surface is there").small());
        return;
    };
    ui.label(RichText::new(format!("x {:.3}, y {:.3}, z {:.3} m", at.x, at.y, at.z)).small());
    Grid::new("shares").num_columns(3).spacing(vec2(8.0, 2.0)).show(ui, |ui| {
        for (index, name) in knobs.light_names().enumerate() {
            let of_receivers = shares.iter().zip(&shown.pictures);
            for (shares, (receiver, _)) in of_receivers {
                let Some(&share) = shares.get(index) else { continue };
                ui.label(RichText::new(name).small());
                if shown.pictures.len() > 1 {
                    ui.label(RichText::new(receiver_name(*receiver)).small().weak());
                }
                let [r, g, b] = share.map(inset::to_srgb);
                let (place, _) = ui.allocate_exact_size(vec2(18.0, 11.0), Sense::hover());
                ui.painter().rect_filled(place, 2.0, Color32::from_rgb(r, g, b));
                let [r, g, b] = share;
                ui.label(RichText::new(format!("{r:.3} {g:.3} {b:.3}")).monospace().size(11.0));
                ui.end_row();
            }
        }
    });
}

fn show_times(app: &App, ui: &mut Ui) {
    let Some(shown) = &app.shown else { return };
    let Some((_, picture)) = shown.pictures.first() else { return };
    let [width, height] = picture.size;
    ui.label(format!("{width} x {height} pixels in {:.1} ms", shown.ms));
    let kept = shown.counters.views_kept;
    if kept > 0 {
        let text = format!("views unchanged: {kept}; times and counts are of their last rendering");
        ui.label(RichText::new(text).small().weak());
    }
    let most = app.stages.iter().map(|(_, ms)| *ms).fold(1e-6, f64::max);
    Grid::new("times").num_columns(3).spacing(vec2(8.0, 1.0)).show(ui, |ui| {
        for (stage, ms) in &app.stages {
            ui.label(RichText::new(*stage).small());
            ui.label(RichText::new(format!("{ms:.2} ms")).monospace().size(11.0));
            let (bar, _) = ui.allocate_exact_size(vec2(110.0, 8.0), Sense::hover());
            let share = vec2((ms / most) as f32 * bar.width(), bar.height());
            let filled = eframe::egui::Rect::from_min_size(bar.min, share);
            ui.painter().rect_filled(filled, 2.0, ui.visuals().selection.bg_fill);
            ui.end_row();
        }
    });
}

fn show_counters(app: &App, ui: &mut Ui) {
    let (Some(shown), Some(counters)) = (&app.shown, &app.counters) else { return };
    ui.label(format!("maps and picture take {:.1} MB", shown.memory as f64 / 1e6));
    Grid::new("counters").num_columns(2).spacing(vec2(8.0, 1.0)).show(ui, |ui| {
        for (name, count) in rows(counters) {
            ui.label(RichText::new(name).small());
            ui.label(RichText::new(spaced(count)).monospace().size(11.0));
            ui.end_row();
        }
    });
}

/// Counters by their names in the program's output; rarely used ones only if they are not 0.
fn rows(counters: &Counters) -> impl Iterator<Item = (&'static str, u64)> {
    let always = [
        ("casters", counters.casters),
        ("visible", counters.visible),
        ("culled", counters.culled),
        ("pairs", counters.pairs),
        ("segments", counters.segments),
        ("scattered", counters.scattered),
        ("views", counters.views_rendered + counters.views_kept),
    ];
    let rarely = [
        ("hidden", counters.hidden),
        ("overflowed", counters.overflowed),
        ("disordered", counters.disordered),
        ("masks", counters.masks),
        ("unmasked lights", counters.unmasked_lights),
        ("shrunk maps", counters.shrunk),
        ("dropped nodes", counters.nodes_dropped),
        ("short tiles", counters.short_tiles),
        ("clusters overflowed", counters.clusters_overflowed),
    ];
    always.into_iter().chain(rarely.into_iter().filter(|(_, count)| *count > 0))
}

pub(super) fn show_insets(app: &mut App, ui: &mut Ui) {
    let Some(shown) = &app.shown else { return };
    if shown.insets.is_empty() {
        ui.label("this light casts no shadows");
        return;
    }
    let view = app.view.min(shown.insets.len() - 1);
    ui.horizontal(|ui| {
        ui.vertical(|ui| {
            ui.set_width(110.0);
            let inset = &shown.insets[view];
            ui.label("view");
            ComboBox::from_id_salt("view").selected_text(inset.view).show_ui(ui, |ui| {
                for (index, inset) in shown.insets.iter().enumerate() {
                    ui.selectable_value(&mut app.view, index, inset.view);
                }
            });
            let [width, height] = inset.size;
            ui.label(RichText::new(format!("{width} x {height}")).small());
            ui.label(RichText::new("depths: near is white,\nnothing is blue").small().weak());
        });
        for (name, texture) in inset::NAMES.iter().zip(&app.insets[view]) {
            ui.vertical(|ui| {
                ui.label(RichText::new(*name).small());
                ui.image((texture.id(), vec2(132.0, 132.0)));
            });
        }
    });
}

/// Digits in groups of three: 12 345 678.
fn spaced(count: u64) -> String {
    let digits = count.to_string();
    let groups: Vec<&str> =
        digits.as_bytes().rchunks(3).rev().filter_map(|g| str::from_utf8(g).ok()).collect();
    groups.join(" ")
}
