//! For tests: builds a plugin as rtbench does, and compares its answers with every triangle in f64.

use std::ffi::{CStr, CString, c_char, c_int, c_void};

use crate::abi::{self, Hit, Plugin, Prepared, Ray};
use crate::scene::Triangle;
use crate::triangle::Number;

/// Nearer to an edge than this, in parts of a triangle, or so near to an end of its interval, a ray may hit or not.
const EDGE: f64 = 1e-4;
/// Likewise where it meets the plane at a smaller sine than this, not far from the triangle.
const GRAZING: f64 = 0.03;
const NEAR: f64 = -0.1;
/// By so much, relatively, a parameter may differ.
const ROUNDING: f64 = 1e-4;

/// What a plugin built.
pub struct Trial<'a, T: Number = f32> {
    plugin: &'static Plugin,
    built: *mut c_void,
    triangles: &'a [Triangle<T>],
    transmissive: &'a [u8],
}

/// Answers that are wrong, of how many.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Faults {
    /// Rays whose hit is certain.
    pub certain: usize,
    /// A hit that is not found.
    pub lost: usize,
    /// A hit where there is none.
    pub invented: usize,
    /// Another triangle, or another parameter.
    pub elsewhere: usize,
    /// Of shadow rays.
    pub occlusion: usize,
}

impl Faults {
    /// All of them.
    pub fn sum(&self) -> usize {
        self.lost + self.invented + self.elsewhere + self.occlusion
    }
}

impl<'a, T: Number> Trial<'a, T> {
    /// Builds over triangles; a byte for each says whether shadow rays pass (none: nowhere). `settings` is as
    /// behind `-s NAME:`, other settings have their defaults.
    ///
    /// # Errors
    /// The reason of the plugin.
    ///
    /// # Panics
    /// If there is no such setting.
    pub fn build(
        describe: extern "C" fn() -> *const Plugin,
        triangles: &'a [Triangle<T>],
        transmissive: &'a [u8],
        settings: &str,
        threads: u32,
    ) -> Result<Self, String> {
        // SAFETY: what a plugin describes lives as long as the process
        let plugin = unsafe { &*describe() };
        let values = values(plugin, settings);
        let pointers: Vec<*const c_char> = values.iter().map(|value| value.as_ptr()).collect();
        let vertices = triangles.as_flattened();
        let indices: Vec<u32> = (0..vertices.len() as u32).collect();
        let scene = abi::Scene {
            size: size_of::<abi::Scene<T>>() as u32,
            threads,
            triangles: triangles.len() as u64,
            positions: vertices.as_flattened().as_ptr(),
            transmissive: if transmissive.is_empty() {
                std::ptr::null()
            } else {
                transmissive.as_ptr()
            },
            settings: pointers.as_ptr(),
            host: std::ptr::null(),
            prepare: prepare::<T>,
            intersect: intersect::<T>,
            vertex_count: vertices.len() as u64,
            vertices: vertices.as_flattened().as_ptr(),
            indices: indices.as_ptr(),
        };
        let (mut built, mut message) = (std::ptr::null_mut(), [0u8; 64]);
        let build = T::functions(plugin).build.expect("every plugin builds");
        // SAFETY: as rtbench.h says
        let code = unsafe {
            build(&raw const scene, &raw mut built, message.as_mut_ptr().cast(), message.len())
        };
        if code != 0 {
            let said = CStr::from_bytes_until_nul(&message).expect("messages end with a zero");
            return Err(said.to_str().expect("messages are UTF-8").to_owned());
        }
        Ok(Self { plugin, built, triangles, transmissive })
    }

    /// The closest hits.
    pub fn closest(&self, rays: &[Ray<T>]) -> Vec<Hit<T>> {
        let mut hits = vec![Hit::new(T::from(f32::NAN), 0x7fff_ffff); rays.len()];
        let closest = T::functions(self.plugin).closest.expect("every plugin answers");
        // SAFETY: as rtbench.h says
        unsafe { closest(self.built, rays.as_ptr(), hits.as_mut_ptr(), rays.len()) };
        hits
    }

    /// Which rays are blocked; none if the plugin has no query for it.
    pub fn occluded(&self, rays: &[Ray<T>]) -> Option<Vec<u8>> {
        let occluded = T::functions(self.plugin).occluded?;
        let mut blocked = vec![7; rays.len()];
        // SAFETY: as rtbench.h says
        unsafe { occluded(self.built, rays.as_ptr(), blocked.as_mut_ptr(), rays.len()) };
        Some(blocked)
    }

    /// What was built.
    pub fn stats(&self) -> abi::Stats {
        let mut stats = abi::Stats::empty();
        let ask = T::functions(self.plugin).stats.expect("every peer has these");
        // SAFETY: as rtbench.h says
        unsafe { ask(self.built, &raw mut stats) };
        stats
    }

    /// Asks for everything, and compares it.
    pub fn faults(&self, rays: &[Ray<T>]) -> Faults {
        let mut faults = Faults::default();
        let hits = self.closest(rays);
        let blocked = self.occluded(rays);
        for (i, ray) in rays.iter().enumerate() {
            let (nearest, first_doubt) = self.nearest(ray, |_| true);
            if nearest.map_or(f64::MAX, |(_, t)| t) < first_doubt {
                faults.certain += 1;
                match (nearest, hits[i].id) {
                    (None, abi::MISS) => {}
                    (None, _) => faults.invented += 1,
                    (Some(_), abi::MISS) => faults.lost += 1,
                    (Some((id, t)), found) => {
                        let is_near = (hits[i].t.into() - t).abs() <= ROUNDING * t.abs();
                        faults.elsewhere += usize::from(found as usize != id || !is_near);
                    }
                }
            }
            let is_opaque = |id: usize| self.transmissive.get(id).is_none_or(|flag| *flag == 0);
            let (nearest, first_doubt) = self.nearest(ray, is_opaque);
            let is_certain = nearest.is_some() || first_doubt.is_infinite();
            if let (Some(blocked), true) = (&blocked, is_certain) {
                faults.occlusion += usize::from(blocked[i] != u8::from(nearest.is_some()));
            }
        }
        faults
    }

    /// The nearest hit of the triangles chosen, if there is one; and where the first one lies that may be one.
    fn nearest(&self, ray: &Ray<T>, of: impl Fn(usize) -> bool) -> (Option<(usize, f64)>, f64) {
        let mut nearest: Option<(usize, f64)> = None;
        let mut first_doubt = f64::INFINITY;
        let (low, high) = (ray.t_min.into(), ray.t_max.into());
        let length = ray.direction.map(|x| x.into().powi(2)).iter().sum::<f64>().sqrt();
        for (id, triangle) in self.triangles.iter().enumerate().filter(|(id, _)| of(*id)) {
            let (inside, t, sine) = hit(triangle, ray);
            let is_grazing = sine < GRAZING && inside > NEAR;
            let is_at_an_end = [low, high].iter().any(|end| (t - end).abs() * length < EDGE);
            if is_at_an_end && inside > -EDGE || (is_grazing || inside.abs() <= EDGE) && t > 0.0 {
                first_doubt = first_doubt.min(t);
            } else if inside > 0.0
                && t >= low
                && t <= high
                && nearest.is_none_or(|(_, best)| t < best)
            {
                nearest = Some((id, t));
            }
        }
        (nearest, first_doubt * (1.0 - EDGE))
    }
}

impl<T: Number> Drop for Trial<'_, T> {
    fn drop(&mut self) {
        let destroy = T::functions(self.plugin).destroy.expect("every plugin has this");
        // SAFETY: as rtbench.h says
        unsafe { destroy(self.built) };
    }
}

fn values(plugin: &Plugin, settings: &str) -> Vec<CString> {
    // SAFETY: as rtbench.h says
    let described =
        unsafe { std::slice::from_raw_parts(plugin.settings, plugin.settings_count as usize) };
    // SAFETY: likewise
    let text = |text| unsafe { CStr::from_ptr(text) };
    let mut values: Vec<CString> = described.iter().map(|s| text(s.initial).to_owned()).collect();
    for (name, value) in settings.split_whitespace().filter_map(|part| part.split_once('=')) {
        let at = described.iter().position(|setting| text(setting.name).to_str() == Ok(name));
        values[at.unwrap_or_else(|| panic!("no setting {name}"))] =
            CString::new(value).expect("no zeros");
    }
    values
}

/// How far inside a triangle a ray's line goes, in parts of it (negative: outside), its parameter there, and the
/// sine of its angle with the plane.
fn hit<T: Number>(triangle: &Triangle<T>, ray: &Ray<T>) -> (f64, f64, f64) {
    let [a, b, c] = triangle.map(|corner| corner.map(Into::into));
    let (origin, direction) = (ray.origin.map(Into::into), ray.direction.map(Into::into));
    let minus = |a: [f64; 3], b: [f64; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let cross = |a: [f64; 3], b: [f64; 3]| {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    };
    // the volumes that the line makes with each edge
    let [oa, ob, oc] = [a, b, c].map(|corner| minus(corner, origin));
    let volumes = [(ob, oc), (oc, oa), (oa, ob)].map(|(p, q)| dot(direction, cross(p, q)));
    let sum: f64 = volumes.iter().sum();
    let inside = volumes.map(|volume| volume / sum).into_iter().fold(f64::INFINITY, f64::min);
    let normal = cross(minus(b, a), minus(c, a));
    let towards = dot(direction, normal);
    let sine = towards.abs() / (dot(direction, direction) * dot(normal, normal)).sqrt();
    (inside, dot(oa, normal) / towards, sine)
}

/// So many triangles of all directions and both windings, in a unit cube and a little around; none is a sliver.
pub fn triangles(count: usize) -> Vec<Triangle> {
    (0..count)
        .map(|i| {
            let (from, turn) = (point(i), point(count + i));
            let size = if i.is_multiple_of(10) { 0.5 } else { 0.15 };
            // two directions that are nearly at right angles
            let [x, y, z] = turn.map(|part| part - 0.5);
            let (u, v) = ([x, y, z + 0.6], [z + 0.6, 0.5 * y, -x]);
            let along = |d: [f32; 3]| std::array::from_fn(|k| from[k] + size * d[k]);
            [from, along(u), along(v)]
        })
        .collect()
}

/// A byte for each of so many triangles: every third one lets shadow rays pass.
pub fn glass(count: usize) -> Vec<u8> {
    (0..count).map(|id| u8::from(id % 3 == 0)).collect()
}

/// So many rays through the cube: from outside and inside, of all lengths and with all kinds of intervals.
pub fn rays(count: usize) -> Vec<Ray> {
    (0..count)
        .map(|i| {
            // none begins at a corner of a triangle
            let (from, to) = (point(2 * i + 1_000_003), point(2 * i + 1_000_004));
            let length = [1.0, 0.01, 300.0][i % 3];
            let outside = if i.is_multiple_of(2) { 4.0 } else { 1.0 };
            let origin: [f32; 3] = std::array::from_fn(|k| 0.5 + outside * (from[k] - 0.5));
            let direction = std::array::from_fn(|k| length * (to[k] - origin[k]));
            let t_min = [0.0, 0.4 / length, 0.0, 1e-3 / length][i / 6 % 4];
            let t_max = [f32::INFINITY, f32::INFINITY, 0.9 / length][i / 24 % 3];
            Ray { origin, t_min, direction, t_max }
        })
        .collect()
}

/// A closed surface of triangles around a point, and rays from within to its corners, along its edges and
/// parallel to axes: all hit it.
pub fn closed_surface(center: [f32; 3], radius: f32) -> (Vec<Triangle>, Vec<Ray>) {
    const STEPS: usize = 24;
    let corner = |i: usize, j: usize| -> [f32; 3] {
        // both poles, and the seam, are one point each
        let [down, around] = [i * 12, (j % STEPS) * 24].map(|k| k as f32 / 288.0 * 3.141_592_7);
        let ring = if i.is_multiple_of(STEPS) { 0.0 } else { down.sin() };
        let at = [ring * around.cos(), down.cos(), ring * around.sin()];
        std::array::from_fn(|k| center[k] + radius * at[k])
    };
    let (mut surface, mut rays) = (Vec::new(), Vec::new());
    let mut ray = |origin, direction| {
        rays.push(Ray { origin, t_min: 0.0, direction, t_max: f32::INFINITY });
    };
    for n in 0..STEPS * STEPS {
        let (i, j) = (n / STEPS, n % STEPS);
        let [a, b, c, d] =
            [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| corner(i, j));
        surface.extend([[a, b, c], [a, c, d]]);
        for step in 0..10 {
            let turn = |k: usize| ((n * 10 + step + 7 * k) as f32 * 0.618).fract() - 0.5;
            let origin: [f32; 3] = std::array::from_fn(|k| center[k] + 0.5 * radius * turn(k));
            let (to, part) = (if step < 5 { b } else { c }, (step % 5) as f32 / 4.0);
            let direction = std::array::from_fn(|k| a[k] + part * (to[k] - a[k]) - origin[k]);
            ray(origin, direction);
        }
        let axis = n % 3;
        let origin = std::array::from_fn(|k| if k == axis { center[k] } else { b[k] });
        let is_within = (0..3).map(|k| (origin[k] - center[k]).powi(2)).sum::<f32>().sqrt();
        if is_within < 0.9 * radius {
            ray(origin, std::array::from_fn(|k| f32::from(u8::from(k == axis))));
        }
    }
    (surface, rays)
}

/// The points of a sequence that fills the unit cube evenly.
fn point(i: usize) -> [f32; 3] {
    [0.819_172_513, 0.671_043_607, 0.549_700_478].map(|by: f64| (i as f64 * by).fract() as f32)
}

/// # Safety
/// Never called: peers have their own test.
unsafe extern "C" fn prepare<T: Number>(_: *const c_void, _: *const Ray<T>, _: *mut Prepared<T>) {}

/// # Safety
/// Likewise.
unsafe extern "C" fn intersect<T: Number>(
    _: *const c_void,
    _: *const Prepared<T>,
    _: u32,
    _: T,
    _: *mut T,
) -> c_int {
    0
}
