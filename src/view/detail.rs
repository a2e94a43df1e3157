//! Windows of finer texels where pictures would show coarse texels at edges of shadows.
//!
//! Small pictures of the triangles, seen by the camera and by the light, find places where edges of shadows
//! may be visible, and the widest texel there that is no wider than a pixel (`places.rs`). Edges that they
//! miss have the texels of the light's own map.
//!
//! How fine texels must be follows from `FINENESS`, `TEXELS` and [`SOFT`], what windows may cost from
//! [`PRICE`], [`LARGEST`] and [`MOST_TEXELS`]; the other constants bound the search.
//!
//! A moving scene is sampled at the moments of its [`Course`](crate::model::Course), so that a light at rest
//! has the same windows in all frames, whatever moves beside it; a moving light has windows for each frame.
use super::{
    View, ViewRole,
    atlas::{Atlas, AtlasLimits},
    fit::{MOST_DETAILS, detail_names, fitted_views},
};
use crate::model::{LightKind, Scene, ShadowFilter, WindowsKey};
use places::{COARSE, Seen};
pub(in crate::view) use places::{ShownPicture, TEXELS, source_axes};
use window::Window;

mod places;
mod window;

/// Largest number of lights with windows.
const MOST_LIGHTS: usize = 4;
/// Edge of the largest window \[texels\], half as many with curves; smaller ones have three quarters, a half
/// and so on.
const LARGEST: u32 = 2048;
/// Texels of the windows of a light's viewpoints together, in windows of [`LARGEST`] a side.
const MOST_TEXELS: f64 = 4.0;
/// Least gain of a window, per [`LARGEST`] texels of its edge: mean square of the excess width of texels.
const PRICE: f64 = 0.0033;
/// Width of a texel that is narrow enough for a light with a size, in that for other lights; and the least
/// ratio of its own texels to those of a window: its own maps are fine enough for most penumbrae, and windows
/// need levels.
const SOFT: f64 = 2.0;
/// Places for which the gain of a window is measured.
const ASKED: usize = 1000;

/// Takes the scene's state at a moment.
type See<'a> = &'a mut dyn FnMut(&Scene);

/// [`fitted_views`], with windows of finer texels before the views that they refine, if the scene's settings
/// ask for them.
pub fn picture_views(scene: &Scene, limits: &AtlasLimits) -> (Vec<View>, usize) {
    let (bases, shrunk) = fitted_views(scene, limits);
    let mut refined: Vec<usize> =
        (0..bases.len()).filter(|&index| has_windows(scene, &bases[index])).collect();
    let mut lights: Vec<_> = refined.iter().map(|&index| bases[index].light).collect();
    lights.dedup();
    lights.truncate(MOST_LIGHTS);
    refined.retain(|&index| lights.contains(&bases[index].light));
    if !scene.shadow.detail || refined.is_empty() {
        return (bases, shrunk);
    }
    let mut windows: Vec<Vec<View>> = vec![Vec::new(); bases.len()];
    let limits = limits.within(scene.shadow.texel_budget);
    for (index, of_light) in chosen(scene, &bases, &refined) {
        windows[index] = of_light;
        let sizes: Vec<_> = windows.iter().flatten().chain(&bases).map(|view| view.size).collect();
        if Atlas::pack(&sizes, &limits).is_none() {
            windows[index].clear();
        }
    }
    let with_windows = windows
        .into_iter()
        .zip(bases)
        .flat_map(|(windows, base)| windows.into_iter().chain(std::iter::once(base)));
    (with_windows.collect(), shrunk)
}

/// Whether windows may refine a view. Filters and blurs of a width in texels stay as wide as their user
/// chose. Light that glass throws into a window from outside would be missing there.
fn has_windows(scene: &Scene, base: &View) -> bool {
    let Some(light) = base.light.map(|index| &scene.lights[index]) else { return false };
    let shadow = &scene.shadow;
    let filter = light.look_up.filter.unwrap_or(shadow.filter);
    let is_narrow = match light.area() {
        Some(_) => shadow.soft_detail,
        None => {
            matches!(filter, ShadowFilter::None | ShadowFilter::Bilinear | ShadowFilter::Spline)
        }
    };
    let is_cone = matches!(light.kind, LightKind::Spot { .. }) && light.near.is_none();
    let is_sun = matches!(light.kind, LightKind::Directional { .. });
    is_narrow
        && shadow.blur == 0
        && !shadow.soften
        && !shadow.colored
        && base.role == ViewRole::Whole
        && light.caustics == 0
        && (is_cone || is_sun)
}

/// Windows for the `refined` of `bases`, by their indices, first for lights at rest.
fn chosen(scene: &Scene, bases: &[View], refined: &[usize]) -> Vec<(usize, Vec<View>)> {
    let moments = scene.moments();
    let choose = |wanted: &[usize], visit: &dyn Fn(See<'_>)| {
        let mut seen: Vec<Vec<Seen>> = vec![Vec::new(); wanted.len()];
        visit(&mut |scene| {
            let picture = ShownPicture::new(scene);
            for (seen, &index) in seen.iter_mut().zip(wanted) {
                seen.extend(picture.places(&bases[index]));
            }
        });
        let windows =
            seen.into_iter().zip(wanted).map(|(seen, &i)| windows(scene, &bases[i], seen));
        windows.collect::<Vec<_>>()
    };
    if moments.is_empty() {
        let windows = choose(refined, &|see| see(scene));
        return refined.iter().copied().zip(windows).collect();
    }
    let moves =
        |&&index: &&usize| bases[index].light.is_some_and(|light| scene.course.moves_light(light));
    let (moving, still): (Vec<usize>, Vec<usize>) = refined.iter().partition(moves);
    let key = WindowsKey {
        bases: still.iter().map(|&index| bases[index].clone()).collect(),
        camera: (!scene.course.moves_camera()).then_some(scene.camera),
        shadow: scene.shadow,
    };
    let of_still = scene.kept_windows(key, || {
        choose(&still, &|see| {
            let mut solids = scene.solids();
            for moment in moments {
                solids.set_time(moment.seconds);
                see(&solids);
            }
        })
    });
    let of_moving = choose(&moving, &|see| see(scene));
    still.into_iter().zip(of_still).chain(moving.into_iter().zip(of_moving)).collect()
}

/// Windows for `base`, the finest first, chosen one by one by how close texels come to the needed ones.
fn windows(scene: &Scene, base: &View, mut seen: Vec<Seen>) -> Vec<View> {
    seen.sort_by(|a, b| a.texel.total_cmp(&b.texel));
    let coarsest = 1.0 / f64::from(base.scale);
    let largest = if scene.shadow.curve_nodes() == 0 { LARGEST } else { LARGEST / 2 };
    let light = &scene.lights[base.light.expect("only views of lights have windows")];
    let gain = if light.area().is_some() { SOFT } else { 1.0 };
    let wishes = window::wishes(&seen, largest, [coarsest, coarsest / gain]);
    let asked: Vec<Seen> = seen.iter().step_by(seen.len() / ASKED + 1).copied().collect();
    let price =
        |window: &Window| PRICE * asked.len() as f64 * f64::from(window.size) / f64::from(LARGEST);
    let most = MOST_TEXELS / f64::from(light.viewpoint_count());
    let mut chosen: Vec<&Window> = Vec::new();
    let mut least = excess(&asked, &chosen, coarsest);
    while chosen.len() < MOST_DETAILS {
        let left = most - chosen.iter().map(|window| window.area()).sum::<f64>();
        let small = wishes.iter().filter(|window| window.area() <= left);
        let gains = small.map(|window| {
            let cost = excess(&asked, &[&chosen[..], &[window]].concat(), coarsest);
            (least - cost - price(window), cost, window)
        });
        let best = gains.max_by(|a, b| a.0.total_cmp(&b.0));
        let Some((_, cost, window)) = best.filter(|&(gain, ..)| gain > 0.0) else { break };
        chosen.push(window);
        least = cost;
    }
    chosen.sort_by(|a, b| a.texel.total_cmp(&b.texel));
    let count = chosen.len() as u32;
    let names = detail_names(light, base.shadow_index(light));
    let views = (0..).zip(names).zip(chosen).map(|((index, name), window)| {
        let role = ViewRole::Window { index, count: count + 1, fade: window.fade() };
        View { name, role, ..window.view(scene, base) }
    });
    views.collect()
}

/// Excess width of texels over the needed width: squares of the ratio, summed over places.
fn excess(seen: &[Seen], windows: &[&Window], coarsest: f64) -> f64 {
    let of = |seen: &Seen| {
        let holds = windows.iter().filter(|window| window.holds(seen.place));
        let texel = holds.map(|window| window.texel).fold(coarsest, f64::min);
        // A texel as wide as places are apart is as bad as any wider one.
        (texel / seen.texel - 1.0).clamp(0.0, f64::from(COARSE)).powi(2)
    };
    seen.iter().map(of).sum()
}
