//! Levels that are kept with the maps: no look-up makes levels again that another made from the same drawing
//! of the maps.
use crate::{
    error::Error,
    gpu::{Allocator, Memory},
    records::{GpuView, LeveledView},
};
use std::sync::{
    Arc, Mutex, PoisonError,
    atomic::{AtomicU64, Ordering::Relaxed},
};
use wgpu::{Texture, TextureFormat::Rgba32Uint, TextureUsages};

/// Most sets that are kept, for a host that binds again and again between frames.
const MOST: usize = 8;
/// Number before any drawing of the maps.
const NEVER: u64 = 0;

/// Inputs of levels besides the contents of the maps.
#[derive(Debug, PartialEq)]
pub(super) struct LevelKey {
    pub leveled: Vec<LeveledView>,
    pub views: Vec<GpuView>,
    pub maps: [Texture; 2],
    pub gain: bool,
}

/// Textures of levels, and the state of their contents.
#[derive(Debug)]
pub(super) struct Levels {
    pub texture: Texture,
    /// A level while it is made.
    pub new: Texture,
    /// Texels of all levels, and of the longest.
    texels: [u64; 2],
    memory: Memory,
    /// Drawing of the maps that the contents were made from.
    made_of: AtomicU64,
}

impl Levels {
    fn new(device: &wgpu::Device, texels: [u64; 2]) -> Result<Self, Error> {
        let mut memory = Memory::default();
        let allocator = &mut Allocator::new(device, &mut memory);
        let read = TextureUsages::COPY_DST | TextureUsages::STORAGE_BINDING;
        let texture = allocator.records("levels", Rgba32Uint, texels[0], read)?;
        let usage = TextureUsages::STORAGE_BINDING | TextureUsages::COPY_SRC;
        let new = allocator.records("new_levels", Rgba32Uint, texels[1], usage)?;
        Ok(Self { texture, new, texels, memory, made_of: AtomicU64::new(NEVER) })
    }

    /// The same textures for other contents.
    fn emptied(&self) -> Self {
        Self {
            texture: self.texture.clone(),
            new: self.new.clone(),
            memory: self.memory.clone(),
            made_of: AtomicU64::new(NEVER),
            ..*self
        }
    }
}

#[derive(Debug)]
struct Kept {
    key: LevelKey,
    levels: Arc<Levels>,
    /// Whether a look-up of the current frame uses them.
    is_taken: bool,
}

/// Levels of the last frames, and the number of the maps' drawing.
#[derive(Debug)]
pub(super) struct LevelStore {
    kept: Mutex<Vec<Kept>>,
    drawing: AtomicU64,
    /// Maps whose levels were made.
    made: AtomicU64,
}

impl Default for LevelStore {
    fn default() -> Self {
        let (drawing, made) = (AtomicU64::new(NEVER + 1), AtomicU64::new(0));
        Self { kept: Mutex::default(), drawing, made }
    }
}

impl LevelStore {
    /// Begins a frame.
    pub(super) fn turn(&self) {
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        kept.retain(|it| it.is_taken);
        kept.iter_mut().for_each(|it| it.is_taken = false);
    }

    /// States that the maps are drawn anew.
    pub(super) fn redraw(&self) {
        self.drawing.fetch_add(1, Relaxed);
    }

    /// Maps whose levels were made.
    pub(super) fn made(&self) -> u64 {
        self.made.load(Relaxed)
    }

    /// Levels of the same key; else those of the last frame with the same sizes, in order; else new ones.
    pub(super) fn take(
        &self,
        key: LevelKey,
        allocator: &mut Allocator<'_>,
        texels: [u64; 2],
    ) -> Result<Arc<Levels>, Error> {
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        let alike = kept.iter().position(|it| it.key == key);
        let unused = kept.iter().position(|it| !it.is_taken && it.levels.texels == texels);
        let levels = if let Some(at) = alike {
            kept[at].is_taken = true;
            Arc::clone(&kept[at].levels)
        } else if let Some(at) = unused {
            let levels = Arc::new(kept[at].levels.emptied());
            kept[at] = Kept { key, levels: Arc::clone(&levels), is_taken: true };
            levels
        } else {
            let levels = Arc::new(Levels::new(allocator.device, texels)?);
            if kept.len() < MOST {
                kept.push(Kept { key, levels: Arc::clone(&levels), is_taken: true });
            }
            levels
        };
        allocator.memory.add_all(&levels.memory);
        Ok(levels)
    }

    /// Whether levels must be made from the maps, which the caller then does; `count`: of maps.
    pub(super) fn must_make(&self, levels: &Levels, count: u64) -> bool {
        let drawing = self.drawing.load(Relaxed);
        let must = levels.made_of.swap(drawing, Relaxed) != drawing;
        self.made.fetch_add(if must { count } else { 0 }, Relaxed);
        must
    }
}
