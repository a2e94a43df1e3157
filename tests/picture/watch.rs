//! Long work says how far it is, and ends where its host wants.
use crate::common::{TIERS, files::read, gpu};
use gobo::Error;
use gobo_picture::{Frame, RenderOptions, Renderer, Watch};
use gobo_scene::Scene;
use std::{ops::ControlFlow, sync::Mutex};

const SCENE: &str = "
[camera]
eye = [1, 2, 3]
target = [0, 0.5, 0]
size = [24, 16]
samples = 3
[shadow]
size = 64
[[light]]
name = 'sun'
kind = 'directional'
direction = [-0.4, -1, -0.3]
[[material]]
name = 'ground'
transfer = 'opaque'
[[material]]
name = 'glass'
tint = [0.9, 0.3, 0.2, 0.8]
[[shape]]
kind = 'plane'
material = 'ground'
scale = [4, 1, 4]
[[shape]]
kind = 'pane'
material = 'glass'
translation = [0, 1, 0]
";

fn scene() -> Scene {
    read(SCENE).unwrap()
}

/// The shares that a frame tells of until there are `most`, and the frame.
fn told(
    renderer: &mut Renderer,
    most: usize,
    options: RenderOptions<'_>,
) -> (Vec<f32>, Result<Frame, Error>) {
    let told = Mutex::new(Vec::new());
    let watch = |share| {
        let mut told = told.lock().unwrap();
        told.push(share);
        if told.len() < most { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    };
    let frame = renderer.render(&scene(), &RenderOptions { watch: Some(Watch(&watch)), ..options });
    (told.into_inner().unwrap(), frame)
}

#[test]
fn parts_are_told_of_and_any_of_them_ends_the_work() {
    let whole = RenderOptions::default();
    let maps = RenderOptions { maps: true, maps_only: true, ..whole };
    let one = RenderOptions { sample: Some(1), ..whole };
    for mut renderer in [Renderer::on(gpu(TIERS[0])).unwrap(), Renderer::on_cpu()] {
        let parts: &[f32] =
            if renderer.has_device() { &[0.25, 0.5, 0.75, 1.0] } else { &[0.25, 1.0] };
        let (shares, frame) = told(&mut renderer, usize::MAX, whole);
        let expected = frame.unwrap().picture.rgb;
        assert_eq!(shares, parts);
        assert_eq!(told(&mut renderer, usize::MAX, maps).0, [1.0]);
        assert_eq!(told(&mut renderer, usize::MAX, one).0, [0.5, 1.0]);
        for most in 1..parts.len() {
            let (shares, frame) = told(&mut renderer, most, whole);
            assert!(matches!(frame, Err(Error::Stopped)), "{frame:?}");
            assert_eq!(shares, parts[..most]);
            // A stopped picture leaves nothing behind.
            assert_eq!(told(&mut renderer, usize::MAX, whole).1.unwrap().picture.rgb, expected);
        }
    }
}

/// Where the shutter is open, each sample is a frame of its own.
#[test]
fn frames_of_moving_scenes_tell_of_their_samples() {
    let mut renderer = Renderer::on(gpu(TIERS[0])).unwrap();
    let told = Mutex::new(Vec::new());
    let watch = |share| {
        told.lock().unwrap().push(share);
        ControlFlow::Continue(())
    };
    let options = RenderOptions { watch: Some(Watch(&watch)), ..RenderOptions::default() };
    let mut scene = Scene { shutter: 0.5, ..scene() };
    renderer.render_at(&mut scene, 0.0, 0.04, &options).unwrap();
    assert_eq!(told.into_inner().unwrap(), [1.0 / 3.0, 2.0 / 3.0, 1.0]);
}
