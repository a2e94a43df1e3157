//! A pack for GPUs takes at most eight minutes, whatever its parts do.
use crate::common::root;

/// Most that a pack may take \[s\].
const MOST: u32 = 480;
/// Time for the shell itself, between the parts \[s\].
const SHELL: u32 = 3;

/// Seconds of all limits of `run.sh`, with those after which `timeout` kills; of the lines of a `for`, once
/// for each word. A program without a limit is an error.
fn seconds(script: &str) -> Result<u32, String> {
    let kill = |line: &str| -> Option<u32> {
        line.split_once("timeout -k ")?.1.split_whitespace().next()?.parse().ok()
    };
    let body = script.lines().find(|line| line.contains("\"$limit\" \"$@\""));
    let to_end = body.and_then(kill).ok_or("parts have no limit")?;
    let (mut all, mut times) = (0, 1);
    for line in script.lines().map(str::trim_start) {
        let words: Vec<_> = line.split_whitespace().collect();
        let limit = |at: usize| -> Result<u32, String> {
            words.get(at).and_then(|word| word.parse().ok()).ok_or_else(|| format!("limit: {line}"))
        };
        match words.first().copied().unwrap_or_default() {
            "for" => times = words.iter().skip_while(|word| **word != "in").count() as u32 - 2,
            "done" => times = 1,
            "part" => all += times * (limit(2)? + to_end),
            "timeout" if Some(line) != body.map(str::trim_start) => {
                all += times * (limit(3)? + kill(line).ok_or_else(|| format!("kill: {line}"))?);
            }
            "gobo" | "gpu-pack" | "gpu-static" | "rival" | "tests" => {
                return Err(format!("without a limit: {line}"));
            }
            _ => {}
        }
    }
    Ok(all)
}

#[test]
fn a_pack_takes_eight_minutes_at_most() {
    let script = std::fs::read_to_string(root().join("tools/gpu_pack/run.sh")).unwrap();
    let all = seconds(&script).unwrap();
    // Sixteen programs have limits, one of them for four scenes.
    assert!((MOST - 60..=MOST - SHELL).contains(&all), "{all} s");
    assert_eq!(seconds(&script.replace("part suite 66", "part suite 90")), Ok(all + 24));
    assert_eq!(seconds(&script.replace("\"$short\" 12", "\"$short\" 13")), Ok(all + 4));
    assert!(seconds(&script.replace("timeout -k 2 10 gpu-pack", "gpu-pack")).is_err());
    assert!(seconds(&script.replace("part maps 10 gpu-pack", "gpu-pack")).is_err());
}
