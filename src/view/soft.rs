//! Texels and viewpoints of lights with a size, chosen by the penumbrae of a scene's triangles.
//!
//! Texels are as fine as the narrowest penumbrae need. A light gets more viewpoints if its middle does not
//! see many of the occluders that shade its penumbrae. Both follow from the scene as loaded and at the
//! moments of its [`Course`](crate::model::Course): all frames have the same.
use super::{View, detail::ShownPicture, shadow_views};
use crate::model::{
    Light, LightKind, MAX_MAP_SIZE, MIN_MAP_SIZE, Scene, SoftLight, Source, TILE_SIZE,
};
use penumbrae::{ONE_POINT, SeenPenumbrae, penumbrae};

mod penumbrae;

/// Largest number of lights that are considered.
const MOST_LIGHTS: usize = 8;
/// Viewpoints of all lights together.
const MOST_VIEWPOINTS: u32 = 64;
/// Number of penumbrae among which one may have fewer texels than it needs.
const FEW: usize = 300;
/// Least number of penumbrae that count.
const LEAST: usize = 8;
/// Mean share of a light behind occluders hidden from its middle, as far as it differs from the visible light
/// around, past which the light gets more viewpoints; and the share of penumbrae past which [`DEEP`] ones
/// have this effect.
const HIDDEN: f64 = 0.0008;
/// Share of a light behind hidden occluders that tears a shadow.
const DEEP: f64 = 0.25;
/// Share of the sampled places that must be in penumbrae for more texels and viewpoints in a picture.
const WORTH: f64 = 0.01;
/// Aspect ratio from which a rectangle is cut, because spots are blurred along its shorter edge.
const LONG: f32 = 8.0;

impl Scene {
    /// Gives lights with a size the texels and viewpoints that their penumbrae need, if
    /// [`ShadowSettings`](crate::ShadowSettings) say so. A stated size is the least, and a stated number of
    /// viewpoints (not 0) stays. `of_picture`: whether only places in the camera's view count, with texels no
    /// finer than a pixel.
    pub fn fit_soft_lights(&mut self, of_picture: bool) {
        let is_soft = |light: &Light| light.area().is_some() && light.cascades.is_none();
        let is_free = |light: &mut Light| {
            let is_free = light.viewpoints == 0;
            light.viewpoints = light.viewpoints.max(1);
            is_free
        };
        let free: Vec<bool> = self.lights.iter_mut().map(is_free).collect();
        if !self.shadow.soft_detail {
            return;
        }
        let soft = (0..self.lights.len()).filter(|&index| is_soft(&self.lights[index]));
        let soft: Vec<usize> = soft.take(MOST_LIGHTS).collect();
        if soft.is_empty() {
            return;
        }
        let mut seen = vec![[SeenPenumbrae::default(), SeenPenumbrae::default()]; soft.len()];
        let mut see = |scene: &Self| {
            let picture = of_picture.then(|| ShownPicture::new(scene));
            let views = shadow_views(scene);
            for (seen, &index) in seen.iter_mut().zip(&soft) {
                let light = &scene.lights[index];
                let is_first =
                    |view: &&View| view.light == Some(index) && view.shadow_index(light) == 0;
                for view in views.iter().filter(is_first) {
                    seen[0].add(penumbrae(scene, light, view, None));
                    seen[1].add(penumbrae(scene, light, view, picture.as_ref()));
                }
            }
        };
        let times: Vec<f64> = self.moments().iter().map(|moment| moment.seconds).collect();
        if times.is_empty() {
            see(self);
        } else {
            let mut solids = self.solids();
            for seconds in times {
                solids.set_time(seconds);
                see(&solids);
            }
        }
        let views = shadow_views(self);
        let wish = |(&index, [all, shown]): (&usize, &[SeenPenumbrae; 2])| {
            let light = &self.lights[index];
            let least =
                views.iter().filter(|view| view.light == Some(index)).map(|view| view.size.x);
            let least = least.max().unwrap_or(0);
            let is_large = shown.count as f64 > WORTH * shown.places as f64;
            let is_worth = !of_picture || is_large;
            let mut viewpoints = light.viewpoints;
            if free[index] && is_large {
                viewpoints = parts(light, shown);
            }
            SoftWish {
                light: index,
                asked: texels(all),
                size: if is_worth { stepped(texels(shown)).max(least) } else { least },
                least,
                viewpoints,
                is_free: free[index],
                views: light.all_shadows().next().map_or(0, |shadow| shadow.view_count()) as u64,
            }
        };
        let mut wishes: Vec<SoftWish> = soft.iter().zip(&seen).map(wish).collect();
        let budget = self.shadow.soft_budget.min(self.shadow.texel_budget);
        keep_within(
            &mut wishes,
            budget,
            MOST_VIEWPOINTS.saturating_sub(self.other_viewpoints(&soft)),
        );
        self.soft = wishes.iter().map(|wish| wish.chosen(&self.lights[wish.light])).collect();
        for SoftWish { light, size, least, viewpoints, .. } in wishes {
            let light = &mut self.lights[light];
            if size != least {
                light.size = Some(size);
            }
            light.viewpoints = viewpoints;
        }
    }

    fn other_viewpoints(&self, soft: &[usize]) -> u32 {
        let others = self.lights.iter().enumerate().filter(|(index, _)| !soft.contains(index));
        others.filter(|(_, light)| light.area().is_some()).map(|(_, it)| it.viewpoint_count()).sum()
    }
}

/// Texels and viewpoints that a light needs.
struct SoftWish {
    light: usize,
    /// Edge of a map that suffices for all penumbrae \[texels\].
    asked: u32,
    size: u32,
    /// Size without a choice \[texels\].
    least: u32,
    viewpoints: u32,
    /// Whether viewpoints may be chosen.
    is_free: bool,
    /// Views of a viewpoint.
    views: u64,
}

impl SoftWish {
    fn texels(&self) -> u64 {
        self.views * u64::from(self.viewpoints) * u64::from(self.size).pow(2)
    }

    fn chosen(&self, light: &Light) -> SoftLight {
        let &Self { asked, size, viewpoints, .. } = self;
        SoftLight { light: light.name.clone(), asked, size, viewpoints }
    }
}

/// Edge of a map that suffices for nearly all penumbrae \[texels\]; 0 for hardly any penumbrae.
fn texels(seen: &SeenPenumbrae) -> u32 {
    let mut texels: Vec<f64> = seen.penumbrae.iter().map(|penumbra| penumbra.texels).collect();
    if texels.len() < LEAST {
        return 0;
    }
    let at = texels.len() - 1 - texels.len() / FEW;
    *texels.select_nth_unstable_by(at, f64::total_cmp).1 as u32
}

/// `texels`, rounded up to eighths of a power of two; at most the largest map.
fn stepped(texels: u32) -> u32 {
    let whole = texels.clamp(MIN_MAP_SIZE, MAX_MAP_SIZE).next_power_of_two();
    let sizes = [5, 6, 7].map(|eighths| (whole / 8 * eighths).next_multiple_of(TILE_SIZE));
    sizes.into_iter().find(|&size| size >= texels).unwrap_or(whole)
}

/// Number of viewpoints for penumbrae.
fn parts(light: &Light, seen: &SeenPenumbrae) -> u32 {
    // One point of the light may be beyond the border of the middle's view.
    let hidden = seen.penumbrae.iter().map(|penumbra| (penumbra.hidden - ONE_POINT).max(0.0));
    let deep = seen.penumbrae.iter().filter(|penumbra| penumbra.hidden >= DEEP).count();
    let count = seen.penumbrae.len() as f64;
    let is_hidden = hidden.sum::<f64>() > HIDDEN * count || deep as f64 > HIDDEN * count;
    let is_point = matches!(light.kind, LightKind::Point { .. });
    match light.area() {
        // Spots are blurred along the shorter edge.
        Some(Source::Rect { width, height, .. }) => {
            let is_long = width.max(height) > LONG * width.min(height);
            if is_hidden || is_long { 4 } else { 1 }
        }
        Some(_) if is_hidden => 5 - u32::from(is_point),
        _ => 1,
    }
}

/// Keeps within a budget of texels and of viewpoints: first shrinks the largest maps, then maps of lights
/// with more viewpoints, down to half of their least edge, then takes viewpoints away.
fn keep_within(wishes: &mut [SoftWish], budget: u64, most: u32) {
    let texels = |wishes: &[SoftWish]| wishes.iter().map(SoftWish::texels).sum::<u64>();
    let smaller = |size: u32| (size * 7 / 8).next_multiple_of(16);
    while texels(wishes) > budget {
        let can = |wish: &&mut SoftWish| {
            let least =
                if wish.is_free && wish.viewpoints > 1 { wish.least / 2 } else { wish.least };
            smaller(wish.size) >= least && smaller(wish.size) < wish.size
        };
        let Some(largest) =
            wishes.iter_mut().filter(can).max_by_key(|wish| (wish.size > wish.least, wish.size))
        else {
            break;
        };
        largest.size = smaller(largest.size);
    }
    while texels(wishes) > budget || wishes.iter().map(|wish| wish.viewpoints).sum::<u32>() > most {
        let can = |wish: &&mut SoftWish| wish.is_free && wish.viewpoints > 1;
        let Some(last) = wishes.iter_mut().rfind(can) else { break };
        (last.viewpoints, last.size) = (1, last.least);
    }
}
