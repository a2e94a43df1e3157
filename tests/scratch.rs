use crate::common::{gpu, scenes::*};
use gobo::{caster::*, cpu, glam::*, light::*, render::Renderer, view::shadow_views, gpu::{Gpu,Selection,Tier}};

fn scene(count: usize, mixed: bool) -> gobo::scene::Scene {
    let mut c = Chance::new(7);
    let mut mats = vec![material(Transfer::Filter)];
    let mut s0 = material(Transfer::Stain); s0.shape = Shape::Quad; mats.push(s0);
    let mut s1 = material(Transfer::Smoke); s1.profile = Profile::Flat; mats.push(s1);
    let mut s2 = material(Transfer::Filter); s2.shape = Shape::Puff; mats.push(s2);
    mats.push(material(Transfer::Opaque));
    let mut g = material(Transfer::Filter); g.tint = Vec4::new(0.2,0.7,0.9,0.8); mats.push(g);
    let mut s = empty(mats);
    s.shadow.size = 256;
    let r = 8.0 / 256.0 * 8.0;
    for i in 0..count {
        let mut p = particle(c.vec3(-4.0, 4.0), c.within(0.1*r, r), Vec4::new(c.unit(), c.unit(), c.unit(), 0.3*c.unit()));
        p.id = i as u32; p.rotation = c.within(0.0, 6.0);
        if mixed { p.material = (i % 5) as u32; if p.material == 4 && c.unit() < 0.9 { p.material = 0; } }
        s.particles.push(p);
    }
    for _ in 0..20 { let a = c.vec3(-4.0, 4.0); let m = 4 + c.below(2) as u32;
        s.triangles.push(triangle([a, a + c.vec3(-1.0,1.0), a + c.vec3(-1.0,1.0)], m)); }
    s.lights = vec![
        light(LightKind::Directional { direction: Vec3::new(-0.4,-1.0,-0.3).normalize() }),
        light(LightKind::Spot { position: Vec3::new(5.0,6.0,3.0), direction: Vec3::new(-5.0,-6.0,-3.0).normalize(), angle: 1.2 }),
        light(LightKind::Point { position: Vec3::new(0.3,0.2,0.1) }),
    ];
    s
}

fn run(tier: Option<Tier>, mixed: bool, budget: u32) {
    let mut s = scene(3000, mixed); s.shadow.pair_budget = budget;
    let t = std::time::Instant::now();
    let (want, wc) = cpu::render_maps(&s, &shadow_views(&s));
    println!("cpu {:?}", t.elapsed());
    let gpu = Gpu::new(&Selection { tier, ..Default::default() }).unwrap();
    println!("{} {}", gpu.adapter.name, gpu.tier_reason);
    let mut r = Renderer::on(gpu);
    let t = std::time::Instant::now();
    let f = r.render(&s, true).unwrap();
    println!("gpu {:?} {:?}", t.elapsed(), f.stages);
    let t = std::time::Instant::now();
    let f = r.render(&s, true).unwrap();
    println!("gpu again {:?} {:?}", t.elapsed(), f.stages);
    println!("{:?}\n{:?}", f.counters, wc);
    let mut bad = 0;
    for (a, b) in f.maps.iter().zip(&want) {
        let n = a.filter.len();
        let (mut df, mut dd, mut dz) = (0f32, 0f32, 0f32);
        let mut cnt = 0; let mut mf = 0.0;
        for i in 0..n {
            let e = (0..3).map(|c| (a.filter[i][c]-b.filter[i][c]).abs()).fold(0f32, f32::max);
            mf += b.filter[i][0] as f64;
            if e > 1e-3 { cnt += 1; }
            df = df.max(e); dd = dd.max((a.nearest[i]-b.nearest[i]).abs()); dz = dz.max((a.opaque[i]-b.opaque[i]).abs());
        }
        println!("{:?} {} F {df} ({cnt} bad of {n}, mean {}) D {dd} Z {dz}", a.view.light, a.view.name, mf / n as f64);
        bad += cnt;
    }
    assert!(bad < 50);
}
#[test] fn native() { run(None, false, 1<<24); }
#[test] fn native_mixed() { run(None, true, 1<<24); }
#[test] fn core_mixed() { run(Some(Tier::Core), true, 1<<24); }
#[test] fn native_overflow() { run(None, true, 4000); }
