use accel_core::structures::find;
use renderer::{Geometry, RayKind, RaySettings, generate_rays, render};
#[inline(never)]
fn image_pass(
    scene: &scene_loading::Scene,
    t: &dyn accel_core::tracer::Tracer<f32>,
    s: &RaySettings,
) -> renderer::Image {
    render(scene, t, s)
}
fn main() -> Result<(), Box<dyn std::error::Error>> {
    for name in std::env::args().skip(1) {
        let scene = scene_loading::procedural::generate(&name)?;
        let geometry = Geometry::<f32>::of(&scene)?;
        let entry = find("obvhs-cwbvh").ok_or("x")?;
        let tracer = entry.build(geometry.prims(), &entry.params([])?)?;
        let settings = RaySettings { resolution: [160, 120], ..RaySettings::default() };
        let image = image_pass(&scene, tracer.as_ref(), &settings);
        let mut h = 0xcbf29ce484222325u64;
        for x in image.pixels.iter().flatten() {
            h = (h ^ x.to_bits()).wrapping_mul(0x100000001b3);
        }
        let b = generate_rays(&scene, tracer.as_ref(), &settings);
        let mut g = 0xcbf29ce484222325u64;
        for k in RayKind::ALL {
            for r in b.rays(k) {
                for x in [
                    r.origin.x,
                    r.origin.y,
                    r.origin.z,
                    r.direction.x,
                    r.direction.y,
                    r.direction.z,
                    r.t_min,
                    r.t_max,
                ] {
                    g = (g ^ x.to_bits() as u64).wrapping_mul(0x100000001b3);
                }
            }
        }
        println!("{name} image {h:x} rays {g:x}");
    }
    Ok(())
}
