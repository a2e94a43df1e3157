//! What kernels need on GPUs that are not here: registers, spills, workgroup memory, waves, code, instructions of a
//! visit, and the bytes that a lane moves. Compiles what `gobo export --target spirv` wrote with RADV's null hardware,
//! prints a table and fails where a kernel exceeds `limits.toml`.
//!
//! `gpu-static DIR [--all | --here]`, or `make gpu-static` in the repository. `--all`: also kernels that few scenes use on
//! GPUs. `--here`: compiles with this machine's own driver, and prints what that says of each kernel.
mod compiler;
mod limits;
mod manifest;
mod traffic;

use compiler::{Compiler, Driver, Needs, Said};
use limits::Limits;
use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
    process::{Child, Command, ExitCode, Stdio},
    sync::atomic::{AtomicUsize, Ordering},
};
use traffic::Traffic;

pub type Failure = Box<dyn std::error::Error>;

/// Set in the processes that compile: RADV reads the GPU's name once.
const GPU: &str = "RADV_FORCE_FAMILY";

fn main() -> ExitCode {
    match run() {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("gpu-static: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> Result<bool, Failure> {
    let (mut dir, mut all, mut here) = (None, false, false);
    for argument in std::env::args().skip(1) {
        match argument.as_str() {
            "--all" => all = true,
            "--here" => here = true,
            _ => dir = Some(PathBuf::from(argument)),
        }
    }
    let dir = dir.ok_or("which folder? gpu-static DIR [--all | --here]")?;
    let limits = Limits::read()?;
    if here {
        return print_statistics(&dir, &limits, all).map(|()| true);
    }
    if std::env::var_os(GPU).is_some() {
        compile(&dir, &limits, all)?;
        return Ok(true);
    }
    // A process and a core for each.
    let children = limits.gpus.keys().map(|gpu| Ok((gpu, start(gpu)?)));
    let children = children.collect::<Result<Vec<_>, Failure>>()?;
    let mut good = true;
    for (gpu, child) in children {
        let needs = finish(gpu, child)?;
        print_table(gpu, &needs);
        for (kernel, needs) in &needs {
            for complaint in limits.complaints(gpu, kernel, needs) {
                good = false;
                println!("{complaint}");
            }
        }
        let kernels: Vec<&str> = needs.keys().map(String::as_str).collect();
        if let Some(name) = limits.unused(gpu, &kernels) {
            return Err(format!("limits.toml: no kernel of {gpu} begins with {name}").into());
        }
        let (kernel, first) = needs.first_key_value().ok_or_else(|| format!("{gpu}: no kernel"))?;
        sees_a_limit(&limits, gpu, kernel, first)?;
        println!();
    }
    println!(
        "gpu-static: {}",
        if good { "all kernels are within limits" } else { "limits are exceeded" }
    );
    Ok(good)
}

/// Fails if a limit one below a kernel's need were not noticed.
fn sees_a_limit(limits: &Limits, gpu: &str, kernel: &str, needs: &Needs) -> Result<(), Failure> {
    let mut wrong = limits.clone();
    let limit = wrong.gpus.get_mut(gpu).ok_or("no limits")?;
    limit.vgprs = Some(needs.vgprs - 1);
    wrong.smaller.clear();
    let said = wrong.complaints(gpu, kernel, needs);
    let is_seen = said.iter().any(|it| it.contains("vgprs"));
    is_seen.then_some(()).ok_or_else(|| "a wrong limit was not noticed".into())
}

/// Compiles all kernels in this process: a line for each.
fn compile(dir: &Path, limits: &Limits, all: bool) -> Result<(), Failure> {
    let cases = manifest::cases(dir, limits, all)?;
    let compiler = Compiler::new(Driver::Radv)?.ok_or("RADV does not say what kernels need")?;
    eprintln!("gpu-static: {} kernels on {}", cases.len(), compiler.name);
    for case in cases {
        let needs =
            compiler.compile(dir, &case).map_err(|error| format!("{}: {error}", case.id))?;
        println!("{}", serde_json::to_string(&(case.id, needs))?);
    }
    Ok(())
}

/// Compiles all kernels with this machine's driver: a line for each.
fn print_statistics(dir: &Path, limits: &Limits, all: bool) -> Result<(), Failure> {
    let cases = manifest::cases(dir, limits, all)?;
    let Some(compiler) = Compiler::new(Driver::Here)? else {
        println!("no driver of this machine says what kernels need");
        return Ok(());
    };
    println!("{} kernels on {}", cases.len(), compiler.name);
    let next = AtomicUsize::new(0);
    // Drivers compile on the caller's thread, and a pack has little time.
    let work = || -> Result<(), String> {
        while let Some(case) = cases.get(next.fetch_add(1, Ordering::Relaxed)) {
            let Said { statistics, seconds, .. } =
                compiler.compiled(dir, case).map_err(|error| format!("{}: {error}", case.id))?;
            let said: Vec<_> =
                statistics.iter().map(|(name, value)| format!("{name} {value}")).collect();
            println!("{}: {}, {seconds:.2} s", case.id, said.join(", "));
        }
        Ok(())
    };
    let cores = std::thread::available_parallelism()?.get();
    std::thread::scope(|scope| {
        let all: Vec<_> = (0..cores).map(|_| scope.spawn(work)).collect();
        all.into_iter().try_for_each(|one| match one.join() {
            Ok(done) => done,
            Err(_) => Err("a thread that compiles panicked".to_owned()),
        })
    })?;
    Ok(())
}

/// Starts a process that compiles for a GPU.
fn start(gpu: &str) -> Result<Child, Failure> {
    let drivers = std::fs::read_dir("/usr/share/vulkan/icd.d").into_iter().flatten().flatten();
    let is_radv = |path: &PathBuf| path.to_string_lossy().contains("radeon_icd");
    let driver = drivers.map(|file| file.path()).find(is_radv);
    let driver = driver.ok_or("RADV is missing: on Debian, mesa-vulkan-drivers has it")?;
    let child = Command::new(std::env::current_exe()?)
        .args(std::env::args_os().skip(1))
        .env(GPU, gpu)
        .env("VK_ICD_FILENAMES", &driver)
        .env("VK_DRIVER_FILES", &driver)
        .env("MESA_SHADER_CACHE_DISABLE", "true")
        .stdout(Stdio::piped())
        .spawn()?;
    Ok(child)
}

fn finish(gpu: &str, child: Child) -> Result<BTreeMap<String, Needs>, Failure> {
    let output = child.wait_with_output()?;
    let lines = String::from_utf8(output.stdout)?;
    let needs: BTreeMap<String, Needs> =
        lines.lines().map(serde_json::from_str::<(String, Needs)>).collect::<Result<_, _>>()?;
    if !output.status.success() {
        let last = needs.len();
        return Err(format!("{gpu}: {} after {last} kernels", output.status).into());
    }
    Ok(needs)
}

fn print_table(gpu: &str, needs: &BTreeMap<String, Needs>) {
    let names = [
        "VGPRs", "spilled", "LDS", "waves", "instr.", "visit", "bytes", "read", "buffers",
        "textures", "s",
    ];
    println!("{gpu:44}{}", names.map(|name| format!("{name:>9}")).concat());
    for (kernel, it) in needs {
        let Traffic { read, to_buffers, to_textures } = it.traffic;
        let visit = it.visit.map_or_else(|| "-".to_owned(), |visit| visit.to_string());
        let before = [it.vgprs, it.spilled, it.lds, it.waves, it.instructions];
        let since = [it.code, read, to_buffers, to_textures];
        let [before, since] = [&before[..], &since].map(|cells| cells.iter().map(u64::to_string));
        let cells: String =
            before.chain([visit]).chain(since).map(|cell| format!("{cell:>9}")).collect();
        println!("{kernel:44}{cells}{:>9.2}", it.seconds);
    }
}
