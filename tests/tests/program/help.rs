//! Every command explains itself with examples, and the examples are right.

use crate::{program, program_with_dam};

const COMMANDS: [&str; 6] = ["info", "render", "bench", "convert", "make", "join"];

#[test]
fn every_command_has_help_with_examples_and_exit_codes() {
    let program = program();
    let help = program.run("--help").ok().stdout;
    assert!(help.contains("Exit codes"), "{help}");
    for command in COMMANDS {
        assert!(help.contains(command), "{help}");
        let own = program.run(&format!("{command} --help")).ok();
        assert!(own.stdout.contains("Examples:"), "{}", own.stdout);
        assert!(own.stdout.contains(&format!("meniscus {command} ")), "{}", own.stdout);
        for flag in ["--quiet", "--verbose", "--threads"] {
            assert!(own.stdout.contains(flag), "{command}: {flag}");
        }
        assert_eq!(own.stderr, "");
        // Nobody should have to know which of the two to type.
        assert!(program.run(&format!("{command} -h")).ok().stdout.contains("Examples:"));
    }
    assert!(program.run("--version").ok().stdout.starts_with("meniscus "));
    let bare = program.run("").expect(2);
    assert!(format!("{}{}", bare.stdout, bare.stderr).contains("Usage: "));
}

/// Examples age. Each is run, on a made series under the name that it uses.
#[test]
fn the_examples_run() {
    let program = program_with_dam(300, 13);
    let folder = program.path("dam");
    for (name, file) in
        [("fluid.pvd", "dam_break.pvd"), ("dam.pvd", "dam_break.pvd"), ("fluid.vtu", "dam_break_0006.vtu")]
    {
        std::fs::copy(folder.join(file), program.path(name)).expect("a copy");
    }
    for index in 0..13 {
        let from = folder.join(format!("dam_break_{index:04}.vtu"));
        std::fs::copy(&from, program.path(&format!("dam_break_{index:04}.vtu"))).expect("a copy");
        std::fs::copy(&from, program.path(&format!("out_{index:04}.vtu"))).expect("a copy");
    }
    std::fs::rename(&folder, program.path("frames")).expect("a rename");
    let mut run = 0;
    for command in ["info", "render", "bench", "convert"] {
        let help = program.run(&format!("{command} --help")).ok().stdout;
        let (_, examples) = help.split_once("Examples:").expect("examples");
        // Wrapped lines are indented like the first: an example ends where the next begins.
        let joined = examples.split_whitespace().collect::<Vec<_>>().join(" ");
        for example in joined.split("meniscus ").skip(1) {
            // The made series has no attribute `type`, and the examples' size is for people who can wait.
            let small = example
                .replace("type == 0", "id >= 9")
                .replace("type == 1", "id < 9")
                .replace("1280x720", "64x36")
                .replace("1920x1080", "64x36")
                .replace("--frames 20", "--frames 1");
            let draws = ["render", "bench"].contains(&command) && !small.contains("--compare");
            let size = if draws && !small.contains("--size") { "--size 64x36" } else { "" };
            program.run(&small.replacen(command, &format!("{command} {size}"), 1)).ok();
            run += 1;
        }
    }
    assert!(run >= 9, "{run} examples");
    assert!(program.path("lod.json").exists(), "what an example redirects");
}
