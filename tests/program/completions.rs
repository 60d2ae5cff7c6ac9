//! Shells' completions and manual pages, which are made from the definition of the command line.

use crate::cli::Folder;
use crate::common::program::fstop;
use std::process::{Command, Stdio};

/// Commands that every script and the first page name.
const COMMANDS: [&str; 9] = [
    "render",
    "check",
    "lens",
    "compare",
    "merge",
    "tradeoff",
    "farm",
    "completions",
    "man",
];

#[test]
fn completions_name_every_command_and_its_options() {
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let run = fstop(["completions", shell]);
        assert_eq!((run.code, run.stderr.as_str()), (0, ""), "{shell}");
        for word in COMMANDS
            .into_iter()
            .chain(["checkpoint-every", "keep-going"])
        {
            assert!(run.stdout.contains(word), "{shell}: no {word}");
        }
    }
    let wrong = fstop(["completions", "tcsh"]);
    assert_eq!((wrong.code, wrong.stdout.as_str()), (2, ""));
}

/// Bash reads the script, and completes by it.
#[test]
#[allow(clippy::print_stdout, reason = "a test that is skipped says so")]
fn bash_completes_commands_and_options() {
    if Command::new("bash")
        .arg("--version")
        .stdout(Stdio::null())
        .status()
        .is_err()
    {
        println!("skipped: there is no bash");
        return;
    }
    let script = fstop(["completions", "bash"]).stdout;
    let complete = |words: &[&str]| {
        let asked = format!(
            "{script}\nCOMP_WORDS=({}); COMP_CWORD={}; _fstop fstop {} {}; printf '%s\\n' \"${{COMPREPLY[@]}}\"",
            words.join(" "),
            words.len() - 1,
            words[words.len() - 1],
            words[words.len() - 2],
        );
        let run = Command::new("bash")
            .args(["--norc", "-c", &asked])
            .output()
            .expect("bash runs");
        String::from_utf8(run.stdout).expect("text")
    };
    assert_eq!(complete(&["fstop", "trade"]), "tradeoff\n");
    let options = complete(&["fstop", "render", "--check"]);
    assert_eq!(options, "--checkpoint\n--checkpoint-every\n");
}

#[test]
fn each_command_has_a_manual_page() {
    let folder = Folder::new();
    let man = folder.path("share/man1");
    let run = fstop(["man".as_ref(), man.as_os_str()]);
    assert_eq!(
        (run.code, run.stdout.as_str(), run.stderr.as_str()),
        (0, "", "")
    );
    let page = |name: String| std::fs::read_to_string(man.join(&name)).expect(&name);
    let first = page("fstop.1".to_string());
    for command in COMMANDS {
        assert!(
            first.contains(&format!("fstop\\-{command}(1)")),
            "{command}"
        );
        let text = page(format!("fstop-{command}.1"));
        assert!(
            text.contains(".SH NAME") && text.contains("Examples:"),
            "{command}"
        );
    }
    assert!(page("fstop-render.1".to_string()).contains("\\-\\-checkpoint\\-every"));
    assert!(page("fstop-farm-slurm.1".to_string()).contains("\\-\\-shards"));
}

#[test]
fn a_folder_that_cannot_be_made_is_a_failure_of_the_machine() {
    let folder = Folder::new();
    let file = folder.path("file");
    std::fs::write(&file, "").expect("a file");
    let run = fstop(["man".as_ref(), file.as_os_str()]);
    assert_eq!(run.code, 74, "{}", run.stderr);
    assert!(
        run.stderr.starts_with("error: cannot write to "),
        "{}",
        run.stderr
    );
}
