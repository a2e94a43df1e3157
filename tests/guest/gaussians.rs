//! Gaussians in the host's buffers give the same maps as uploads of them, to the last bit.
use super::{
    Bits, HostBuffers, ShadowSettings, Vec3, assert_equal, count_buffer, counted, particles,
    shadows, submit, views,
};
use crate::common::{
    TIERS, gpu,
    scenes::{Chance, nearest_depth},
    tiers,
};
use gobo::{
    CasterCount, CasterLoader, Casters, Error, Gaussian, HostCasters, HostInputs, Material,
    Particle, Prepared, Shadows, Shape, Transfer, Triangle,
    glam::{Quat, Vec4},
    gpu::{Gpu, Tier},
    host::Input,
    model::GaussianOpacity,
    wgpu::{self, BufferUsages},
};

/// A host's layout: positions with opacities in one buffer, scalar-first quaternions and the rest in another.
const WGSL: &str = "
@group(1) @binding(0) var<storage, read> places: array<vec4<f32>>;
struct Look { turn: vec4<f32>, sigma: vec3<f32>, material: u32, color: vec3<f32>, id: u32, }
@group(1) @binding(1) var<storage, read> looks: array<Look>;

fn load_gaussian(index: u32) -> Gaussian {
    let place = places[index];
    let look = looks[index];
    return Gaussian(place.xyz, place.w, look.turn.yzwx, look.sigma, look.material, look.color, look.id);
}
";

struct Buffers {
    layout: wgpu::BindGroupLayout,
    bindings: wgpu::BindGroup,
}

impl Buffers {
    fn new(gpu: &Gpu, gaussians: &[Gaussian]) -> Self {
        let places: Vec<[f32; 4]> =
            gaussians.iter().map(|g| g.center.extend(g.opacity).to_array()).collect();
        let looks: Vec<[f32; 12]> = gaussians
            .iter()
            .map(|g| {
                let ([x, y, z, w], s, c) = (g.rotation.to_array(), g.sigma, g.color);
                let [material, id] = [g.material, g.id].map(f32::from_bits);
                [w, x, y, z, s.x, s.y, s.z, material, c.x, c.y, c.z, id]
            })
            .collect();
        let buffers = [
            gpu.upload("places", &places, BufferUsages::STORAGE),
            gpu.upload("looks", &looks, BufferUsages::STORAGE),
        ];
        let (layout, bindings) = super::bound(gpu, &buffers);
        Self { layout, bindings }
    }

    fn loader(&self, shadows: &Shadows) -> CasterLoader {
        shadows.gaussian_loader("splats.wgsl", WGSL, &self.layout).unwrap_or_else(|e| panic!("{e}"))
    }
}

pub(super) fn materials() -> Vec<Material> {
    let of = |transfer| Material { shape: Shape::Gaussian, transfer, ..Material::default() };
    let tint = Vec4::new(0.9, 0.7, 0.8, 0.9);
    vec![
        Material { tint, ..of(Transfer::Filter) },
        Material { gaussian: GaussianOpacity::Medium { density: 3.0 }, ..of(Transfer::Filter) },
        Material { neutral: true, ..of(Transfer::Smoke) },
        of(Transfer::Over),
        of(Transfer::Gain),
        Material { cutoff: 0.4, ..of(Transfer::Cutout) },
        of(Transfer::Dither),
        of(Transfer::None),
        Material { tint, ..Material::default() },
        Material { transfer: Transfer::Opaque, ..Material::default() },
        Material { shape: Shape::Brick, ..Material::default() },
    ]
}
const DISCS: u32 = 8;

/// Needles, pancakes and balls of these materials around the origin, some smaller than a texel.
pub(super) fn gaussians(count: usize, used: &[u32], seed: u64) -> Vec<Gaussian> {
    let mut chance = Chance::new(seed);
    let mut one = |id: u32| {
        let long = 0.003 * 100_f32.powf(chance.unit());
        let flat = long * chance.within(0.05, 1.0);
        let axis = chance.vec3(-1.0, 1.0).normalize_or(Vec3::X);
        let material = used[id as usize % used.len()];
        Gaussian {
            center: chance.vec3(-1.6, 1.6),
            rotation: Quat::from_axis_angle(axis, chance.within(0.0, 3.0)),
            sigma: [Vec3::new(long, flat, flat), Vec3::new(flat, long, long)][chance.below(2)],
            color: chance.vec3(0.0, 1.0) * if material == 4 { 3.0 } else { 1.0 },
            opacity: chance.within(0.02, 1.0),
            material,
            id,
        }
    };
    let mut all: Vec<_> = (0..count as u32).map(&mut one).collect();
    all.sort_by_key(|gaussian| gaussian.center.floor().as_ivec3().to_array());
    all
}

/// Uploaded casters beside the Gaussians.
#[derive(Clone, Copy, Default)]
struct Beside<'a> {
    particles: &'a [Particle],
    triangles: &'a [Triangle],
}

fn casters<'a>(
    materials: &'a [Material],
    gaussians: &'a [Gaussian],
    beside: Beside<'a>,
) -> Casters<'a> {
    let Beside { particles, triangles } = beside;
    Casters { gaussians, particles, triangles, materials, in_order: true, ..Casters::default() }
}

fn uploaded(
    gpu: &Gpu,
    shadows: &mut Shadows,
    gaussians: &[Gaussian],
    beside: Beside<'_>,
    settings: &ShadowSettings,
) -> Bits {
    let materials = materials();
    let casters = casters(&materials, gaussians, beside);
    submit(gpu, &shadows.prepare(&casters, &views(), settings).unwrap())
}

fn on_device(
    shadows: &mut Shadows,
    sets: &[HostCasters<'_>],
    beside: Beside<'_>,
    settings: &ShadowSettings,
) -> Prepared {
    let materials = materials();
    let inputs = HostInputs::new().casters(sets);
    let casters = casters(&materials, &[], beside);
    shadows.prepare_with(&casters, &views(), settings, &inputs).unwrap()
}

fn settings() -> ShadowSettings {
    nearest_depth()
}

fn curve() -> ShadowSettings {
    ShadowSettings::default()
}

/// Fixed and indirect counts: none, few, one more than a group, and many.
#[test]
fn maps_equal_those_of_uploads() {
    for tier in tiers(Tier::Core) {
        let gpu = gpu(tier);
        let mut shadows = shadows(&gpu);
        for count in [0, 1, 257, 3000] {
            let all = gaussians(count, &[0, 1, 2], 7);
            let expected = uploaded(&gpu, &mut shadows, &all, Beside::default(), &settings());
            let host = Buffers::new(&gpu, &gaussians(count.max(1), &[0, 1, 2], 7));
            let loader = host.loader(&shadows);
            let counts = count_buffer(&gpu, count as u32);
            for counter in [CasterCount::Fixed(count as u32), counted(&counts, count as u32 + 300)]
            {
                let set = HostCasters::new(&loader, &host.bindings, counter, &[0, 1, 2]);
                let set = set.least_alpha(0.001);
                let prepared = on_device(&mut shadows, &[set], Beside::default(), &settings());
                let mut bits = submit(&gpu, &prepared);
                if count == 1 {
                    // The upload is a splat alone, whose kernels round depths separately.
                    for (depth, expected) in bits.nearests.iter_mut().zip(&expected.nearests) {
                        assert!(depth.abs_diff(*expected) <= 1, "{tier}: {depth:x} {expected:x}");
                        *depth = *expected;
                    }
                }
                assert_equal(&bits, &expected, &format!("{tier}: {counter:?}"));
                let counters = prepared.counters().unwrap();
                assert_eq!((counters.casters, counters.skipped.len()), (count as u64, 0));
            }
            let shade = expected.filters.iter().filter(|texel| texel[1] < 0x3b00).count();
            assert!(count < 257 || shade > 500, "{count}: {shade} texels are in shade");
        }
    }
}

/// Curves, order-dependent blending, amplification, and blocking casters.
#[test]
fn all_modes_of_gaussians_can_come_from_the_host() {
    bits_are_those_of_uploads(
        Tier::Core,
        &[(&[0, 1], curve()), (&[4], settings()), (&[5, 6], settings()), (&[3], settings())],
    );
    let parts = ShadowSettings { pair_budget: 500, ..settings() };
    bits_are_those_of_uploads(
        Tier::Native,
        &[(&[3], curve()), (&[0, 1], parts), (&[5, 6], settings()), (&[2], settings())],
    );
}

#[test]
#[ignore = "kernels of the other tier: make test-all"]
fn all_modes_of_gaussians_can_come_from_the_host_on_the_other_tier() {
    bits_are_those_of_uploads(
        Tier::Native,
        &[(&[0, 1], curve()), (&[4], settings()), (&[5, 6], settings()), (&[3], settings())],
    );
    let parts = ShadowSettings { pair_budget: 500, ..settings() };
    bits_are_those_of_uploads(
        Tier::Core,
        &[(&[3], curve()), (&[0, 1], parts), (&[5, 6], settings()), (&[2], settings())],
    );
}

/// Materials of the Gaussians, and settings.
type Case<'a> = (&'a [u32], ShadowSettings);

fn bits_are_those_of_uploads(tier: Tier, cases: &[Case<'_>]) {
    let gpu = gpu(tier);
    let mut shadows = shadows(&gpu);
    for &(used, settings) in cases {
        let all = gaussians(600, used, 9);
        let expected = uploaded(&gpu, &mut shadows, &all, Beside::default(), &settings);
        let host = Buffers::new(&gpu, &all);
        let loader = host.loader(&shadows);
        let set = HostCasters::new(&loader, &host.bindings, CasterCount::Fixed(600), used);
        let set = set.least_alpha(0.001);
        let prepared = on_device(&mut shadows, &[set], Beside::default(), &settings);
        let bits = submit(&gpu, &prepared);
        assert_equal(&bits, &expected, &format!("{tier}: {used:?} {:?}", settings.receiver));
        let blocks = bits.opaques.iter().any(|&depth| depth < 1.0_f32.to_bits());
        assert_eq!(blocks, used.contains(&5), "{used:?}");
    }
}

/// Uploaded triangles and discs, and sets of discs and Gaussians, some of which block, give the same maps as
/// all uploaded.
#[test]
fn gaussians_and_discs_of_the_host_are_one_frame() {
    for tier in tiers(Tier::Native) {
        let gpu = gpu(tier);
        let mut shadows = shadows(&gpu);
        let splats = gaussians(520, &[0, 1], 2);
        let blocking = gaussians(40, &[5], 3);
        let mut discs = particles(300, 1);
        discs.iter_mut().for_each(|disc| disc.material = DISCS);
        let corners =
            [Vec3::new(-2.0, -1.5, -2.0), Vec3::new(2.0, -1.5, -2.0), Vec3::new(0.0, -1.5, 2.0)];
        let floor = Triangle::flat(corners, 9);
        let beside = Beside { triangles: &[floor], ..Beside::default() };
        let all = [&splats[..], &blocking].concat();
        let expected =
            uploaded(&gpu, &mut shadows, &all, Beside { particles: &discs, ..beside }, &settings());
        let [of_splats, of_blocking] =
            [&splats, &blocking].map(|gaussians| Buffers::new(&gpu, gaussians));
        let of_discs = HostBuffers::new(&gpu, &discs);
        let (loader, disc_loader) = (of_splats.loader(&shadows), of_discs.loader(&shadows));
        let counts = count_buffer(&gpu, 520);
        let sets = [
            HostCasters::new(&loader, &of_splats.bindings, counted(&counts, 1000), &[0, 1])
                .least_alpha(0.001),
            HostCasters::new(&loader, &of_blocking.bindings, CasterCount::Fixed(40), &[5]),
            HostCasters::new(&disc_loader, &of_discs.bindings, CasterCount::Fixed(300), &[DISCS])
                .least_alpha(0.01),
        ];
        let prepared = on_device(&mut shadows, &sets, beside, &settings());
        let bits = submit(&gpu, &prepared);
        assert_equal(&bits, &expected, &tier.to_string());
        assert_eq!(prepared.counters().unwrap().casters, 861);
    }
}

#[test]
fn gaussians_that_cannot_be_used_are_counted_and_change_nothing() {
    let good = gaussians(1, &[0], 5)[0];
    let dense = Gaussian { material: 1, ..good };
    let wrong = [
        Gaussian { center: Vec3::new(0.0, f32::NAN, 0.0), ..good },
        Gaussian { center: Vec3::new(f32::INFINITY, 0.0, 0.0), ..good },
        Gaussian { center: Vec3::new(0.0, 0.0, -1.1e7), ..good },
        Gaussian { sigma: Vec3::new(0.1, 0.0, 0.1), ..good },
        Gaussian { sigma: Vec3::new(0.1, 0.1, -0.1), ..good },
        Gaussian { sigma: Vec3::new(f32::NAN, 0.1, 0.1), ..good },
        Gaussian { sigma: Vec3::new(0.1, f32::INFINITY, 0.1), ..good },
        Gaussian { rotation: Quat::from_xyzw(0.0, 0.0, 0.0, 0.0), ..good },
        Gaussian { rotation: Quat::from_xyzw(0.0, 0.0, 0.0, 1.1), ..good },
        Gaussian { rotation: Quat::from_xyzw(f32::NAN, 0.0, 0.0, 1.0), ..good },
        Gaussian { color: Vec3::new(0.5, 1.1, 0.5), ..good },
        Gaussian { color: Vec3::new(0.5, 0.5, f32::NAN), ..good },
        Gaussian { opacity: -0.1, ..good },
        Gaussian { opacity: 1.1, ..good },
        Gaussian { opacity: f32::INFINITY, ..good },
        Gaussian { opacity: 3e4, ..dense }, // 9e4 / m
        Gaussian { material: 99, ..good },
        Gaussian { material: 2, ..good },
        Gaussian { material: u32::MAX, ..good },
    ];
    // Outside of all views, at the largest valid distance, and a medium with an opacity above 1.
    let far = [
        Gaussian { center: Vec3::new(900.0, -300.0, 20.0), ..good },
        Gaussian { center: Vec3::splat(1e7), ..good },
        Gaussian { opacity: 7.0, sigma: Vec3::splat(0.02), ..dense },
    ];
    for tier in tiers(Tier::Core) {
        let gpu = gpu(tier);
        let mut shadows = shadows(&gpu);
        let mut usable = gaussians(400, &[0, 1], 6);
        let mut all = usable.clone();
        for (i, &gaussian) in wrong.iter().enumerate() {
            all.insert(i * 20, gaussian);
        }
        usable.extend(far);
        all.extend(far);
        let expected = uploaded(&gpu, &mut shadows, &usable, Beside::default(), &settings());
        let host = Buffers::new(&gpu, &all);
        let loader = host.loader(&shadows);
        let count = CasterCount::Fixed(all.len() as u32);
        let set = HostCasters::new(&loader, &host.bindings, count, &[0, 1]).least_alpha(0.001);
        let prepared = on_device(&mut shadows, &[set], Beside::default(), &settings());
        assert_equal(&submit(&gpu, &prepared), &expected, &tier.to_string());
        let counters = prepared.counters().unwrap();
        let skipped: u64 = counters.skipped.values().sum();
        assert_eq!((counters.casters, skipped), (403, wrong.len() as u64), "{counters:?}");
    }
}

#[test]
fn loaders_and_materials_of_other_shapes_are_named() {
    let gpu = gpu(TIERS[0]);
    let mut shadows = shadows(&gpu);
    let (splats, discs) =
        (Buffers::new(&gpu, &gaussians(4, &[0], 1)), HostBuffers::new(&gpu, &particles(4, 1)));
    let (of_splats, of_discs) = (splats.loader(&shadows), discs.loader(&shadows));
    let materials = materials();
    let casters = Casters { materials: &materials, ..Casters::default() };
    let four = CasterCount::Fixed(4);
    for (set, problem) in [
        (HostCasters::new(&of_splats, &splats.bindings, four, &[DISCS]), "not"),
        (HostCasters::new(&of_splats, &splats.bindings, four, &[0, DISCS]), "not"),
        (HostCasters::new(&of_splats, &splats.bindings, four, &[10]), "grids"),
        (HostCasters::new(&of_splats, &splats.bindings, four, &[7]), "casts nothing"),
        (HostCasters::new(&of_splats, &splats.bindings, four, &[0, 5]), "two sets"),
        (HostCasters::new(&of_discs, &discs.bindings, four, &[0]), "gaussian_loader"),
        (HostCasters::new(&of_discs, &discs.bindings, four, &[10]), "grids"),
    ] {
        let sets = [set];
        let inputs = HostInputs::new().casters(&sets);
        let error = shadows.prepare_with(&casters, &views(), &settings(), &inputs).unwrap_err();
        assert!(matches!(error, Error::Invalid { what: Input::HostCasters, .. }), "{error:?}");
        assert!(error.to_string().contains(problem), "{error}");
    }
    // A function of another kind, and a wrong field.
    let text = WGSL.replace("load_gaussian", "load_caster");
    let error = shadows.gaussian_loader("splats.wgsl", &text, &splats.layout).unwrap_err();
    assert!(error.to_string().contains("load_gaussian"), "{error}");
    let text = WGSL.replace("place.xyz, place.w", "place.w, place.xyz");
    let error = shadows.gaussian_loader("splats.wgsl", &text, &splats.layout).unwrap_err();
    assert!(error.to_string().contains("splats.wgsl:"), "{error}");
    assert!(gpu.check().is_ok());
}
