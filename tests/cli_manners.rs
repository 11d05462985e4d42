//! Manners of the real binary: help that shows examples, completions, a manual, and silence when nobody listens.

mod cli_support;
mod glb;

use cli_support::{Ball, Folder, command, invertex, run};

#[test]
fn every_help_ends_with_examples() {
    let verbs = [
        "doctor",
        "inspect",
        "build",
        "query",
        "render",
        "profile",
        "compare",
        "demo",
        "completions",
        "man",
    ];
    for verb in verbs {
        let help = invertex(&[verb, "--help"]).ok().stdout;
        let examples = help
            .split("Examples:")
            .nth(1)
            .unwrap_or_else(|| panic!("{verb} --help has no examples"));
        assert!(
            examples.contains(&format!("invertex {verb}")),
            "{verb}: {examples}"
        );
    }
    assert!(invertex(&["--help"]).ok().stdout.contains("Examples:"));
    assert!(
        invertex(&["completions", "bash"])
            .ok()
            .stdout
            .contains("_invertex")
    );
    assert!(invertex(&["man"]).ok().stdout.starts_with(".ie"));
    assert!(invertex(&["man", "build"]).ok().stdout.contains("primary"));
    invertex(&["man", "dance"]).fails(2, &["dance"]);
}

#[test]
fn a_closed_pipe_is_quiet() {
    let folder = Folder::new();
    let model = folder.write("ball.glb", &Ball::default().glb());
    let mut command = command(&["inspect", &model, "--json"]);
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    command.stdout(writer);
    let out = run(command);
    assert_eq!((out.code, out.stderr.as_str()), (0, ""));
}
