//! Renderers, which calls borrow: one per call at work, and a few idle ones.
use crate::fault::Fault;
use gobo::{Error, host::Backend};
use gobo_picture::Renderer;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Most idle renderers: each keeps a device and its kernels.
const MOST_IDLE: usize = 2;

struct Pool {
    backend: Backend,
    /// Part of the adapter's name.
    name: Option<String>,
    /// Number of the adapter's choice.
    choice: u64,
    idle: Vec<Renderer>,
}

static POOL: Mutex<Pool> =
    Mutex::new(Pool { backend: Backend::Auto, name: None, choice: 0, idle: Vec::new() });

fn pool() -> MutexGuard<'static, Pool> {
    POOL.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The backend with a name.
pub(crate) fn backend(name: &str) -> Result<Backend, Fault> {
    Ok(match name {
        "auto" => Backend::Auto,
        "vulkan" => Backend::Vulkan,
        "metal" => Backend::Metal,
        "dx12" => Backend::Dx12,
        "gl" => Backend::Gl,
        "cpu" => Backend::Cpu,
        _ => {
            let remedy = "use \"auto\", \"vulkan\", \"metal\", \"dx12\", \"gl\" or \"cpu\"";
            return Err(Fault::input(format!("no backend is named {name:?}"), remedy));
        }
    })
}

/// Chooses the adapter of later calls.
pub(crate) fn choose(backend: Backend, name: Option<String>) {
    let mut pool = pool();
    (pool.backend, pool.name) = (backend, name);
    pool.choice += 1;
    let idle = std::mem::take(&mut pool.idle);
    drop(pool);
    drop(idle);
}

/// Closes idle devices.
pub(crate) fn close() {
    let idle = std::mem::take(&mut pool().idle);
    drop(idle);
}

/// Lends a renderer to `work`.
pub(crate) fn with<T>(work: impl FnOnce(&mut Renderer) -> Result<T, Fault>) -> Result<T, Fault> {
    let mut pooled = pool();
    let (choice, backend, name) = (pooled.choice, pooled.backend, pooled.name.clone());
    let idle = pooled.idle.pop();
    drop(pooled);
    let mut renderer = match idle {
        Some(renderer) => renderer,
        None => open(backend, name.as_deref())?,
    };
    let result = work(&mut renderer);
    // An error about a device itself may spoil later calls.
    let is_sound = !matches!(
        result,
        Err(Fault::Library(
            Error::Lost(_) | Error::Memory(_) | Error::Refused(_) | Error::Kernel(_)
        ))
    );
    renderer.forget();
    let mut pooled = pool();
    if is_sound && pooled.choice == choice && pooled.idle.len() < MOST_IDLE {
        pooled.idle.push(renderer);
    }
    drop(pooled);
    result
}

/// The chosen adapter; without a choice, any adapter or else the CPU reference.
fn open(backend: Backend, name: Option<&str>) -> Result<Renderer, Fault> {
    match Renderer::new(backend, name) {
        Err(Error::Adapter { .. } | Error::Unusable(_))
            if backend == Backend::Auto && name.is_none() =>
        {
            Ok(Renderer::on_cpu())
        }
        opened => Ok(opened?),
    }
}
