//! Manual pages and completions contain every command and option of the program.
use super::commands::{Folder, files};
use std::fs;

/// Names of the commands, from the program's own help.
fn commands(folder: &Folder) -> Vec<String> {
    let help = folder.run(&["--help"]);
    let listed = help.split_once("Commands:\n").unwrap().1.split_once("\n\n").unwrap().0;
    let names = listed.lines().filter_map(|line| line.split_whitespace().next());
    names.filter(|&name| name != "help").map(str::to_owned).collect()
}

/// Long options that a command's help shows.
fn options(folder: &Folder, command: &str) -> Vec<String> {
    let help = folder.run(&[command, "--help"]);
    let lines = help.lines().map(str::trim_start).filter(|line| line.starts_with('-'));
    let words = lines.flat_map(str::split_whitespace).filter(|word| word.starts_with("--"));
    words.map(|word| word.trim_end_matches(['.', ',']).to_owned()).collect()
}

/// Commands and options missing on a page. Pages escape what roff reads as a hyphenation.
fn missing(page: &str, words: &[String]) -> Vec<String> {
    let plain = page.replace('\\', "");
    words.iter().filter(|word| !plain.contains(word.as_str())).cloned().collect()
}

#[test]
fn every_command_has_a_page_with_its_options() {
    let folder = Folder::new("manual");
    let names = commands(&folder);
    assert!(names.len() >= 9 && names.contains(&"verify".to_owned()), "{names:?}");
    let listed: Vec<String> = names.iter().map(|name| format!("gobo-{name}(1)")).collect();
    let whole = folder.run(&["man"]);
    assert!(whole.contains(".SH \"EXIT STATUS\""), "{whole}");
    assert_eq!(missing(&whole, &listed), [""; 0]);

    let written = folder.run(&["man", "-o", "pages"]);
    let pages = folder.0.join("pages");
    assert_eq!(written.lines().count(), names.len() + 1);
    assert_eq!(files(&pages).len(), names.len() + 1);
    assert_eq!(fs::read_to_string(pages.join("gobo.1")).unwrap(), whole);
    let mut count = 0;
    for name in &names {
        let page = fs::read_to_string(pages.join(format!("gobo-{name}.1"))).unwrap();
        let options = options(&folder, name);
        count += options.len();
        assert_eq!(missing(&page, &options), [""; 0], "{name}");
    }
    assert!(count > 40, "{count} options");
    // A missing command is noticed.
    assert_eq!(missing(&whole, &["gobo-dance(1)".to_owned()]).len(), 1);
}

#[test]
fn shells_complete_every_command() {
    let folder = Folder::new("completions");
    let names = commands(&folder);
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let script = folder.run(&["completions", shell]);
        assert_eq!(missing(&script, &names), [""; 0], "{shell}");
        for option in ["skip-existing", "backend"] {
            assert!(script.contains(option), "{shell}: --{option}");
        }
    }
    let error = folder.fail(&["completions", "abacus"], 2);
    assert!(error.contains("powershell"), "{error}");
}
