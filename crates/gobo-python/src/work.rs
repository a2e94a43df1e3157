//! Work on scenes, on a thread of its own.
use crate::{
    fault::Fault,
    job::Stop,
    look,
    maps::Maps,
    state::{LightName, State},
};
use gobo::{
    glam::Vec3,
    model::{Counters, ReceiverPoint},
};
use gobo_cli::{Needs, nodes_warning, nodes_warning_before};
use gobo_picture::{Picture, Receivers, RenderOptions, Renderer, Watch, set_to_relight};
use gobo_scene::Scene;
use std::ops::Range;
use toml::Table;

/// Most points per look-up: an interrupted call ends between two.
fn most_points(renderer: &Renderer, scene: &Scene) -> usize {
    // The reference renders all maps of a light with a size anew for each look-up.
    let is_costly = scene.lights.iter().any(|light| light.area().is_some());
    match (renderer.has_device(), renderer.is_software()) {
        (false, _) if !is_costly => 1 << 13,
        (true, true) => 1 << 17,
        _ => 1 << 20,
    }
}

/// Most shares per look-up.
const MOST_SHARES: usize = 1 << 23;
/// Farthest coordinate of a point [m].
const FARTHEST: f32 = 1e7;

/// Refuses work for which the host lacks memory.
fn check(needs: Needs, renderer: &Renderer, state: &State) -> Result<(), Fault> {
    let needs = Needs { backend_is_cpu: !renderer.has_device(), ..needs };
    needs.missing(&state.scene).map_or(Ok(()), |bytes| Err(Fault::Memory(bytes)))
}

/// Warnings from the counters of a frame.
fn warnings(scene: &Scene, counters: &Counters) -> Vec<String> {
    let Counters { shrunk, nodes_dropped, unmasked_lights, .. } = *counters;
    let mut all = Vec::from_iter(nodes_warning(&scene.shadow, nodes_dropped));
    if shrunk > 0 {
        all.push(format!(
            "{shrunk} shadow maps are smaller than they should be: the atlas is full; use a smaller \
             size for some \
             lights, or a larger texel_budget of shadow"
        ));
    }
    if unmasked_lights > 0 {
        all.push(format!(
            "{unmasked_lights} lights are shaded without a mask: all are taken; raise the limit of \
             mask, or give lights \
             a far"
        ));
    }
    all
}

/// The picture.
pub(crate) fn render(
    state: &mut State,
    renderer: &mut Renderer,
    camera: &Table,
    watch: Watch<'_>,
) -> Result<(Picture, Vec<String>), Fault> {
    look::with(state, camera, None, |state| {
        check(Needs { picture: true, ..Needs::default() }, renderer, state)?;
        let watch = Some(watch);
        let options = RenderOptions { light: true, watch, ..RenderOptions::default() };
        let frame = if state.scene.shutter > 0.0 {
            let (seconds, step) = (state.seconds, 1.0 / Scene::FRAME_RATE);
            let frame = renderer.render_at(&mut state.scene, seconds, step, &options);
            state.scene.set_time(seconds);
            frame?
        } else {
            renderer.render(&state.scene, &options)?
        };
        Ok((frame.picture, warnings(&state.scene, &frame.counters)))
    })
}

/// Maps of all views of a light.
pub(crate) fn maps(
    state: &mut State,
    renderer: &mut Renderer,
    light: &LightName,
    camera: &Table,
    curve: Option<u32>,
) -> Result<(Vec<Maps>, Vec<String>), Fault> {
    let index = state.light(light)?;
    look::with(state, camera, curve, |state| {
        // Only pictures have detail windows.
        state.scene.shadow.detail = false;
        check(Needs { maps: true, ..Needs::default() }, renderer, state)?;
        let options = RenderOptions {
            maps: true,
            maps_of: Some(index),
            maps_only: true,
            ..RenderOptions::default()
        };
        let frame = renderer.render(&state.scene, &options)?;
        let light = &state.scene.lights[index];
        let maps = frame.maps.into_iter().map(|maps| Maps::new(maps, light));
        Ok((maps.collect::<Result<_, _>>()?, warnings(&state.scene, &frame.counters)))
    })
}

/// Share of each light that reaches points, as a flat list, and a warning.
pub(crate) fn light(
    state: &State,
    renderer: &mut Renderer,
    points: &[ReceiverPoint],
    stop: &Stop,
) -> Result<(Vec<f32>, Option<String>), Fault> {
    let (count, lights) = (points.len(), state.scene.lights.len());
    check(Needs { points: count as u64, ..Needs::default() }, renderer, state)?;
    let mut shares = Vec::new();
    let bytes = 12 * count as u64 * lights as u64;
    shares.try_reserve_exact(count * lights).map_err(|_| Fault::Memory(bytes))?;
    if count > 0 && lights > 0 {
        let mut receivers = Receivers::default();
        receivers.extend(points.iter().map(|point| point.position));
        let at_a_time = (MOST_SHARES / lights).clamp(1, most_points(renderer, &state.scene));
        let mut look_up = renderer.point_look_up(&state.scene, receivers)?;
        for some in points.chunks(at_a_time) {
            stop.check()?;
            shares.extend(look_up.shares(some)?);
        }
    }
    Ok((shares.into_flattened(), nodes_warning_before(&state.scene)))
}

/// Share of the light that reaches splats, and a warning.
pub(crate) fn relight(
    state: &mut State,
    renderer: &mut Renderer,
    range: Range<usize>,
) -> Result<(Vec<[f32; 3]>, Option<String>), Fault> {
    let (shadow, lights) = (state.scene.shadow, state.scene.lights.clone());
    set_to_relight(&mut state.scene);
    let (shares, warning) = (shares(state, renderer, range), nodes_warning_before(&state.scene));
    (state.scene.shadow, state.scene.lights) = (shadow, lights);
    Ok((shares?, warning))
}

fn shares(
    state: &State,
    renderer: &mut Renderer,
    range: Range<usize>,
) -> Result<Vec<[f32; 3]>, Fault> {
    let scene = &state.scene;
    let Some(splats) = scene.gaussians.get(range.clone()) else {
        let message = format!("splats {range:?} of a scene of {}", scene.gaussians.len());
        return Err(Fault::input(message, "use splats that this scene returned"));
    };
    if splats.is_empty() {
        return Ok(Vec::new());
    }
    let points = splats.len() as u64 * scene.lights.len() as u64;
    check(Needs { points, ..Needs::default() }, renderer, state)?;
    Ok(renderer.relight(scene, splats)?)
}
/// Points with normals, each checked.
pub(crate) fn receivers(
    positions: &[[f32; 3]],
    normals: Option<&[[f32; 3]]>,
) -> Result<Vec<ReceiverPoint>, Fault> {
    if let Some(normals) = normals.filter(|normals| normals.len() != positions.len()) {
        let message = format!("{} normals of {} points", normals.len(), positions.len());
        return Err(Fault::input(message, "give one normal for each point, or none"));
    }
    let mut points = Vec::new();
    let bytes = size_of_val(positions) as u64 * 2;
    points.try_reserve_exact(positions.len()).map_err(|_| Fault::Memory(bytes))?;
    for (row, &position) in positions.iter().enumerate() {
        let position = Vec3::from(position);
        let normal = normals.map_or(Vec3::ZERO, |normals| normals[row].into());
        let is_near = position.is_finite() && position.abs().max_element() <= FARTHEST;
        // A normal of length zero counts as none.
        let unit = if normal == Vec3::ZERO { Some(normal) } else { normal.try_normalize() };
        let (true, Some(normal)) = (is_near, unit) else {
            let message = format!("points: row {row} is {position:?}, normal {normal:?}");
            let remedy = "positions must be finite and within 1e7 m, normals finite";
            return Err(Fault::input(message, remedy));
        };
        points.push(ReceiverPoint { position, normal });
    }
    Ok(points)
}
