//! Writes the tables of `docs/curves.md`: `make quality`.
use gobo::cpu::curve::measure::{Method, Rays, Sample};

fn main() {
    for rays in Rays::ALL {
        let sample = Sample::new(rays);
        for method in Method::ALL {
            let clock = std::time::Instant::now();
            sample.build(method);
            let ns = clock.elapsed().as_secs_f64() * 1e9 / sample.hit_count() as f64;
            println!("{} {method:?} {:?} {ns:.0}", rays.name(), sample.error(method));
        }
    }
}
