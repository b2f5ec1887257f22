//! Adapters: listed, chosen, missing.

use meniscus_tests::Pixels;

use crate::program_with_dam;

#[test]
fn adapters_are_listed_and_chosen_by_number_or_name() {
    let program = program_with_dam(300, 1);
    let list = program.run("--list-adapters").ok().stdout;
    let first = list.lines().next().expect("an adapter");
    let name = first.strip_prefix("0: ").and_then(|l| l.split_whitespace().next()).expect("a name");
    for adapter in ["0", name] {
        program.run(&format!("render dam -o a.png --frame 0 --size 16x9 --adapter {adapter}")).ok();
    }
    let unknown = program.run("render dam -o b.png --frame 0 --size 16x9 --adapter voodoo").expect(4);
    assert!(unknown.stderr.contains("voodoo") && unknown.stderr.contains(name), "{unknown:#?}");
    assert!(!program.path("b.png").exists());
}

/// A machine without any driver: the loader is told to look at a file that does not exist.
#[test]
fn without_a_driver_the_message_names_the_package_to_install() {
    let program = program_with_dam(300, 1);
    let no_driver = [("VK_DRIVER_FILES", "/nonexistent.json"), ("VK_ICD_FILENAMES", "/nonexistent.json")];
    for arguments in [
        "--list-adapters",
        "render dam -o a.png --frame 0 --size 16x9",
        "bench dam --frame 0 --size 16x9 --json",
    ] {
        let outcome = program.run_with(arguments, &no_driver).expect(4);
        assert!(outcome.stderr.contains("apt-get install") && outcome.stderr.contains("mesa-vulkan-drivers"));
        if arguments.contains("--json") {
            assert_eq!(outcome.json()["error"]["kind"], "gpu");
        }
    }
    // What needs no adapter works without.
    assert_eq!(program.run_with("info dam --json", &no_driver).ok().json()["frames"], 1);
}

/// Lavapipe takes vectors of four numbers on processors without AVX, and some of its own mistakes show only then.
#[test]
fn narrow_vectors_draw_the_same_picture() {
    let program = program_with_dam(300, 1);
    let render = "render dam --frame 0 --size 64x36 -q -o";
    program.run(&format!("{render} usual.png")).ok();
    program.run_with(&format!("{render} narrow.png"), &[("LP_NATIVE_VECTOR_WIDTH", "128")]).ok();
    let [usual, narrow] = ["usual.png", "narrow.png"].map(|name| Pixels::read(&program.path(name)));
    // The same arithmetic in another order of lanes.
    assert!(usual.mean_difference(&narrow) < 0.1, "steps of 255");
}
