//! `gobo man` and `gobo completions`: manual pages and shell completions, generated from the command line's
//! arguments.
use super::{arguments::Arguments, failure::Failure, files, output};
use clap::{Command, CommandFactory as _};
use clap_complete::Shell;
use clap_mangen::Man;
use std::{io::Write as _, path::Path};

/// Section on the exit status, which no argument describes; `roff` is the language of man pages.
const EXIT_STATUS: &str = ".SH \"EXIT STATUS\"
.TP
0
done, whatever was counted, left out or warned of
.TP
1
anything else: a folder that cannot be written, no memory, a device that fails
.TP
2
bad usage or input: a file that is missing, wrong or over a limit
.TP
3
no usable adapter or device, or one whose limits are too small
";

/// Prints the program's page to standard output; with `out`, writes it and a page per command as files.
pub(crate) fn man(out: Option<&Path>) -> Result<(), Failure> {
    let mut whole = Arguments::command().disable_help_subcommand(true);
    whole.build();
    let Some(out) = out else {
        return print(&page(&whole)?);
    };
    files::create_dir(out)?;
    for command in std::iter::once(&whole).chain(whole.get_subcommands()) {
        let name = command.get_display_name().unwrap_or_else(|| command.get_name());
        let path = out.join(format!("{name}.1"));
        output::write(&path, &page(command)?)?;
        files::print(&path.display().to_string())?;
    }
    Ok(())
}

fn page(command: &Command) -> Result<Vec<u8>, Failure> {
    let mut page = Vec::new();
    let source = concat!("gobo ", env!("CARGO_PKG_VERSION"));
    let man = Man::new(command.clone()).source(source).manual("gobo");
    man.render(&mut page).map_err(Failure::Output)?;
    page.extend_from_slice(EXIT_STATUS.as_bytes());
    Ok(page)
}

/// Prints a completion script to standard output.
pub(crate) fn completions(shell: Shell) -> Result<(), Failure> {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Arguments::command(), "gobo", &mut script);
    print(&script)
}

fn print(bytes: &[u8]) -> Result<(), Failure> {
    match std::io::stdout().lock().write_all(bytes) {
        // The reader has closed the pipe.
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => Ok(()),
        result => result.map_err(Failure::Output),
    }
}
