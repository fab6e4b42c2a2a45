//! The child: loads a plugin, and does what its parent asks over a socket.

use std::io::{self, BufReader};
use std::path::Path;
use std::sync::Arc;

use accel_core::primitives::TriangleSet;

use crate::abi;
use crate::instance::{Instance, PluginScalar, Query, Stats};
use crate::library::Library;
use crate::shared::SharedSegment;
use crate::stopwatch::CallTime;
use crate::wire::{Reply, Request, SegmentContent, SharedParts, receive, send};

/// A structure with the triangles it was built over, which are the child's own copy.
trait Served {
    fn trace(
        &self,
        query: Query,
        count: usize,
        rays: &[u8],
        answers: &mut [u8],
    ) -> Result<CallTime, String>;

    fn stats(&self) -> Stats;

    fn count(&self, on: bool);
}

#[derive(Default)]
struct State {
    parts: SharedParts,
    built: Option<Box<dyn Served + Send + Sync>>,
    pool: Option<rayon::ThreadPool>,
}

/// Serves the plugin in `file` to whoever listens at `socket`, until that one hangs up.
///
/// # Errors
/// Those of the socket.
#[cfg(unix)]
pub fn serve(file: &Path, socket: &Path) -> io::Result<()> {
    let stream = std::os::unix::net::UnixStream::connect(socket)?;
    let mut from = BufReader::new(stream.try_clone()?);
    let mut to = stream;
    let loaded = Library::load(file).map(Arc::new);
    let mut state = State::default();
    while let Some(request) = receive::<Request>(&mut from)? {
        let reply = match &loaded {
            Ok(library) => state.reply(library, request),
            Err(error) => Err(error.to_string()),
        };
        send(&mut to, &reply.unwrap_or_else(|message| Reply::Refused { message }))?;
    }
    Ok(())
}

/// Elsewhere there is no such socket.
///
/// # Errors
/// Always.
#[cfg(not(unix))]
pub fn serve(_: &Path, _: &Path) -> io::Result<()> {
    Err(io::Error::from(io::ErrorKind::Unsupported))
}

impl State {
    fn reply(&mut self, library: &Arc<Library>, request: Request) -> Result<Reply, String> {
        let mut took = CallTime::default();
        match request {
            Request::Describe => {
                return Ok(Reply::Description(Box::new(library.description.clone())));
            }
            Request::Map { part, file } => {
                let mapped = SharedSegment::of(&file, part == SegmentContent::Answers)
                    .map_err(|e| e.to_string())?;
                self.parts[part as usize] = Some(mapped);
            }
            Request::Build { triangles, is_double, values, threads } => {
                self.built = None;
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
                let pool = pool.map_err(|e| e.to_string())?;
                let build = if is_double { Self::build::<f64> } else { Self::build::<f32> };
                took.seconds = build(self, library, triangles, &values, &pool)?;
                self.pool = Some(pool);
            }
            Request::Trace { query, rays } => took = self.trace(query, rays)?,
            Request::Count { on } => self.built()?.count(on),
            Request::Stats => return Ok(Reply::Stats(self.built()?.stats())),
            Request::Nothing => {}
            Request::Destroy => self.built = None,
        }
        Ok(Reply::Done(took))
    }

    fn built(&self) -> Result<&dyn Served, String> {
        Ok(&**self.built.as_ref().ok_or("nothing is built")?)
    }

    /// Builds, and returns the seconds that took.
    fn build<S: PluginScalar>(
        &mut self,
        library: &Arc<Library>,
        triangles: usize,
        values: &[String],
        pool: &rayon::ThreadPool,
    ) -> Result<f64, String> {
        let set = Box::new(self.triangles::<S>(triangles)?);
        let library = Arc::clone(library);
        let (built, seconds) = pool.install(|| Instance::build(library, set, values))?;
        self.built = Some(Box::new(built));
        Ok(seconds)
    }

    fn triangles<S: PluginScalar>(&self, count: usize) -> Result<TriangleSet<S>, String> {
        let [scene, ..] = &self.parts;
        let bytes = scene.as_ref().map(SharedSegment::bytes).unwrap_or_default();
        let positions = size_of::<[[S; 3]; 3]>() * count;
        let (Some(corners), Some(flags)) =
            (bytes.get(..positions), bytes.get(positions..positions + count))
        else {
            return Err(format!("fewer than {count} triangles were sent"));
        };
        let corners: Vec<[[S; 3]; 3]> = bytemuck::cast_slice(corners).to_vec();
        let lets_pass = |id: u32| flags.get(id as usize).is_some_and(|flag| *flag != 0);
        TriangleSet::new(corners, lets_pass).map_err(|e| e.to_string())
    }

    fn trace(&mut self, query: Query, count: usize) -> Result<CallTime, String> {
        let Self { parts: [_, rays, answers], built: Some(built), pool: Some(pool) } = self else {
            return Err("nothing is built".into());
        };
        let rays = rays.as_ref().map(SharedSegment::bytes).unwrap_or_default();
        let answers = answers.as_mut().map(SharedSegment::bytes_mut).unwrap_or_default();
        let mut ask = || built.trace(query, count, rays, answers);
        // one thread alone traces here, as it would in the parent
        if pool.current_num_threads() > 1 { pool.install(ask) } else { ask() }
    }
}

impl<S: PluginScalar> Served for Instance<S, Box<TriangleSet<S>>> {
    fn trace(
        &self,
        query: Query,
        count: usize,
        rays: &[u8],
        answers: &mut [u8],
    ) -> Result<CallTime, String> {
        let rays = rays.get(..size_of::<abi::Ray<S>>() * count);
        let rays = bytemuck::cast_slice(rays.ok_or("fewer rays were sent")?);
        let size = if query == Query::Closest { size_of::<abi::Hit<S>>() } else { 1 };
        let answers = answers.get_mut(..size * count).ok_or("the shared memory is too small")?;
        Ok(match query {
            Query::Closest => self.closest(rays, bytemuck::cast_slice_mut(answers)),
            Query::Occlusion => self.occluded(rays, answers),
        })
    }

    fn stats(&self) -> Stats {
        Instance::stats(self)
    }

    fn count(&self, on: bool) {
        Instance::count(self, on);
    }
}
