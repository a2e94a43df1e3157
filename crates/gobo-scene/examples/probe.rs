use gobo::view::{atlas::AtlasLimits, picture_views};
fn main() {
    for path in std::env::args().skip(1) {
        let options = gobo_scene::LoadOptions::default();
        let _ = &options;
        let scene = gobo_scene::load(path.as_ref()).unwrap();
        let clock = std::time::Instant::now();
        let (views, _) = picture_views(&scene, &AtlasLimits::CORE);
        println!("{path} {:.0} ms", clock.elapsed().as_secs_f64() * 1e3);
        for light in 0..scene.lights.len() {
            let l = &scene.lights[light];
            let of: Vec<_> = views.iter().filter(|v| v.light == Some(light)).collect();
            if !of.iter().any(|v| v.is_detail()) { continue }
            let base = of.iter().find(|v| !v.is_detail()).unwrap();
            print!("  {} area {} vp {} base {} |", l.name, l.area().is_some(), l.viewpoint_count(), base.size.x);
            for v in &of { if v.is_detail() { print!(" {} {} x{:.1}", v.name, v.size.x, v.scale / base.scale); } }
            println!();
        }
    }
}
