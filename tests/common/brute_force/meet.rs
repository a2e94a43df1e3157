//! Intersections of rays with casters of each kind.
use super::*;

fn optics(material: &Material, alpha: f64, color: DVec3, depth: f64) -> Hit {
    let a = 1.0 - (1.0 - alpha) * (1.0 - f64::from(material.reflectivity));
    let filter = DVec3::ONE - a * (DVec3::ONE - color);
    let light = match material.transfer {
        Transfer::Filter => filter,
        Transfer::Stain => color * (1.0 - a),
        Transfer::Smoke => (1.0 - a) * filter,
        Transfer::Gain => color,
        Transfer::Over => DVec3::splat(1.0 - a),
        _ => DVec3::ONE,
    };
    let added = if material.transfer == Transfer::Over { color * a } else { DVec3::ZERO };
    Hit { light, added, opacity: a, presence: presence(material, a, light), depth, reach: 0.0 }
}

/// A hit, or a blocker of the light if its opacity and a pattern make it one.
fn met(material: &Material, hit: Hit) -> Met {
    let [nothing, solid] = match material.transfer {
        Transfer::Cutout => {
            [-SOLID_MARGIN, SOLID_MARGIN].map(|off| f64::from(material.cutoff) + off)
        }
        Transfer::Dither => [SOLID_MARGIN, 1.0 - SOLID_MARGIN],
        _ => return Met::Hit(hit),
    };
    match hit.opacity {
        opacity if opacity < nothing => Met::Nothing,
        opacity if opacity > solid => Met::Hit(hit),
        _ => Met::Edge,
    }
}

/// Strength by which a hit sets the nearest depth.
fn presence(material: &Material, opacity: f64, light: DVec3) -> f64 {
    let changes = matches!(material.transfer, Transfer::Stain | Transfer::Gain);
    opacity.max(if changes { (DVec3::ONE - light).abs().max_element() } else { 0.0 })
}

/// The hit of a caster smaller than a texel: its effect is reduced by the ratio of the areas.
fn thinned(material: &Material, hit: Hit, thin: f64) -> Hit {
    let light = DVec3::ONE - thin * (DVec3::ONE - hit.light);
    let (added, opacity) = (hit.added * thin, hit.opacity * thin);
    Hit { light, added, opacity, presence: presence(material, opacity, light), ..hit }
}

pub(super) fn meet_particle(
    scene: &Scene,
    eye: &Eye,
    ray: &Ray,
    particle: &Particle,
    material: &Material,
    opaque_depth: f64,
) -> Met {
    let center = f64s(particle.center);
    let texel_size = eye.texel_size(center);
    let grow = (std::f64::consts::FRAC_1_SQRT_2 * texel_size / f64::from(particle.radius)).max(1.0);
    let radius = f64::from(particle.radius) * grow;
    let tint = particle.color.as_dvec4() * material.tint.as_dvec4();
    let thin = 1.0 / (grow * grow);
    if material.shape == Shape::Puff {
        let whole = optics(material, tint.w, tint.truncate(), 0.0);
        let whole = thinned(material, whole, thin);
        return meet_puff(eye, ray, (center, radius), material, whole, opaque_depth);
    }
    // A lamp in the centre is in all planes through it: rays leave it there.
    let n = if eye.parallel { eye.forward } else { (center - eye.position).normalize_or_zero() };
    let slope = n.dot(ray.way);
    let t = n.dot(center - ray.start) / slope;
    if slope <= 0.0 || t <= 0.0 {
        return Met::Nothing;
    }
    let q = (ray.start + ray.way * t - center) / radius;
    // Far outside a quad's corners.
    if q.length_squared() > 9.0 {
        return Met::Nothing;
    }
    let up = if n.y.abs() > 0.99 { DVec3::Z } else { DVec3::Y };
    let (x0, rotation) = (up.cross(n).normalize(), f64::from(particle.rotation));
    let y0 = n.cross(x0);
    let x = x0 * rotation.cos() + y0 * rotation.sin();
    let y = y0 * rotation.cos() - x0 * rotation.sin();
    let q = DVec2::new(q.dot(x), q.dot(y));
    let (reach, soft) = match material.shape {
        Shape::Quad => (q.x.abs().max(q.y.abs()), false),
        _ => (q.length(), material.profile == Profile::Soft),
    };
    if !soft && (reach - 1.0).abs() * radius / eye.texel_size(ray.start + ray.way * t) < EDGE {
        return Met::Edge;
    }
    if reach > 1.0 {
        return Met::Nothing;
    }
    if eye.depth(t).abs() < DEPTH_MARGIN {
        return Met::Edge;
    }
    let profile = if soft { (1.0 - reach * reach).powi(2) } else { 1.0 };
    let uv = DVec2::new((q.x + 1.0) / 2.0, (1.0 - q.y) / 2.0);
    let image = sample(scene, material, uv);
    let color = (tint * image).truncate();
    let hit = optics(material, tint.w * image.w * profile, color, eye.depth(t));
    met(material, thinned(material, hit, thin))
}

pub(super) fn meet_gaussian(
    eye: &Eye,
    ray: &Ray,
    gaussian: &Gaussian,
    seen: &gaussian_truth::Seen,
    material: &Material,
    opaque_depth: f64,
) -> Met {
    let ends = [eye.ways(0.0), eye.ways(opaque_depth.min(1.0))];
    let met = gaussian_truth::meet(seen, gaussian, material, ray.start, ray.way, ends);
    let color = gaussian.color.as_dvec3() * material.tint.truncate().as_dvec3();
    let color = if material.neutral { DVec3::ZERO } else { color };
    let hit = optics(material, met.alpha, color, eye.depth(met.t));
    let mut hit = thinned(material, hit, met.thin);
    if met.deviation > 0.0 {
        // It absorbs all along the ray; its depth is within its extent, in front of the ray's end.
        hit.reach = 4.0 * met.deviation / (eye.far - eye.near);
        hit.depth = hit.depth.clamp(0.0, opaque_depth - 2.0 * DEPTH_MARGIN);
    } else if hit.depth.abs() < DEPTH_MARGIN || (hit.depth - 1.0).abs() < DEPTH_MARGIN {
        return Met::Edge;
    }
    Met::Hit(hit)
}

pub(super) fn meet_strand(
    eye: &Eye,
    ray: &Ray,
    strand: &Strand,
    material: &Material,
    opaque_depth: f64,
    visit: &mut dyn FnMut(Met),
) {
    let ends = [eye.ways(0.0), eye.ways(opaque_depth.min(1.0))];
    let least = |point: DVec3| {
        let distance = if eye.parallel { 1.0 } else { eye.along_axis(point) };
        std::f64::consts::FRAC_1_SQRT_2 * distance / eye.scale
    };
    let tint = material.tint.as_dvec4();
    for met in strand_truth::meet(strand, ray.start, ray.way, ends, least) {
        if met.is_tied {
            visit(Met::Edge);
            continue;
        }
        let Some(way) = met.way else { continue };
        let color = met.color.as_dvec4() * tint;
        let of_diameter = optics(material, color.w, color.truncate(), 0.0);
        let light = of_diameter.light.map(|passed| way.passed(passed));
        let opacity = 1.0 - way.passed(1.0 - of_diameter.opacity);
        // From the near plane on if the light is inside.
        let depth = eye.depth(way.enters).max(0.0);
        if way.miss < EDGE_OF_STRAND * eye.texel_size(ray.start + ray.way * way.enters)
            || (opacity - 1.0 / 255.0).abs() < OPACITY_OF_STRAND
            || (depth - 1.0).abs() < DEPTH_MARGIN
        {
            visit(Met::Edge);
            continue;
        }
        let added = if material.transfer == Transfer::Over {
            color.truncate() * opacity
        } else {
            DVec3::ZERO
        };
        visit(Met::Hit(Hit { light, added, opacity, presence: opacity, depth, reach: 0.0 }));
    }
}

/// `whole`: transfer of a whole diameter.
fn meet_puff(
    eye: &Eye,
    ray: &Ray,
    (center, radius): (DVec3, f64),
    material: &Material,
    whole: Hit,
    opaque_depth: f64,
) -> Met {
    let len = ray.way.length();
    let closest = (center - ray.start).dot(ray.way) / (len * len);
    let miss = (ray.start + ray.way * closest - center).length();
    let texel_size = eye.texel_size(ray.start + ray.way * closest);
    if (miss - radius).abs() < EDGE * texel_size.max(0.0) {
        return Met::Edge;
    }
    if miss > radius {
        return Met::Nothing;
    }
    let half = (radius * radius - miss * miss).sqrt() / len;
    let enter = (closest - half).max(eye.ways(0.0));
    let leave = (closest + half).min(eye.ways(opaque_depth));
    if leave <= enter {
        return Met::Nothing;
    }
    let share = (leave - enter) * len / (2.0 * radius);
    let light = whole.light.powf(share);
    let opacity = 1.0 - (1.0 - whole.opacity).powf(share);
    let presence = presence(material, opacity, light);
    let depth = eye.depth(enter);
    Met::Hit(Hit { light, added: DVec3::ZERO, opacity, presence, depth, reach: 0.0 })
}

pub(super) fn meet_brick(
    eye: &Eye,
    ray: &Ray,
    grid: &Grid,
    brick: &Brick,
    opaque_depth: f64,
) -> Met {
    let [from, to] = [0.0, opaque_depth].map(|depth| eye.ways(depth));
    let along = grid_truth::Line { start: ray.start, way: ray.way };
    if let Some(size) = grid_truth::constant_size(brick) {
        // A box of constant density has sharp edges.
        let center = along.start + along.way * 0.5 * (from + to);
        let aside = EDGE * eye.texel_size(center).max(0.0);
        let chord = |grow: f64| along.chord(grid, brick.origin.as_dvec3(), size, grow, [from, to]);
        let [less, more] = [-aside, aside].map(chord);
        if more - less > 8.0 * aside {
            return Met::Edge;
        }
    }
    let Some(inside) = along.integral(grid, brick, [from, to]) else { return Met::Nothing };
    let tau = f64::from(grid.factor) * inside.integral * f64s(grid.extinction);
    // Rounding decides whether a cell with hardly any density counts.
    let [begins, surely] = [inside.begins, inside.begins_surely].map(|way| eye.depth(way));
    let sooner = inside.sooner / (eye.far - eye.near);
    let opacity = 1.0 - (-tau.max_element()).exp();
    Met::Hit(Hit {
        light: (-tau).map(f64::exp),
        added: DVec3::ZERO,
        opacity,
        presence: opacity,
        depth: begins,
        reach: (surely - begins).max(sooner),
    })
}

/// Ray-triangle intersection (Möller and Trumbore 1997).
pub(super) fn meet_triangle(
    scene: &Scene,
    eye: &Eye,
    ray: &Ray,
    triangle: &Triangle,
    material: &Material,
) -> Met {
    let [a, b, c] = triangle.positions.map(f64s);
    for (from, to) in [(a, b), (b, c), (c, a)] {
        let Some([from, to]) = eye.edge(from, to) else { continue };
        let along = to - from;
        let part = ((ray.texel - from).dot(along) / along.length_squared()).clamp(0.0, 1.0);
        if (from + along * part).distance(ray.texel) < EDGE {
            return Met::Edge;
        }
    }
    let (ab, ac) = (b - a, c - a);
    let p = ray.way.cross(ac);
    let s = ray.start - a;
    let q = s.cross(ab);
    let (u, v, t) = (s.dot(p), ray.way.dot(q), ac.dot(q));
    let (u, v, t) = (u / ab.dot(p), v / ab.dot(p), t / ab.dot(p));
    if !(u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0) {
        return Met::Nothing;
    }
    let [uv_a, uv_b, uv_c] = triangle.uvs.map(Vec2::as_dvec2);
    let image = sample(scene, material, uv_a * (1.0 - u - v) + uv_b * u + uv_c * v);
    let tint = material.tint.as_dvec4() * image;
    met(material, optics(material, tint.w, tint.truncate(), eye.depth(t)))
}

fn sample(scene: &Scene, material: &Material, uv: DVec2) -> DVec4 {
    let Some(texture) = material.texture.map(|index| &scene.textures[index as usize]) else {
        return DVec4::ONE;
    };
    let at = uv * DVec2::new(f64::from(texture.width), f64::from(texture.height)) - 0.5;
    let (low, part) = (at.floor(), at - at.floor());
    let (mut plain, mut by_alpha) = (DVec4::ZERO, DVec3::ZERO);
    for (x, weight_x) in [(low.x, 1.0 - part.x), (low.x + 1.0, part.x)] {
        for (y, weight_y) in [(low.y, 1.0 - part.y), (low.y + 1.0, part.y)] {
            let texel = texel_of(texture, x as i64, y as i64) * (weight_x * weight_y);
            plain += texel;
            by_alpha += texel.truncate() * texel_of(texture, x as i64, y as i64).w;
        }
    }
    // If a transfer shows the colour of transparent texels, all count alike.
    match material.transfer {
        Transfer::Stain | Transfer::Gain | Transfer::Opaque => plain,
        _ if plain.w == 0.0 => plain,
        _ => (by_alpha / plain.w).extend(plain.w),
    }
}

fn texel_of(texture: &Texture, x: i64, y: i64) -> DVec4 {
    let x = x.rem_euclid(i64::from(texture.width)) as usize;
    let y = y.rem_euclid(i64::from(texture.height)) as usize;
    let first = (y * texture.width as usize + x) * 4;
    let linear = |byte: u8| {
        let v = f64::from(byte) / 255.0;
        if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
    };
    let rgba = &texture.rgba[first..first + 4];
    DVec4::new(linear(rgba[0]), linear(rgba[1]), linear(rgba[2]), f64::from(rgba[3]) / 255.0)
}
