//! `--param`: everything that can be set is listed, and what cannot be set is refused with what can.

use crate::{program, program_with_dam};

#[test]
fn every_listed_parameter_can_be_given_back() {
    let program = program();
    let list = program.run("render none.vtu -o none.png --param list").ok().stdout;
    assert!(list.lines().count() > 15, "{list}");
    for key in ["lod.threshold=1", "filter.name=", "lighting.name=fluid", "post.exposure=0"] {
        assert!(list.contains(key), "{key} in\n{list}");
    }
    let flags: String = list.lines().map(|line| format!(" --param '{line}'")).collect();
    let again = program.run(&format!("render none.vtu -o none.png{flags} --param list")).ok().stdout;
    assert_eq!(again, list);
}

#[test]
fn an_unknown_parameter_lists_those_that_exist() {
    let program = program();
    let render =
        |flag: &str| program.run(&format!("render none.vtu -o none.png --param {flag}")).expect(2).stderr;
    let message = render("post.exposur=1");
    assert!(message.contains("post.exposur") && message.contains("exposure") && message.contains("contrast"));
    let message = render("nothing=1");
    assert!(message.contains("post") && message.contains("lod"), "{message}");
    for (flag, names) in [
        ("--filter", "narrow-range, narrow-range-paper, bilateral, curvature-flow, adaptive, gaussian, none"),
        ("--lighting", "fluid"),
    ] {
        let message = program.run(&format!("render none.vtu -o none.png {flag} nothing")).expect(2).stderr;
        assert!(message.contains(names), "{message}");
    }
}

/// A printed choice is worth something only if the flag that it names exists.
#[test]
fn every_choice_names_a_flag_that_exists() {
    let program = program_with_dam(300, 1);
    let list = program.run("render none.vtu -o none.png --param list").ok().stdout;
    let help = program.run("render --help").ok().stdout;
    program.run("render dam/dam_break.pvd -o a.png --size 32x18 --foam 1 --report a.json").ok();
    let report = meniscus_tests::read_json(&program.path("a.json"));
    let choices = report["choices"].as_array().expect("choices");
    for what in ["spacing", "radius", "up axis", "unit", "adapter", "absorption", "camera", "foam"] {
        assert!(choices.iter().any(|c| c["what"] == what), "{what} in {choices:?}");
    }
    for choice in choices {
        let flag = choice["flag"].as_str().expect("a flag");
        for word in flag.split_whitespace().filter(|word| word.starts_with("--")) {
            assert!(help.contains(word), "{choice}");
        }
        if let Some(parameter) = flag.strip_prefix("--param ") {
            let key = parameter.split_once('=').expect("a key").0;
            assert!(list.lines().any(|line| line.starts_with(&format!("{key}="))), "{choice}");
        }
    }
}
