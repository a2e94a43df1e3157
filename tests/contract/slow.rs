//! `tests/slow.txt`: tests that `make test` leaves to `make test-slow`.
use std::{env, fs, path::Path, process::Command};

#[test]
fn each_name_is_that_of_a_test() {
    let path = Path::new(crate::common::ROOT).join("tests/slow.txt");
    let names = fs::read_to_string(path).unwrap();
    assert!(names.lines().is_sorted_by(|a, b| a < b), "sorted, and each name once");
    let list = |arguments: &[&str]| {
        let tests = Command::new(env::current_exe().unwrap()).args(arguments).output().unwrap();
        String::from_utf8(tests.stdout).unwrap()
    };
    let (tests, ignored) = (list(&["--list"]), list(&["--list", "--ignored"]));
    for name in names.lines() {
        let is_in = |list: &str| list.lines().any(|line| line.strip_suffix(": test") == Some(name));
        assert!(is_in(&tests) && !is_in(&ignored), "no test of `make test`: {name}");
    }
}
