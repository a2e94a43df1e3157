pub(crate) mod area_truth;
pub(crate) mod arrays;
pub(crate) mod brute_force;
pub(crate) mod compare;
pub(crate) mod edge_truth;
pub(crate) mod files;
pub(crate) mod gaussian_truth;
pub(crate) mod grid_truth;
pub(crate) mod model;
pub(crate) mod nano;
pub(crate) mod points;
pub(crate) mod records;
pub(crate) mod rounding;
pub(crate) mod scenes;
pub(crate) mod splats;
pub(crate) mod strand_truth;
pub(crate) mod vdb;
pub(crate) mod windows;

pub(crate) use gobo::gpu::Tier;
use gobo::{
    Shadows,
    gpu::{Gpu, KernelDesc, Selection},
    model::Receiver,
    records::Picture,
    shadows::Config,
};
use gobo_picture::{Frame, RenderOptions, Renderer};
use gobo_scene::Scene;
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError, TryLockError};

/// The repository.
pub(crate) const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

/// Folders of WGSL.
pub(crate) const WGSL: [&str; 2] = ["wgsl", "crates/gobo-picture/wgsl"];

/// The repository, or `GOBO_ROOT`: a packed test binary is elsewhere.
pub(crate) fn root() -> PathBuf {
    std::env::var_os("GOBO_ROOT").map_or_else(|| ROOT.into(), PathBuf::from)
}

pub(crate) const TIERS: [Tier; 2] = [Tier::Core, Tier::Native];

/// A value for each tier.
pub(crate) type ByTier<T> = [T; Tier::ALL.len()];

/// Tiers of a property's test: its usual one, so that the tests are spread over the devices; with
/// `GOBO_TEST_TIERS=all`, as in `make test-all`, all three. Kernels of the tiers differ by walks and sums,
/// which the comparisons with the CPU reference test on [`TIERS`]; the tier in between has the walks of one
/// and the sums of the other, and `maps::tiers` compares them.
pub(crate) fn tiers(usual: Tier) -> Vec<Tier> {
    let is_all = std::env::var("GOBO_TEST_TIERS").is_ok_and(|tiers| tiers == "all");
    if is_all { Tier::ALL.to_vec() } else { vec![usual] }
}

/// The device of a tier and its kernels, shared by all tests. Tests that count what a device makes take turns
/// with another one ([`counted_gpu`]); tests that make it fail, or count kernels, open their own
/// ([`own_gpu`]). A missing GPU fails the test; it never skips it.
pub(crate) fn gpu(tier: Tier) -> Gpu {
    static GPUS: ByTier<OnceLock<Gpu>> = [const { OnceLock::new() }; Tier::ALL.len()];
    GPUS[tier as usize].get_or_init(|| own_gpu(tier)).clone()
}

pub(crate) fn own_gpu(tier: Tier) -> Gpu {
    let selection = Selection { tier: Some(tier), ..Selection::default() };
    let gpu = Gpu::new(&selection).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(gpu.tier, tier, "{}", gpu.tier_reason);
    gpu
}

/// A device of the tier whose counters one test at a time reads while it holds the guard.
pub(crate) fn counted_gpu(tier: Tier) -> (Gpu, MutexGuard<'static, ()>) {
    static GPUS: ByTier<OnceLock<Gpu>> = [const { OnceLock::new() }; Tier::ALL.len()];
    static READER: Mutex<()> = Mutex::new(());
    let guard = READER.lock().unwrap_or_else(PoisonError::into_inner);
    (GPUS[tier as usize].get_or_init(|| own_gpu(tier)).clone(), guard)
}

/// Two devices of one instance that detect each other's resources. (Handles of two instances look alike.)
pub(crate) fn two_devices() -> [Gpu; 2] {
    let adapters = gobo::gpu::adapters(&Selection::default());
    let adapter = adapters.first().expect("there is an adapter");
    let core = Selection { tier: Some(Tier::Core), ..Selection::default() };
    [(); 2].map(|()| Gpu::open(adapter, &core).unwrap_or_else(|error| panic!("{error}")))
}

/// A renderer on the tier's device that scatters tiny particles, as on a GPU.
pub(crate) fn renderer(tier: Tier) -> Renderer {
    let mut renderer = Renderer::on(gpu(tier)).unwrap();
    renderer.configure(|config| config.toggles.scatter_tiny = true);
    renderer
}

/// A host's shadows, with the kernels that all tests share.
pub(crate) fn shadows(gpu: &Gpu) -> Shadows {
    let config = Config::new(gpu.tier, &gpu.adapter);
    Shadows::sharing(&gpu.device, &gpu.queue, config, gpu.kernels.clone()).unwrap()
}

/// One of two renderers of the tier's device, shared by all tests.
fn any_renderer(tier: Tier) -> MutexGuard<'static, Renderer> {
    static RENDERERS: ByTier<[OnceLock<Mutex<Renderer>>; 2]> =
        [const { [const { OnceLock::new() }; 2] }; Tier::ALL.len()];
    let [first, second] =
        RENDERERS[tier as usize].each_ref().map(|it| it.get_or_init(|| Mutex::new(renderer(tier))));
    match first.try_lock() {
        Ok(renderer) => renderer,
        Err(TryLockError::Poisoned(poisoned)) => poisoned.into_inner(),
        Err(TryLockError::WouldBlock) => second.lock().unwrap_or_else(PoisonError::into_inner),
    }
}

/// A frame with its maps and its picture; tiny particles take the scatter path, as on a GPU.
pub(crate) fn render(tier: Tier, scene: &Scene) -> Frame {
    let options = RenderOptions { maps: true, light: true, ..RenderOptions::default() };
    frame(tier, scene, true, &options)
}

/// The picture of the CPU reference.
pub(crate) fn reference_picture(scene: &Scene) -> Picture {
    let options = RenderOptions { light: true, ..RenderOptions::default() };
    Renderer::on_cpu().render(scene, &options).unwrap_or_else(|error| panic!("{error}")).picture
}

/// Like [`render`], without the picture, which takes longer than the maps.
pub(crate) fn map_frame(tier: Tier, scene: &Scene) -> Frame {
    map_frame_tiny(tier, scene, true)
}

/// Like [`map_frame`]; `scatter`: tiny particles take the scatter path.
pub(crate) fn map_frame_tiny(tier: Tier, scene: &Scene, scatter: bool) -> Frame {
    let options = RenderOptions { maps: true, maps_only: true, ..RenderOptions::default() };
    frame(tier, scene, scatter, &options)
}

/// Like [`map_frame`]; casters past the pair budget take the scatter path instead of parts of the tiles.
pub(crate) fn map_frame_scattered(tier: Tier, scene: &Scene) -> Frame {
    let options = RenderOptions { maps: true, maps_only: true, ..RenderOptions::default() };
    let mut renderer = any_renderer(tier);
    renderer.configure(|Config { toggles, .. }| {
        (toggles.scatter_tiny, toggles.parts, toggles.queued) = (true, false, false);
    });
    let frame = renderer.render(scene, &options);
    renderer.configure(|config| config.toggles.parts = true);
    frame.unwrap_or_else(|error| panic!("{error}"))
}

fn frame(tier: Tier, scene: &Scene, scatter: bool, options: &RenderOptions<'_>) -> Frame {
    let mut renderer = any_renderer(tier);
    // Queues close nodes of curves for many texels at once: `maps::queue` checks their order.
    let queued = scene.shadow.receiver != Receiver::Curve;
    renderer.configure(|config| {
        config.toggles.scatter_tiny = scatter;
        config.toggles.queued = queued && config.tuning.queued;
    });
    renderer.render(scene, options).unwrap_or_else(|error| panic!("{error}"))
}

pub(crate) fn parse(desc: &KernelDesc, tier: Tier) -> naga::Module {
    let wgsl = desc.link(tier).unwrap_or_else(|error| panic!("{}: {error}", desc.name)).wgsl;
    naga::front::wgsl::parse_str(&wgsl)
        .unwrap_or_else(|e| panic!("{}", e.emit_to_string_with_path(&wgsl, desc.name)))
}

/// All files in the `wgsl/` folders of all crates: path inside it, and text.
pub(crate) fn wgsl_files() -> Vec<(String, String)> {
    let roots = WGSL.map(|folder| std::path::Path::new(ROOT).join(folder));
    let (mut pending, mut files) = (roots.to_vec(), Vec::new());
    while let Some(path) = pending.pop() {
        if path.is_dir() {
            pending.extend(path.read_dir().unwrap().map(|entry| entry.unwrap().path()));
        } else {
            let inside = roots.iter().find_map(|root| path.strip_prefix(root).ok()).unwrap();
            let name = inside.to_str().unwrap().replace('\\', "/");
            files.push((name, std::fs::read_to_string(path).unwrap()));
        }
    }
    files.sort();
    files
}
