//! Trees of obvhs, traversed on a GPU by `wgpu`, as a plugin of rtbench: built on the CPU, uploaded
//! within the build, and asked by batches.

mod gpu;
mod tree;

use std::mem::MaybeUninit;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use gpu::Gpu;
use peer::abi::MISS;
use peer::{Description, Hit, Kind, Peer, Ray, Scene, Setting, Shadows, Stats};
use tree::Tree;
use wgpu::{Buffer, ComputePipeline};

/// The environment variable by which tests plant a mistake in the shader; see `ray.wgsl`.
const FAULT: &str = "RTBENCH_WGPU_FAULT";
/// Widening of boxes, in parts of their distance: 64 roundings.
const PADDING: f32 = 1.0 / 262_144.0;
/// Most rays of one submission.
const MOST_RAYS: usize = 1 << 20;

/// A tree on the device.
struct OnGpu {
    gpu: &'static Gpu,
    triangles: Buffer,
    nodes: Buffer,
    closest: ComputePipeline,
    any_hit: ComputePipeline,
    /// Without its words.
    tree: Tree,
    times: Mutex<Times>,
}

/// What submissions took; the first one, in which drivers get ready, does not count.
#[derive(Debug, Default)]
struct Times {
    is_warm: bool,
    rays: f64,
    seconds: f64,
    in_kernels: Option<f64>,
}

const fn choice(
    name: &'static str,
    summary: &'static str,
    initial: &'static str,
    words: &'static str,
) -> Setting {
    Setting { name, summary, initial, kind: Kind::Choice(words) }
}

impl Peer for OnGpu {
    const DESCRIPTION: Description = Description {
        name: "wgpu",
        library: "wgpu",
        summary: "trees of obvhs on a GPU, by compute shaders of wgpu",
        settings: &[
            choice("layout", "CwBvh, or the binary Bvh2", "cwbvh", "bvh2 cwbvh"),
            choice("test", "Woop's, or another", "watertight", "watertight moeller-trumbore"),
            choice("boxes", "widened for rounding, or as they are", "padded", "padded plain"),
        ],
    };
    const SHADOWS: Shadows = Shadows::Filtered;
    const ANSWERS_BATCHES: bool = true;
    const ON_DEVICE: bool = true;
    const LOCK: &'static str = include_str!("../Cargo.lock");
    const USES_RAYON: bool = true;

    fn build(scene: &Scene<'_>) -> Result<Self, String> {
        let gpu = Gpu::get()?;
        let is_set = |name, value| scene.settings.text(name) == value;
        let is_wide = is_set("layout", "cwbvh");
        let mut tree = Tree::build(scene, is_wide)?;
        let (common, wide) = (include_str!("ray.wgsl"), include_str!("cwbvh.wgsl"));
        let shader = if is_wide { wide } else { include_str!("bvh2.wgsl") };
        let watertight = is_set("test", "watertight");
        let padding = if is_set("boxes", "padded") { PADDING } else { 0.0 };
        // in steps, so that most trees have the same shader
        let stack = (tree.levels + 1).next_multiple_of(32);
        let fault = std::env::var(FAULT).ok().and_then(|fault| fault.parse().ok());
        let fault: u32 = fault.unwrap_or(0);
        let pipeline = |any_hit: bool| {
            gpu.pipeline(format!(
                "const ANY_HIT = {any_hit}; const WATERTIGHT = {watertight}; \
                 const PADDING = f32({padding:?}); const STACK = {stack}; \
                 const FAULT = {fault};\n{common}{shader}"
            ))
        };
        let (closest, any_hit) = (pipeline(false), pipeline(true));
        let [triangles, nodes] = gpu.upload([&tree.triangles, &tree.nodes])?;
        (tree.triangles, tree.nodes) = Default::default();
        Ok(Self { gpu, triangles, nodes, closest, any_hit, tree, times: Mutex::default() })
    }

    fn closest(&self, ray: &Ray) -> Option<Hit> {
        let mut hit = [MaybeUninit::new(Hit::new(ray.t_max, MISS))];
        self.closest_all(std::slice::from_ref(ray), &mut hit);
        // SAFETY: it was written above
        Some(unsafe { hit[0].assume_init() }).filter(|hit| hit.id != MISS)
    }

    fn closest_all(&self, rays: &[Ray], hits: &mut [MaybeUninit<Hit>]) {
        let mut hits = hits.iter_mut();
        self.answer(&self.closest, rays, 2, |answers| {
            for (answer, hit) in answers.chunks_exact(2).zip(hits.by_ref()) {
                hit.write(Hit::new(f32::from_bits(answer[0]), answer[1]));
            }
        });
    }

    fn occluded_all(&self, rays: &[Ray], blocked: &mut [MaybeUninit<u8>]) {
        let mut blocked = blocked.iter_mut();
        self.answer(&self.any_hit, rays, 1, |answers| {
            for (answer, blocked) in answers.iter().zip(blocked.by_ref()) {
                blocked.write(*answer as u8);
            }
        });
    }

    fn stats(&self, stats: &mut Stats) {
        stats.bytes = self.triangles.size() + self.nodes.size();
        stats.inner_nodes += self.tree.inner_nodes;
        stats.leaves += self.tree.leaves;
        stats.references += self.triangles.size() / 48;
        let note = self.note();
        let length = note.len().min(stats.note.len() - 1);
        stats.note[..length].copy_from_slice(&note.as_bytes()[..length]);
    }
}

impl OnGpu {
    fn answer(
        &self,
        pipeline: &ComputePipeline,
        rays: &[Ray],
        words: usize,
        mut read: impl FnMut(&[u32]),
    ) {
        let buffers = [&self.triangles, &self.nodes];
        for rays in rays.chunks(MOST_RAYS) {
            let (start, asked) = (Instant::now(), bytemuck::cast_slice(rays));
            let kernel = self.gpu.answer(pipeline, buffers, asked, words, &mut read);
            let seconds = start.elapsed().as_secs_f64();
            let mut times = self.times.lock().unwrap_or_else(PoisonError::into_inner);
            if times.is_warm {
                times.rays += rays.len() as f64;
                times.seconds += seconds;
                times.in_kernels = kernel.map(|s| s + times.in_kernels.unwrap_or(0.0));
            }
            times.is_warm = true;
        }
    }

    /// The adapter, and the time of batches with and without the way to it and back.
    fn note(&self) -> String {
        let times = self.times.lock().unwrap_or_else(PoisonError::into_inner);
        let name = &self.gpu.name;
        let [whole, in_kernels] =
            [times.seconds, times.in_kernels.unwrap_or(0.0)].map(|s| 1e9 * s / times.rays);
        let way = format!("{name}; {whole:.2} ns a ray with the way there and back");
        match times.in_kernels {
            _ if times.rays == 0.0 => name.clone(),
            Some(_) => format!("{way}, {in_kernels:.2} in kernels by its timestamps"),
            None => format!("{way}; it has no timestamps"),
        }
    }
}

peer::export!(OnGpu);

#[cfg(test)]
mod tests;
