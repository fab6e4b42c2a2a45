//! A plugin's shared library, loaded into this process, and why a plugin cannot be used.

use std::io;
use std::path::{Path, PathBuf};

use crate::abi;
use crate::description::Description;

/// Why a plugin cannot be used at all; what goes wrong with a row of it is that row's.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PluginError {
    /// It cannot be loaded, says something of itself that is not valid, or its process ends before
    /// it says anything.
    #[error("{}: {what}", file.display())]
    Invalid { file: PathBuf, what: String },
    /// There are no processes of plugins on this system.
    #[error(
        "{}: plugins run in separate processes on Unix only; add --in-process", file.display()
    )]
    NoProcesses { file: PathBuf },
    /// Error reported by its process, starting with the file's name.
    #[error("{0}")]
    Child(String),
    /// There is another row of that name.
    #[error("{}: another structure is named '{name}'; rename the plugin", file.display())]
    NameTaken { file: PathBuf, name: String },
    /// The file cannot be read.
    #[error("{}: {source}", file.display())]
    Read { file: PathBuf, source: io::Error },
}

/// A loaded plugin. Whatever it does wrong, it does to this process.
pub struct Library {
    pub description: Description,
    pub(crate) plugin: abi::Plugin,
}

// SAFETY: the functions of a plugin may be called by any thread (rtbench.h), the rest is read only
unsafe impl Send for Library {}
// SAFETY: likewise
unsafe impl Sync for Library {}

const NO_SYMBOL: &str =
    "has no function rtbench_plugin_describe; export it with extern \"C\" (see rtbench.h)";

impl Library {
    /// Loads a plugin; it stays loaded as long as this process lives.
    ///
    /// # Errors
    /// [`PluginError`] for a file that is none, or of another version.
    pub fn load(file: &Path) -> Result<Self, PluginError> {
        let file = &std::path::absolute(file)
            .map_err(|source| PluginError::Read { file: file.into(), source })?;
        let wrong = |what: String| PluginError::Invalid { file: file.clone(), what };
        // SAFETY: that its initialisers run is what the user asks for
        let library = unsafe { libloading::Library::new(file) }.map_err(|e| {
            let source = std::error::Error::source(&e);
            let why = source.map_or_else(|| e.to_string(), ToString::to_string);
            wrong(format!("cannot be loaded: {why}"))
        })?;
        // what a plugin has started may go on: it is never unloaded
        let library: &'static libloading::Library = Box::leak(Box::new(library));
        // SAFETY: the symbol has that type, by rtbench.h
        let describe = unsafe { library.get::<abi::Describe>(abi::SYMBOL) }
            .map_err(|_| wrong(NO_SYMBOL.into()))?;
        // SAFETY: by rtbench.h
        let plugin = unsafe { describe() };
        if plugin.is_null() {
            return Err(wrong("rtbench_plugin_describe returns NULL".into()));
        }
        // SAFETY: whatever its version, a plugin begins with that number and its size
        let [version, size] = unsafe { plugin.cast::<[u32; 2]>().read_unaligned() };
        if version != abi::VERSION {
            return Err(wrong(format!(
                "built for version {version} of rtbench.h, but this program has version {}; compile \
                 it with this program's header",
                abi::VERSION
            )));
        }
        let least = std::mem::offset_of!(abi::Plugin, in_f64);
        if (size as usize) < least || !plugin.is_aligned() {
            return Err(wrong(format!("its rtbench_plugin has {size} bytes, not {least}")));
        }
        // SAFETY: it is one of our version, as long as we read it
        let plugin = unsafe { copy_plugin(plugin, size as usize) };
        // SAFETY: likewise
        let description = unsafe { Description::read(&plugin) }.map_err(wrong)?;
        Ok(Self { description, plugin })
    }
}

/// A copy of what a plugin describes; where that is from before f64, without its functions.
///
/// # Safety
/// `plugin` is aligned and has `size` bytes, at least those before `in_f64`.
unsafe fn copy_plugin(plugin: *const abi::Plugin, size: usize) -> abi::Plugin {
    if size >= size_of::<abi::Plugin>() {
        // SAFETY: by the contract
        return unsafe { *plugin };
    }
    let mut whole = std::mem::MaybeUninit::<abi::Plugin>::uninit();
    // SAFETY: both have the bytes before `in_f64`, by the contract; then nothing is uninitialised
    unsafe {
        let before = std::mem::offset_of!(abi::Plugin, in_f64);
        std::ptr::copy_nonoverlapping(plugin.cast::<u8>(), whole.as_mut_ptr().cast(), before);
        (&raw mut (*whole.as_mut_ptr()).in_f64).write(abi::Functions::NONE);
        whole.assume_init()
    }
}
