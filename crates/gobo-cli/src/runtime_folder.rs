//! `XDG_RUNTIME_DIR`: Mesa's drivers complain without it.

/// Restarts the program with a socket folder that does not exist, if the environment names none: the Mesa
/// layer that sorts Vulkan's devices asks libwayland for a display at each start, which prints an error
/// without the variable. A process cannot safely change its own environment.
#[cfg(target_os = "linux")]
pub(crate) fn name_a_runtime_folder() {
    use std::{env, os::unix::process::CommandExt as _, path::Path, process::Command};
    const VARIABLE: &str = "XDG_RUNTIME_DIR";
    let is_named = env::var_os(VARIABLE).is_some_and(|folder| Path::new(&folder).is_absolute());
    let mut arguments = env::args_os();
    if let (false, Some(name), Ok(program)) = (is_named, arguments.next(), env::current_exe()) {
        let mut again = Command::new(program);
        again.arg0(name).args(arguments).env(VARIABLE, "/nonexistent");
        // Returns only if that fails: the messages are a nuisance, not a fault.
        let _ = again.exec();
    }
}

#[cfg(not(target_os = "linux"))]
pub(crate) fn name_a_runtime_folder() {}
