//! `XDG_RUNTIME_DIR`, without which Mesa's drivers complain.

/// Starts the program anew with a folder for sockets that is not there, where the environment names none: the
/// layer of Mesa that sorts Vulkan's devices asks libwayland for a display at each start, and that prints an
/// error without the variable. A process cannot safely change its own environment.
#[cfg(target_os = "linux")]
pub(crate) fn name_a_runtime_folder() {
    use std::{env, os::unix::process::CommandExt as _, path::Path, process::Command};
    const VARIABLE: &str = "XDG_RUNTIME_DIR";
    let is_named = env::var_os(VARIABLE).is_some_and(|folder| Path::new(&folder).is_absolute());
    let mut arguments = env::args_os();
    if let (false, Some(name), Ok(program)) = (is_named, arguments.next(), env::current_exe()) {
        let mut again = Command::new(program);
        again.arg0(name).args(arguments).env(VARIABLE, "/nonexistent");
        // Returns where that fails: the lines are a nuisance, no fault.
        let _ = again.exec();
    }
}

#[cfg(not(target_os = "linux"))]
pub(crate) fn name_a_runtime_folder() {}
