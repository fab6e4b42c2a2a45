//! The device: one for the process, with its pipelines and the buffers of a batch.

use std::collections::HashMap;
use std::num::NonZero;
use std::sync::{Mutex, OnceLock, PoisonError};

use wgpu::util::{BufferInitDescriptor, DeviceExt, initialize_adapter_from_env_or_default};
use wgpu::*;

/// Rays of a workgroup, as `ray.wgsl` says.
const WORKGROUP: usize = 64;
/// Bytes of the two timestamps of a submission.
const TIMESTAMPS: u64 = 16;

/// A device that computes.
pub(crate) struct Gpu {
    device: Device,
    queue: Queue,
    /// The adapter and how it is reached.
    pub(crate) name: String,
    /// Two queries, and where their results can be copied from; none if it has no timestamps.
    timestamps: Option<(QuerySet, Buffer)>,
    /// By their source.
    pipelines: Mutex<HashMap<String, ComputePipeline>>,
    /// Rays, answers, and answers with timestamps that can be read; none before the first batch.
    buffers: Mutex<Option<[Buffer; 3]>>,
}

impl Gpu {
    /// The device of this process, opened when it is first asked for.
    ///
    /// # Errors
    /// That there is no adapter, or no device of it.
    pub(crate) fn get() -> Result<&'static Self, String> {
        static GPU: OnceLock<Result<Gpu, String>> = OnceLock::new();
        GPU.get_or_init(|| pollster::block_on(Self::open())).as_ref().map_err(Clone::clone)
    }

    async fn open() -> Result<Self, String> {
        let instance = Instance::new(InstanceDescriptor::new_without_display_handle());
        let adapter = initialize_adapter_from_env_or_default(&instance, None).await;
        let adapter = adapter.map_err(
            |_| "there is no GPU that wgpu can use: no driver of Vulkan, Metal or Direct3D 12",
        )?;
        let info = adapter.get_info();
        let required_features = adapter.features() & Features::TIMESTAMP_QUERY;
        let required_limits = adapter.limits();
        let request =
            DeviceDescriptor { required_features, required_limits, ..DeviceDescriptor::default() };
        let (device, queue) = adapter
            .request_device(&request)
            .await
            .map_err(|error| format!("the GPU {} cannot be used: {error}", info.name))?;
        let timestamps = (!required_features.is_empty()).then(|| {
            let (label, ty, count) = (None, QueryType::Timestamp, 2);
            let queries = device.create_query_set(&QuerySetDescriptor { label, ty, count });
            let usage = BufferUsages::QUERY_RESOLVE | BufferUsages::COPY_SRC;
            (queries, buffer(&device, TIMESTAMPS, usage))
        });
        Ok(Self {
            device,
            queue,
            name: format!("{}, {:?}", info.name, info.backend),
            timestamps,
            pipelines: Mutex::default(),
            buffers: Mutex::default(),
        })
    }

    /// Compiles a shader, if it has not been compiled before.
    pub(crate) fn pipeline(&self, source: String) -> ComputePipeline {
        let compile = |source: &String| {
            let source = ShaderSource::Wgsl(source.into());
            let shader = ShaderModuleDescriptor { label: None, source };
            // SAFETY: indices are those of a tree of obvhs, the stack has room for its depth, and
            // loops end with it
            let module = unsafe {
                self.device.create_shader_module_trusted(shader, ShaderRuntimeChecks::unchecked())
            };
            self.device.create_compute_pipeline(&ComputePipelineDescriptor {
                label: None,
                layout: None,
                module: &module,
                entry_point: None,
                compilation_options: PipelineCompilationOptions::default(),
                cache: None,
            })
        };
        let mut pipelines = self.pipelines.lock().unwrap_or_else(PoisonError::into_inner);
        pipelines.entry(source).or_insert_with_key(compile).clone()
    }

    /// Buffers with that content, which have arrived on the device.
    ///
    /// # Errors
    /// That one is larger than the device allows.
    pub(crate) fn upload(&self, contents: [&[u32]; 2]) -> Result<[Buffer; 2], String> {
        let limits = self.device.limits();
        let most = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        let largest = 4 * contents.map(<[u32]>::len).into_iter().max().unwrap_or(0) as u64;
        if largest > most {
            return Err(format!("a buffer of {largest} bytes: {} has at most {most}", self.name));
        }
        let usage = BufferUsages::STORAGE;
        let buffers = contents.map(|words| {
            let contents = bytemuck::cast_slice(words);
            self.device.create_buffer_init(&BufferInitDescriptor { label: None, contents, usage })
        });
        self.queue.submit([]);
        self.wait();
        Ok(buffers)
    }

    /// Answers at least one ray, of 32 bytes each, and gives the answers to `read`; each has
    /// `words` words. Returns the seconds of the kernel, where the device has timestamps.
    pub(crate) fn answer(
        &self,
        pipeline: &ComputePipeline,
        [triangles, nodes]: [&Buffer; 2],
        rays: &[[u32; 8]],
        words: usize,
        read: impl FnOnce(&[u32]),
    ) -> Option<f64> {
        let mut buffers = self.buffers.lock().unwrap_or_else(PoisonError::into_inner);
        let [asked, answers, readable] = match &mut *buffers {
            Some(buffers) if buffers[0].size() >= size_of_val(rays) as u64 => buffers,
            buffers => {
                let room = rays.len().next_power_of_two() as u64;
                let by_shader = BufferUsages::STORAGE;
                let readable = BufferUsages::MAP_READ | BufferUsages::COPY_DST;
                buffers.insert([
                    buffer(&self.device, 32 * room, by_shader | BufferUsages::COPY_DST),
                    buffer(&self.device, 8 * room, by_shader | BufferUsages::COPY_SRC),
                    buffer(&self.device, 8 * room + TIMESTAMPS, readable),
                ])
            }
        };
        self.queue.write_buffer(asked, 0, bytemuck::cast_slice(rays));
        let size = NonZero::new(size_of_val(rays) as u64);
        let asked = BindingResource::Buffer(BufferBinding { buffer: asked, offset: 0, size });
        let bound = [triangles, nodes, answers].map(Buffer::as_entire_binding);
        let bound = std::iter::once(asked).chain(bound);
        let entry = |(binding, resource)| BindGroupEntry { binding, resource };
        let group = self.device.create_bind_group(&BindGroupDescriptor {
            label: None,
            layout: &pipeline.get_bind_group_layout(0),
            entries: &(0..).zip(bound).map(entry).collect::<Vec<_>>(),
        });
        let mut commands = self.device.create_command_encoder(&CommandEncoderDescriptor::default());
        let times = self.timestamps.as_ref().map(|(query_set, _)| ComputePassTimestampWrites {
            query_set,
            beginning_of_pass_write_index: Some(0),
            end_of_pass_write_index: Some(1),
        });
        let pass = ComputePassDescriptor { label: None, timestamp_writes: times };
        let mut pass = commands.begin_compute_pass(&pass);
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups(rays.len().div_ceil(WORKGROUP) as u32, 1, 1);
        drop(pass);
        if let Some((queries, resolved)) = &self.timestamps {
            commands.resolve_query_set(queries, 0..2, resolved, 0);
            commands.copy_buffer_to_buffer(resolved, 0, readable, 0, TIMESTAMPS);
        }
        let bytes = 4 * (rays.len() * words) as u64;
        commands.copy_buffer_to_buffer(answers, 0, readable, TIMESTAMPS, bytes);
        self.queue.submit([commands.finish()]);
        let mapped = readable.slice(..TIMESTAMPS + bytes);
        mapped.map_async(MapMode::Read, |mapped| mapped.expect("answers can be read"));
        self.wait();
        let view = mapped.get_mapped_range().expect("answers have been mapped");
        let (times, answers) = view.split_at(TIMESTAMPS as usize);
        let times: &[u64] = bytemuck::cast_slice(times);
        let ticks = times[1].saturating_sub(times[0]) as f64;
        read(bytemuck::cast_slice(answers));
        drop(view);
        readable.unmap();
        let period = f64::from(self.queue.get_timestamp_period());
        self.timestamps.is_some().then_some(ticks * period * 1e-9)
    }

    fn wait(&self) {
        self.device.poll(PollType::wait_indefinitely()).expect("the device goes on working");
    }
}

fn buffer(device: &Device, size: u64, usage: BufferUsages) -> Buffer {
    device.create_buffer(&BufferDescriptor { label: None, size, usage, mapped_at_creation: false })
}
