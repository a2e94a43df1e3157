//! Twin of `wgsl/shade_*.wgsl`: the lit picture.
use super::{
    bin::bin,
    caster_hit::{Hit, Records, Target},
    maps::{SceneRecords, ViewCasters, depth_order},
    occlude::is_solid,
    project::ProjectParams,
    receive::{MapTexel, receive},
    threads::each,
    tile::{Tile, TileTexels},
};
use crate::{
    caster::{Material, Transfer},
    footprint::{Footprint, TRIANGLE_BIT},
    frame::{Picture, ViewMaps},
    scene::Scene,
    stage::shade::GpuLight,
    view::{GpuView, View},
};
use glam::{IVec2, Mat4, UVec2, Vec2, Vec3, Vec4Swizzles as _};
use std::f32::consts::PI;

/// What is behind less light than this is not seen.
const FAINT: f32 = 1.0 / 1024.0;

/// Lights, their views and maps, and the eye.
struct Eye<'a> {
    scene: &'a Scene,
    lights: Vec<GpuLight>,
    views: Vec<GpuView>,
    maps: &'a [ViewMaps],
    camera: GpuView,
    world_from_view: Mat4,
}

/// What the camera sees of opaque casters at one pixel.
#[derive(Clone, Copy)]
struct Surface {
    color: Vec3,
    /// Light depth of the camera's view.
    depth: f32,
}

/// The picture of a scene; `views` and `maps` are those of its lights.
pub fn render_picture(scene: &Scene, views: &[View], maps: &[ViewMaps]) -> Picture {
    let records = SceneRecords::new(scene);
    let view = View::from_camera(&scene.camera, &scene.bounds());
    let camera = view.to_gpu(0, UVec2::ZERO, 0);
    let lights = scene.lights.iter().enumerate();
    let eye = Eye {
        scene,
        lights: lights.map(|(index, light)| GpuLight::new(light, index, views)).collect(),
        views: views.iter().map(|view| view.to_gpu(0, UVec2::ZERO, 0)).collect(),
        maps,
        camera,
        world_from_view: camera.view_from_world.inverse(),
    };
    let params = ProjectParams { scatter: false, unseen: true };
    let ViewCasters { footprints, keys, rects, setups } = records.project(&camera, params);
    let hits = Records {
        view: &camera,
        casters: &records.casters,
        setups: &setups,
        materials: records.materials,
        images: &records.images,
    };
    let tiles = view.tiles();
    let tile_count = tiles.element_product();
    let sorted = depth_order(&keys);
    let bins = bin(&sorted, &rects, &[camera], tile_count, u32::MAX);
    let lit = each(footprints.len(), |i| {
        if rects[i].mask_view == 0 { Vec3::ZERO } else { eye.lit(&records, &footprints[i]) }
    });
    let shaded = each(tile_count as usize, |index| {
        let tile = Tile::new(&camera, index as u32);
        let casters: Vec<u32> = bins.tile(index).iter().map(|pair| pair.footprint).collect();
        let surfaces = eye.surfaces(hits, &tile, &footprints, &casters);
        eye.composite(hits, &tile, &footprints, &casters, &lit, &surfaces)
    });
    let size = scene.camera.size;
    let mut rgb = vec![[0; 3]; size.element_product() as usize];
    for (index, pixels) in shaded.iter().enumerate() {
        for (place, pixel) in Tile::new(&camera, index as u32).texels() {
            let at = pixel.y as u32 * size.x + pixel.x as u32;
            let srgb = to_srgb(tone(pixels[place]));
            rgb[at as usize] = srgb.to_array().map(|v| (v * 255.0 + 0.5) as u8);
        }
    }
    Picture { size, rgb }
}

impl Eye<'_> {
    fn point(&self, pixel: Vec2, depth: f32) -> Vec3 {
        let camera = &self.camera;
        let slope = (pixel - camera.size * 0.5) / camera.scale;
        let distance = camera.near + depth * (camera.far - camera.near);
        let view = Vec3::new(slope.x, -slope.y, -1.0) * distance;
        self.world_from_view.transform_point3(view)
    }

    fn eye(&self) -> Vec3 {
        self.world_from_view.w_axis.xyz()
    }

    fn sky(&self, y: f32) -> Vec3 {
        let up = 1.0 - y / self.camera.size.y;
        self.scene.background * (0.75 + (1.15 - 0.75) * up)
    }

    fn surfaces(
        &self,
        hits: Records<'_>,
        tile: &Tile,
        footprints: &[Footprint],
        casters: &[u32],
    ) -> TileTexels<Surface> {
        let mut found = TileTexels::filled((1.0_f32, u32::MAX));
        for &i in casters {
            let target = Target::new(hits, &footprints[i as usize]);
            if !target.material.transfer.is_opaque() {
                continue;
            }
            for (place, pixel) in tile.texels() {
                if let Some(hit) = target.hit(pixel, 1.0)
                    && is_solid(target.material, &hit)
                    && hit.depth < found[place].0
                {
                    found[place] = (hit.depth, i);
                }
            }
        }
        let mut surfaces = TileTexels::filled(Surface { color: Vec3::ZERO, depth: 1.0 });
        for (place, pixel) in tile.texels() {
            let (depth, caster) = found[place];
            let color = if depth < 1.0 {
                self.shade(hits, &footprints[caster as usize], pixel, depth)
            } else {
                self.sky(pixel.y)
            };
            surfaces[place] = Surface { color, depth };
        }
        surfaces
    }

    fn shade(&self, hits: Records<'_>, footprint: &Footprint, pixel: Vec2, depth: f32) -> Vec3 {
        let point = self.point(pixel, depth);
        let toward_eye = (self.eye() - point).normalize();
        let target = Target::new(hits, footprint);
        let material = target.material;
        let normal = facing(self.normal(footprint, hits, pixel).unwrap_or(toward_eye), toward_eye);
        let albedo = target.hit(pixel, 1.0).map_or(Vec3::ZERO, |hit| hit.color);
        let shine = 2.0 / (material.roughness * material.roughness).max(0.01);
        let gloss = 0.04 * (shine + 8.0) / 8.0;
        let up = 0.7 + 0.3 * (normal.y * 0.5 + 0.5);
        let mut light = self.scene.ambient * up * albedo + material.emission;
        for source in &self.lights {
            let (toward, radiance) = incoming(source, point);
            let slant = normal.dot(toward);
            if slant > 0.0 && radiance.max_element() > 1e-4 {
                let half_way = (toward + toward_eye).normalize();
                let highlight = gloss * normal.dot(half_way).max(0.0).powf(shine);
                let lift = normal * ((1.0 / slant.max(0.25)).min(4.0) * 0.5);
                let passed = self.shadow(source, point, lift, self.scene.shadow.bias);
                light += (albedo / PI + Vec3::splat(highlight)) * slant * radiance * passed;
            }
        }
        light
    }

    /// Of a triangle, interpolated.
    fn normal(&self, footprint: &Footprint, hits: Records<'_>, pixel: Vec2) -> Option<Vec3> {
        if footprint.caster & TRIANGLE_BIT == 0 {
            return None;
        }
        let met = hits.setups[footprint.red_green as usize].hit(pixel)?;
        let normals = self.scene.triangles[(footprint.caster & !TRIANGLE_BIT) as usize].normals;
        let weights = met.barycentric.to_array();
        let sum: Vec3 = normals.iter().zip(weights).map(|(&n, weight)| n * weight).sum();
        Some(sum.normalize_or(Vec3::Y))
    }

    /// The light that reaches the middle of a caster, scattered alike in all directions.
    fn lit(&self, records: &SceneRecords<'_>, footprint: &Footprint) -> Vec3 {
        let mut bias = self.scene.shadow.bias;
        let point = if footprint.caster & TRIANGLE_BIT == 0 {
            let caster = &records.casters[footprint.caster as usize];
            bias += caster.radius;
            caster.center
        } else {
            let [a, b, c] =
                self.scene.triangles[(footprint.caster & !TRIANGLE_BIT) as usize].positions;
            (a + b + c) / 3.0
        };
        self.lights.iter().fold(self.scene.ambient, |light, source| {
            let (_, radiance) = incoming(source, point);
            if radiance.max_element() <= 1e-4 {
                return light;
            }
            light + radiance * self.shadow(source, point, Vec3::ZERO, bias) * (0.5 / PI)
        })
    }

    fn shadow(&self, light: &GpuLight, point: Vec3, normal: Vec3, bias: f32) -> Vec3 {
        if light.view_count == 0 {
            return Vec3::ONE;
        }
        // The views of a light share projection and scale.
        let view = &self.views[light.first_view as usize];
        let away = point - light.position;
        let distance = if view.perspective > 0.0 { away.length() } else { 1.0 };
        let lifted = point + normal * (self.scene.shadow.normal_bias * distance / view.scale);
        // By the lifted point: near a seam it may lie on the next face, and its own shows nothing
        // there.
        let face = if light.kind == 2 { cube_face(lifted - light.position) } else { 0 };
        let index = (light.first_view + face) as usize;
        let view = &self.views[index];
        filtered(view, &self.maps[index], lifted, bias)
    }

    fn composite(
        &self,
        hits: Records<'_>,
        tile: &Tile,
        footprints: &[Footprint],
        casters: &[u32],
        lit: &[Vec3],
        surfaces: &TileTexels<Surface>,
    ) -> TileTexels<Vec3> {
        let mut passed = TileTexels::filled(Vec3::ONE);
        let mut color = TileTexels::filled(Vec3::ZERO);
        for &i in casters {
            let footprint = &footprints[i as usize];
            let target = Target::new(hits, footprint);
            let material = target.material;
            if material.transfer.is_opaque() {
                continue;
            }
            for (place, pixel) in tile.texels() {
                let Surface { depth, .. } = surfaces[place];
                let Some(hit) = target.hit(pixel, depth).filter(|hit| hit.depth < depth) else {
                    continue;
                };
                if passed[place].max_element() < FAINT {
                    continue;
                }
                let (added, through) =
                    self.layer(hits, footprint, material, &hit, pixel, lit[i as usize]);
                let before = passed[place];
                color[place] += before * added;
                passed[place] = before * through;
            }
        }
        for (place, _) in tile.texels() {
            let behind = passed[place] * surfaces[place].color;
            color[place] += behind;
        }
        color
    }

    /// Light that a layer adds, and the share of what is behind it that it lets through.
    fn layer(
        &self,
        hits: Records<'_>,
        footprint: &Footprint,
        material: &Material,
        hit: &Hit,
        pixel: Vec2,
        arriving: Vec3,
    ) -> (Vec3, Vec3) {
        let own = hit.color * arriving + material.emission;
        if material.transfer == Transfer::None {
            return (hit.opacity * (hit.color + material.emission), Vec3::ONE);
        }
        let covered = Vec3::splat(1.0 - hit.opacity);
        match self.normal(footprint, hits, pixel) {
            Some(normal) if material.transmission > 0.0 => {
                let point = self.point(pixel, hit.depth);
                let shine = self.reflection(point, normal, material.roughness);
                let scattered = (1.0 - material.transmission) * hit.opacity * own;
                (shine + scattered, covered.lerp(hit.light, material.transmission))
            }
            _ => (hit.opacity * own, covered),
        }
    }

    /// The sky and the lights in a pane.
    fn reflection(&self, point: Vec3, normal: Vec3, roughness: f32) -> Vec3 {
        let toward_eye = (self.eye() - point).normalize();
        let normal = facing(normal, toward_eye);
        let fresnel = 0.04 + 0.96 * (1.0 - normal.dot(toward_eye).clamp(0.0, 1.0)).powi(5);
        let mut light = (self.scene.background * 0.6 + self.scene.ambient) * fresnel;
        let shine = 2.0 / (roughness * roughness).max(0.002);
        for source in &self.lights {
            let parallel = source.kind == 0;
            let away = if parallel { -source.direction } else { source.position - point };
            let half_way = (away.normalize() + toward_eye).normalize();
            let square = if parallel { 1.0 } else { away.length_squared().max(1e-4) };
            light += source.color / square * (0.5 * normal.dot(half_way).max(0.0).powf(shine));
        }
        light
    }
}

fn facing(normal: Vec3, toward_eye: Vec3) -> Vec3 {
    if normal.dot(toward_eye) >= 0.0 { normal } else { -normal }
}

/// Towards the light, and its radiance before shadows.
fn incoming(light: &GpuLight, point: Vec3) -> (Vec3, Vec3) {
    if light.kind == 0 {
        return (-light.direction, light.color);
    }
    let away = point - light.position;
    let square = away.length_squared().max(1e-8);
    let ray = away / square.sqrt();
    let mut radiance = light.color / square;
    if light.kind == 1 {
        let range = light.cone_inner - light.cone_outer;
        let t = ((ray.dot(light.direction) - light.cone_outer) / range).clamp(0.0, 1.0);
        radiance *= t * t * (3.0 - 2.0 * t);
    }
    (-ray, radiance)
}

fn cube_face(away: Vec3) -> u32 {
    let size = away.abs();
    let (positive, face) = if size.x >= size.y && size.x >= size.z {
        (away.x > 0.0, 0)
    } else if size.y >= size.z {
        (away.y > 0.0, 2)
    } else {
        (away.z > 0.0, 4)
    };
    face + u32::from(!positive)
}

/// Nine texels, each asked for itself, weighted by a quadratic B-spline.
fn filtered(view: &GpuView, maps: &ViewMaps, point: Vec3, bias: f32) -> Vec3 {
    let p = view.view_from_world.transform_point3(point);
    let distance = -p.z;
    let spread = if view.perspective > 0.0 { view.scale / distance.max(1e-6) } else { view.scale };
    let place = Vec2::new(p.x, -p.y) * spread + view.size * 0.5;
    let range = view.far - view.near;
    let z = (distance - view.near) / range;
    let inside = place.cmpge(Vec2::ZERO).all() && place.cmple(view.size).all();
    if !(inside && (0.0..=1.0).contains(&z)) {
        return Vec3::ONE;
    }
    let middle = place.floor();
    let t = place - middle - 0.5;
    let weights = [0.5 * (0.5 - t) * (0.5 - t), 0.75 - t * t, 0.5 * (0.5 + t) * (0.5 + t)];
    let size = view.size.as_ivec2();
    let mut light = Vec3::ZERO;
    for (y, row) in weights.iter().enumerate() {
        for (x, column) in weights.iter().enumerate() {
            let step = IVec2::new(x as i32 - 1, y as i32 - 1);
            let at = (middle.as_ivec2() + step).clamp(IVec2::ZERO, size - 1);
            let index = (at.y * size.x + at.x) as usize;
            let texel = MapTexel {
                filter: maps.filter[index].into(),
                nearest: maps.nearest[index],
                opaque: maps.opaque[index],
            };
            light += receive(z, &texel, bias / range) * (column.x * row.y);
        }
    }
    light
}

/// Extended curve of Reinhard et al. 2002 on the brightest channel: hues stay as they are.
fn tone(light: Vec3) -> Vec3 {
    const WHITE: f32 = 4.0;
    let bright = light.max_element().max(1e-6);
    let curved = bright * (1.0 + bright / (WHITE * WHITE)) / (1.0 + bright * 0.6);
    (light * (curved / bright)).clamp(Vec3::ZERO, Vec3::ONE)
}

fn to_srgb(v: Vec3) -> Vec3 {
    Vec3::from_array(
        v.to_array()
            .map(|v| if v <= 0.003_130_8 { v * 12.92 } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 }),
    )
}
