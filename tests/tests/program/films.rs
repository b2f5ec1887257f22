//! Films: what is in them, when, and what is left when something goes wrong.

use std::fmt::Write;
use std::path::Path;
use std::process::Command;

use meniscus_tests::{Film, Pixels, Program, data_dir, read_json};
use rustix::process::{Pid, Signal, kill_process};

use crate::{program, program_with_dam};

fn film(program: &Program, name: &str) -> Film {
    Film::decode(&std::fs::read(program.path(name)).unwrap_or_else(|e| panic!("{name}: {e}")))
}

/// Names of the pictures in the program's folder.
fn pictures(program: &Program, folder: &str) -> Vec<String> {
    program.list(folder).into_iter().filter(|name| name.ends_with(".png")).collect()
}

#[test]
fn a_film_shows_what_the_pictures_show() {
    let program = program_with_dam(3000, 5);
    // In smaller pictures colours change from one pixel to the next, of which films keep every fourth.
    program.run("render dam/dam_break.pvd -o film.mp4 --size 320x180").ok();
    program.run("render dam/dam_break.pvd -o p_%d.png --size 320x180").ok();
    let film = film(&program, "film.mp4");
    assert_eq!(film.boxes, ["ftyp", "moov", "free", "mdat"], "players can begin at once");
    assert_eq!((film.rate, film.colours, film.pictures.len()), ([24, 1], [1, 1, 1], 5));
    for (number, shown) in film.pictures.iter().enumerate() {
        let psnr = shown.psnr(&Pixels::read(&program.path(&format!("p_{number}.png"))));
        // What films are held to at the default quality.
        assert!(psnr >= 38.0, "picture {number}: {psnr} dB");
    }
}

/// Others have to understand our films; where ffmpeg is installed, it is asked.
#[test]
#[expect(clippy::print_stderr, reason = "a skipped test must not look like a passed one")]
fn ffprobe_finds_what_was_asked_for() {
    if Command::new("ffprobe").arg("-version").output().is_err() {
        eprintln!("SKIPPED: no ffprobe on this machine");
        return;
    }
    let program = program_with_dam(300, 4);
    for (name, flags, expected) in [
        ("a.mp4", "--fps 29.97", "h264,64,48,yuv420p,tv,bt709,bt709,bt709,30000/1001,4"),
        ("odd.mp4", "--size 65x47", "h264,66,48,yuv420p,tv,bt709,bt709,bt709,24/1,4"),
        ("a.avi", "--fps 12", "mjpeg,64,48,yuvj444p,pc,bt470bg,unknown,unknown,12/1,4"),
        ("x.mov", "--encoder ffmpeg --fps 25", "h264,64,48,yuv420p,tv,bt709,bt709,bt709,25/1,4"),
    ] {
        program
            .run(
                &format!("render dam/dam_break.pvd --size 64x48 {flags} -o {name}")
                    .replace("--size 64x48 --size", "--size"),
            )
            .ok();
        let entries = "codec_name,width,height,pix_fmt,color_range,color_space,color_transfer,color_primaries,avg_frame_rate";
        let output = Command::new("ffprobe")
            .args(["-v", "error", "-count_frames", "-of", "csv=p=0", "-show_entries"])
            .arg(format!("stream={entries},nb_read_frames"))
            .arg(program.path(name))
            .output()
            .expect("ffprobe");
        assert_eq!(String::from_utf8_lossy(&output.stdout).trim(), expected, "{name}");
    }
}

/// A block of water that moves by one unit in a unit of time, at times that lie unevenly.
fn moving_block(program: &Program, times: &[f64], with_ids: bool) {
    let mut collection = "<VTKFile type=\"Collection\"><Collection>".to_owned();
    for (index, time) in times.iter().enumerate() {
        let (side, count) = (8, 512);
        let (mut points, mut ids) = (String::new(), String::new());
        for i in 0..count {
            // Written in another order in every frame.
            let id = (i * 5 + index * 77) % count;
            let [x, y, z] = [id % side, id / side % side, id / side / side].map(|c| 0.1 * c as f64);
            writeln!(points, "{} {y} {z}", x + time).expect("text");
            write!(ids, "{id} ").expect("text");
        }
        let attributes = format!("SCALARS id int 1\nLOOKUP_TABLE default\n{ids}\n");
        let velocity = format!("VECTORS velocity float\n{}", "1 0 0\n".repeat(count));
        let text = format!(
            "# vtk DataFile Version 3.0\nblock\nASCII\nDATASET POLYDATA\nPOINTS {count} double\n{points}POINT_DATA {count}\n{}{velocity}",
            if with_ids { &attributes } else { "" }
        );
        program.write(&format!("f_{index}.vtk"), text);
        write!(collection, "<DataSet timestep=\"{time}\" file=\"f_{index}.vtk\"/>").expect("text");
    }
    program.write("block.pvd", collection + "</Collection></VTKFile>");
}

/// Mean column of the pixels that show particles, which are drawn as spheres over nothing.
fn centre(program: &Program, name: &str) -> f64 {
    let pixels = Pixels::read(&program.path(name));
    let covered = || pixels.rgba.iter().enumerate().filter(|(_, p)| p[3] > 127);
    let sum: f64 = covered().map(|(i, _)| (i as u32 % pixels.size[0]) as f64).sum();
    sum / covered().count() as f64
}

const SPHERES: &str = "--set water=id>=0:spheres --param scene.floor=false --transparent --spacing 0.1 --up z \
                       --camera '1.3,-9,0.35/1.3,0,0.35/0,0,1/25' --size 480x120";

/// Steps of 0.1, then of 0.4: held frames would jump, counted frames would run four times as fast in the end.
#[test]
fn uneven_series_play_at_constant_speed() {
    let program = program();
    moving_block(&program, &[0.0, 0.1, 0.2, 0.3, 0.7, 1.1, 1.5], true);
    let flags = format!(
        "render block.pvd {} --fps 20 --speed 3 --report r.json",
        SPHERES.replace("id>=0", "'id >= 0'")
    );
    program.run(&format!("{flags} --interpolate -o i_%02d.png")).ok();
    let frames = read_json(&program.path("r.json"))["frames"].as_array().expect("frames").clone();
    assert_eq!(frames.len(), 11, "1.5 units of time at 3 in a second, 20 pictures in each");
    let centres: Vec<f64> = (0..11).map(|i| centre(&program, &format!("i_{i:02}.png"))).collect();
    for (number, frame) in frames.iter().enumerate() {
        let time = frame["time"].as_f64().expect("a time");
        assert!((time - 0.15 * number as f64).abs() < 1e-9, "{number}: {time}");
    }
    let whole = centres[10] - centres[0];
    assert!(whole > 40.0, "it moves: {centres:?}");
    for (number, centre) in centres.iter().enumerate() {
        let expected = centres[0] + whole * number as f64 / 10.0;
        // Half a pixel: all columns of spheres come over the middle of a pixel at once. Held frames are up to six off.
        assert!((centre - expected).abs() < 0.5, "picture {number}: {centre} instead of {expected}");
    }
    let held = program.run(&format!("{flags} -o h_%02d.png")).ok();
    assert!(
        held.stderr.contains("show the nearest frame") && held.stderr.contains("--interpolate"),
        "{held:#?}"
    );
    let flaw = &read_json(&program.path("r.json"))["flaws"][0];
    // 0.15, 0.45, 0.6, 0.75, 0.9, 1.05, 1.2, 1.35 are at no frame; 0.9 is as far from one as can be.
    assert_eq!(
        (&flaw["kind"], &flaw["pictures"], &flaw["of"]),
        (&"frames_held".into(), &8.into(), &11.into())
    );
    assert!((flaw["at_most"].as_f64().expect("a number") - 0.2).abs() < 1e-9);
    assert!((centre(&program, "h_05.png") - centre(&program, "i_05.png")).abs() > 1.0);
}

#[test]
fn without_ids_frames_are_held_and_said_to_be() {
    let program = program();
    moving_block(&program, &[0.0, 0.1, 0.4], false);
    let render = "render block.pvd --spacing 0.1 --size 64x48 --speed 1 -o o_%02d.png --interpolate";
    let held = program.run(render).ok();
    assert!(held.stderr.contains("the files have no ids"), "{held:#?}");
}

/// Sum of coverage in pixels, its mean column, and how many pixels are covered in part.
fn coverage(program: &Program, name: &str) -> (f64, f64, usize) {
    let pixels = Pixels::read(&program.path(name));
    let alpha = || pixels.rgba.iter().map(|p| f64::from(p[3]) / 255.0);
    let sum: f64 = alpha().sum();
    let moment: f64 = alpha().enumerate().map(|(i, a)| a * (i as u32 % pixels.size[0]) as f64).sum();
    (sum, moment / sum, alpha().filter(|a| (0.02..0.98).contains(a)).count())
}

#[test]
fn what_moves_is_blurred_and_a_camera_that_goes_along_keeps_it_sharp() {
    let program = program();
    moving_block(&program, &[0.0, 0.1, 0.2, 0.3, 0.7, 1.1, 1.5], true);
    let spheres = SPHERES.replace("id>=0", "'id >= 0'");
    // A picture every half unit of time, in which the block moves by half a unit, fifteen pixels.
    let flags = format!("render block.pvd {spheres} --fps 2 --speed 1");
    program.run(&format!("{flags} --interpolate -o sharp_%d.png")).ok();
    program.run(&format!("{flags} --motion-blur 1 --samples 12 -o blur_%d.png")).ok();
    program.run(&format!("{flags} --motion-blur 0.25 --samples 4 -o little_%d.png")).ok();
    let [sharp, blurred, little] =
        ["sharp", "blur", "little"].map(|name| coverage(&program, &format!("{name}_1.png")));
    for (found, name) in [(blurred, "blurred"), (little, "little")] {
        // As much as the sharp picture shows, around the same place. Of some 25 columns, the last is covered or not at once.
        assert!((found.0 / sharp.0 - 1.0).abs() < 0.04, "{name}: {found:?}, sharp {sharp:?}");
        assert!((found.1 - sharp.1).abs() < 0.5, "{name}: {found:?}, sharp {sharp:?}");
    }
    // Fifteen columns at each end, some twenty rows high; a quarter of that.
    assert!(blurred.2 > 450 && (60..300).contains(&little.2), "{blurred:?}, {little:?}, {sharp:?}");

    program.write(
        "along.toml",
        "clock = \"film\"\ncurve = \"linear\"\n[[key]]\nat = 0\neye = [0.35, -9, 0.35]\ntarget = [0.35, 0, 0.35]\nup = [0, 0, 1]\nfovy_deg = 25\n\
         [[key]]\nat = 2\neye = [2.35, -9, 0.35]\ntarget = [2.35, 0, 0.35]\nup = [0, 0, 1]\nfovy_deg = 25\n",
    );
    let from = flags.find("--camera").expect("a camera");
    let to = from + flags[from..].find(" --size").expect("a size");
    let along =
        format!("{}--camera-path along.toml{} --fps 2", &flags[..from], &flags[to..].replace("--fps 2", ""));
    program.run(&format!("{along} --interpolate --samples 4 -o still_%d.png")).ok();
    program.run(&format!("{along} --motion-blur 1 --samples 4 -o along_%d.png")).ok();
    let [still, along] = ["still_1.png", "along_1.png"].map(|name| coverage(&program, name));
    // Positions are rounded to f32, elsewhere in every part: single pixels of edges differ.
    assert!((along.0 / still.0 - 1.0).abs() < 0.01 && along.2 < still.2 + 20, "{along:?}, {still:?}");
}

#[test]
fn motion_that_is_not_known_is_not_blurred_and_said_not_to_be() {
    let program = program();
    moving_block(&program, &[0.0, 0.1, 0.4], false);
    let render = "render block.pvd --spacing 0.1 --size 64x48 -o o_%02d.png --motion-blur 0.5";
    assert!(program.run(render).ok().stderr.contains("no motion blur: the files have no ids"));
    let render = "render f_0.vtk --spacing 0.1 --size 64x48 -o o.png --motion-blur 0.5";
    assert!(program.run(render).ok().stderr.contains("there is one frame only"));
    assert!(
        program.run("render block.pvd -o o.png --motion-blur 1.5").expect(2).stderr.contains("at most 1")
    );
}

/// Whatever is drawn elsewhere is what is drawn here, and so is the film of it.
#[test]
fn three_shards_are_the_single_run_bit_for_bit() {
    let program = program_with_dam(3000, 7);
    let flags = "render dam/dam_break.pvd --size 96x54 --interpolate --speed 6";
    program.run(&format!("{flags} -o all_%03d.png")).ok();
    program.run(&format!("{flags} -o film.mp4")).ok();
    let all = pictures(&program, "");
    assert!(all.len() > 4, "{all:?}");
    for shard in 1..=3 {
        program.run(&format!("{flags} -o machine{shard}/all_%03d.png --shard {shard}/3")).ok();
        assert!(pictures(&program, &format!("machine{shard}")).len() <= all.len().div_ceil(3));
    }
    for (number, name) in all.iter().enumerate() {
        let shard = std::fs::read(program.path(&format!("machine{}/{name}", number % 3 + 1)));
        assert!(shard.expect("a picture") == std::fs::read(program.path(name)).expect("a picture"), "{name}");
    }
    program.run("join machine1 machine2 machine3 -o joined.mp4").ok();
    let bytes = |name: &str| std::fs::read(program.path(name)).expect("a film");
    assert!(bytes("joined.mp4") == bytes("film.mp4"), "the same pictures, the same film");
    std::fs::remove_file(program.path(&format!("machine2/{}", all[1]))).expect("a picture");
    let gap = program.run("join machine1 machine2 machine3 -o gap.mp4").expect(2);
    assert!(gap.stderr.contains("missing: 1;") && !program.path("gap.mp4").exists(), "{gap:#?}");
    let no_film = program.run(&format!("{flags} -o film2.mp4 --shard 1/3")).expect(5);
    assert!(no_film.stderr.contains("join"), "{no_film:#?}");
}

#[test]
fn resuming_draws_what_is_missing_damaged_or_of_other_settings() {
    let program = program_with_dam(300, 4);
    let render = "render dam/dam_break.pvd --size 64x36 -o o_%d.png --report r.json";
    let drawn = |flags: &str| {
        program.run(&format!("{render} {flags}")).ok();
        let report = read_json(&program.path("r.json"));
        let frames = report["frames"].as_array().expect("frames").iter();
        frames.map(|frame| frame["frame"].as_u64().expect("a number")).collect::<Vec<_>>()
    };
    let bytes = |number: u32| std::fs::read(program.path(&format!("o_{number}.png"))).expect("a picture");
    assert_eq!(drawn("--resume"), [0, 1, 2, 3]);
    let first = [0, 1, 2, 3].map(bytes);
    assert_eq!(drawn("--resume"), [0_u64; 0]);
    std::fs::remove_file(program.path("o_1.png")).expect("a picture");
    program.write("o_2.png", &first[2][..first[2].len() / 2]);
    assert_eq!(drawn("--resume"), [1, 2]);
    assert!([0, 1, 2, 3].map(bytes) == first);
    // The data of frame 3 are newer than its picture.
    let data =
        std::fs::File::options().append(true).open(program.path("dam/dam_break_0003.vtu")).expect("data");
    data.set_modified(std::time::SystemTime::now() + std::time::Duration::from_secs(5)).expect("a time");
    assert_eq!(drawn("--resume"), [3]);
    data.set_modified(std::time::UNIX_EPOCH).expect("a time");
    assert_eq!(drawn("--resume --param post.exposure=0.5"), [0, 1, 2, 3]);
    assert_eq!(drawn("--resume --param post.exposure=0.5"), [0_u64; 0]);
    assert_eq!(drawn("--param post.exposure=0.5"), [0, 1, 2, 3], "only when asked to");
    let film = program.run("render dam/dam_break.pvd --size 64x36 -o f.mp4 --resume").expect(5);
    assert!(film.stderr.contains("join"), "{film:#?}");
}

/// The files in `folder` that have a name of their own.
fn named(program: &Program, folder: &str) -> Vec<String> {
    program.list(folder).into_iter().filter(|name| !name.starts_with('.')).collect()
}

/// Whenever it ends, there is no film or a whole one. The moments are those at which the file on its way grows.
#[test]
fn killing_at_any_moment_leaves_no_half_film() {
    let program = program_with_dam(500, 30);
    for (round, name) in ["f.mp4", "f.avi", "f.mp4", "f.avi"].into_iter().enumerate() {
        let folder = format!("out{round}");
        let render = format!("render dam/dam_break.pvd -o {folder}/{name} --size 160x90");
        let mut running = program.start(&render, &[]);
        running.wait_for(&program.path(&folder));
        // Later and later: before the first picture, between pictures, near the end.
        let enough = round as u64 * 10_000;
        let size = || {
            let files = std::fs::read_dir(program.path(&folder)).into_iter().flatten().flatten();
            files.filter_map(|file| file.metadata().ok()).map(|file| file.len()).sum::<u64>()
        };
        while size() < enough && !running.has_ended() {}
        // It may have ended by now.
        let _ = kill_process(Pid::from_raw(running.id() as i32).expect("a process"), Signal::KILL);
        let code = running.finish().code;
        match (code, named(&program, &folder).as_slice()) {
            (None, []) => {}
            (Some(0), [film]) if film == name => {}
            other => panic!("{other:?}"),
        }
    }
}

/// Interrupts `command`, which writes to `out/`, once more than `bytes` are there, so many that pictures are among them; what it
/// said.
fn interrupted(program: &Program, command: &str, bytes: u64) -> String {
    let mut running = program.start(command, &[]);
    running.wait_for(&program.path("out"));
    let grown = || {
        std::fs::read_dir(program.path("out"))
            .into_iter()
            .flatten()
            .flatten()
            .any(|file| file.metadata().is_ok_and(|file| file.len() > bytes))
    };
    while !grown() && !running.has_ended() {}
    kill_process(Pid::from_raw(running.id() as i32).expect("a process"), Signal::INT).expect("a signal");
    running.finish().expect(130).stderr.clone()
}

#[test]
fn an_interrupted_film_is_kept_under_a_name_that_says_so() {
    let program = program_with_dam(2000, 100);
    let said =
        interrupted(&program, "render dam/dam_break.pvd -o out/f.mp4 --size 160x90 --report r.json", 30_000);
    assert!(said.contains("of 100 pictures are in out/f.partial.mp4"), "{said}");
    assert_eq!(program.list("out"), ["f.partial.mp4"]);
    let count = film(&program, "out/f.partial.mp4").pictures.len();
    assert!((1..100).contains(&count));
    assert_eq!(read_json(&program.path("r.json"))["frames"].as_array().map(Vec::len), Some(count));

    program.run("render dam/dam_break.pvd -o p/p_0.png --size 640x360 --frame 0").ok();
    for number in 1..400 {
        std::fs::copy(program.path("p/p_0.png"), program.path(&format!("p/p_{number}.png"))).expect("a copy");
    }
    std::fs::remove_dir_all(program.path("out")).expect("emptied");
    let said = interrupted(&program, "join p -o out/j.avi", 300_000);
    assert!(said.contains("of 400 pictures are in out/j.partial.avi"), "{said}");
    assert_eq!(program.list("out"), ["j.partial.avi"]);
}

/// A limit on the size of files stands for a full disk: the system refuses in the middle of a write.
#[test]
fn a_full_disk_keeps_what_was_written_and_says_what_is_missing() {
    let program = program_with_dam(500, 40);
    let limited = |kib: u32, arguments: &str| {
        let shell = Program::new("sh");
        let command = format!(
            "-c \"trap '' XFSZ; ulimit -f {kib}; cd {} && exec {} {arguments}\"",
            program.path("").display(),
            env!("CARGO_BIN_EXE_meniscus-under-test"),
        );
        shell.run(&command).expect(5)
    };
    // 512 bytes each.
    let film_run = limited(60, "render dam/dam_break.pvd -o f.mp4 --size 160x90 -q");
    assert!(film_run.stderr.contains("File too large"), "{film_run:#?}");
    assert!(film_run.stderr.contains("of 40 pictures are in f.partial.mp4"), "{film_run:#?}");
    assert!((1..40).contains(&film(&program, "f.partial.mp4").pictures.len()));
    let film_run = limited(120, "render dam/dam_break.pvd -o f.avi --size 160x90 -q");
    assert!(film_run.stderr.contains("of 40 pictures are in f.partial.avi"), "{film_run:#?}");
    assert_eq!(named(&program, ""), ["dam", "f.partial.avi", "f.partial.mp4"]);
    let stills = limited(16, "render dam/dam_break.pvd -o o_%02d.png --size 160x90 -q");
    assert!(
        stills.stderr.contains("0 of 40 pictures are there, missing: o_00.png to o_39.png"),
        "{stills:#?}"
    );
    assert_eq!(pictures(&program, ""), [""; 0]);
}

#[test]
fn a_frame_that_cannot_be_read_keeps_its_time() {
    let program = program_with_dam(300, 4);
    program.write("dam/dam_break_0001.vtu", "not a particle file");
    let outcome = program.run("render dam/dam_break.pvd -o f.mp4 --size 64x48 --dt 1").expect(3);
    assert!(outcome.stderr.contains("1 of 4 frames"), "{outcome:#?}");
    let film = film(&program, "f.mp4");
    assert_eq!(film.pictures.len(), 4, "the others are not shown earlier");
    // 45 dB: the encoder's second try at the same picture. Different ones differ by more.
    assert!(film.pictures[1].psnr(&film.pictures[0]) > 45.0);
    assert!(film.pictures[3].psnr(&film.pictures[0]) < 35.0);
}

#[test]
fn pictures_come_in_other_formats_with_more_bits_and_smoother() {
    let program = program_with_dam(2000, 1);
    let render = |name: &str, flags: &str| {
        program.run(&format!("render dam/dam_break_0000.vtu --size 96x54 -o {name} {flags}")).ok();
        image::open(program.path(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    };
    let eight = render("a.png", "");
    let sixteen = render("b.png", "--bits 16");
    assert_eq!((eight.color(), sixteen.color()), (image::ColorType::Rgb8, image::ColorType::Rgb16));
    let colours = |image: &image::DynamicImage| {
        image.to_rgb16().pixels().map(|p| p.0).collect::<std::collections::HashSet<_>>().len()
    };
    assert!(colours(&sixteen) > colours(&eight));
    let compare = |a: &image::DynamicImage, b: &image::DynamicImage| {
        let pairs = a.to_rgb8().into_raw().into_iter().zip(b.to_rgb8().into_raw());
        pairs.map(|(a, b)| f64::from(a.abs_diff(b))).sum::<f64>() / f64::from(96 * 54 * 3)
    };
    // Steps of 255: dither of half a step and smoothed edges.
    assert!(compare(&eight, &sixteen) < 1.5, "{}", compare(&eight, &sixteen));
    assert!(compare(&eight, &render("a.jpg", "--quality 95")) < 3.0);
    let fine = render("s.png", "--supersample 3");
    assert_eq!((fine.width(), fine.height()), (96, 54));
    assert!((0.01..6.0).contains(&compare(&eight, &fine)), "{}", compare(&eight, &fine));
    let linear = render("a.exr", "").to_rgba32f();
    let sky = linear.get_pixel(1, 1).0;
    assert!(sky.iter().all(|c| c.is_finite()) && sky[3] == 1.0);
    let clear = render("t.exr", "--transparent --param scene.floor=false").to_rgba32f();
    assert_eq!(clear.get_pixel(1, 1).0, [0.0; 4], "no sky where there is no water");
    for (flags, word) in [
        ("-o a.jpg --transparent", ".png and .exr"),
        ("-o a.jpg --bits 16", ".exr"),
        ("-o a.png --bitrate 1M", "films"),
        ("-o a.mkv", "--encoder ffmpeg"),
        ("-o a.mp4 --size 4096x2160", "--encoder ffmpeg"),
    ] {
        let refused = program.run(&format!("render dam/dam_break_0000.vtu {flags}")).expect(5);
        assert!(refused.stderr.contains(word), "{refused:#?}");
    }
}

#[test]
fn the_camera_follows_its_path() {
    let program = program_with_dam(2000, 3);
    program.write(
        "path.toml",
        "clock = \"share\"\n[[key]]\nat = 0\neye = [3, -3, 2]\ntarget = [1, 0.5, 0]\nfovy_deg = 30\n\
         [[key]]\nat = 1\neye = [-2, -3, 2]\ntarget = [1, 0.5, 0]\nfovy_deg = 30\n",
    );
    program.run("render dam/dam_break.pvd -o p_%d.png --size 64x36 --camera-path path.toml").ok();
    let at = |name: &str, eye: &str, frame: u32| {
        let camera = format!("--camera '{eye}/1,0.5,0/0,0,1/30' --frame {frame}");
        program.run(&format!("render dam/dam_break.pvd -o {name} --size 64x36 {camera}")).ok();
        Pixels::read(&program.path(name))
    };
    let picture = |number: u32| Pixels::read(&program.path(&format!("p_{number}.png")));
    assert!(at("first.png", "3,-3,2", 0) == picture(0));
    assert!(at("middle.png", "0.5,-3,2", 1) == picture(1));
    assert!(at("last.png", "-2,-3,2", 2) == picture(2));
    program.write("bad.toml", "[[key]]\nat = 0\neye = [0, 0, 0]\ntarget = [0, 0, 0]\n");
    for (file, word) in
        [("bad.toml", "same point"), ("none.toml", "none.toml"), ("dam/dam_break.pvd", "line 1")]
    {
        let outcome =
            program.run(&format!("render dam -o x_%d.png --size 64x36 --camera-path {file}")).expect(2);
        assert!(outcome.stderr.contains(word), "{outcome:#?}");
    }
}

/// Four pictures of a frame, each from elsewhere: what is drawn is another picture every time, of particles that were read once.
#[test]
fn a_held_frame_is_read_and_prepared_once() {
    let program = program_with_dam(2000, 3);
    program.write(
        "path.toml",
        "clock = \"share\"\n[[key]]\nat = 0\neye = [3, -3, 2]\ntarget = [1, 0.5, 0]\nfovy_deg = 30\n\
         [[key]]\nat = 1\neye = [-2, -3, 2]\ntarget = [1, 0.5, 0]\nfovy_deg = 30\n",
    );
    let flags =
        "--size 64x36 --dt 0.1 --fps 20 --speed 0.5 --camera-path path.toml --trace t.json --report r.json";
    program.run(&format!("render dam/dam_break.pvd -o s_%d.png {flags}")).ok();
    let trace = read_json(&program.path("t.json"));
    let events = trace["traceEvents"].as_array().expect("events");
    let count =
        |name: &str| events.iter().filter(|event| event["ph"] == "X" && event["name"] == name).count();
    assert_eq!((count("read"), count("prepare"), count("draw")), (3, 3, 9));
    let frames = &read_json(&program.path("r.json"))["frames"];
    for (number, frame) in frames.as_array().expect("frames").iter().enumerate() {
        let time = frame["time"].as_f64().expect("a time");
        assert!((time - 0.025 * number as f64).abs() < 1e-9 && frame["frame"] == number, "{number}: {frame}");
    }
    let camera = "--camera '0.5,-3,2/1,0.5,0/0,0,1/30' --frame 1";
    program.run(&format!("render dam/dam_break.pvd -o middle.png --size 64x36 {camera}")).ok();
    let picture = |name: &str| Pixels::read(&program.path(name));
    assert!(picture("middle.png") == picture("s_4.png"), "the second frame from half-way");
    assert!(picture("s_4.png") != picture("s_5.png"), "the camera has moved on");
}

/// The script that the examples have for SLURM, with a stand-in for its queue.
#[test]
fn the_slurm_array_makes_the_film_of_a_single_run() {
    let program = program_with_dam(500, 5);
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/slurm/film.sh");
    let queue = "#!/bin/sh\n# sbatch --parsable [--dependency=...] [--array=1-N] SCRIPT ARGUMENTS...: runs all at once.\n\
                 last=0\nwhile :; do case $1 in --array=1-*) last=${1#--array=1-}; shift;; --*) shift;; *) break;; esac; done\n\
                 if [ $last = 0 ]; then sh \"$@\" >&2; else i=1; while [ $i -le $last ]; do\n\
                 SLURM_ARRAY_TASK_ID=$i SLURM_ARRAY_TASK_COUNT=$last sh \"$@\" >&2 || exit 1; i=$((i + 1)); done; fi\necho 42\n";
    program.write("bin/sbatch", queue);
    program.write(
        "bin/meniscus",
        format!("#!/bin/sh\nexec {} \"$@\"\n", env!("CARGO_BIN_EXE_meniscus-under-test")),
    );
    for name in ["bin/sbatch", "bin/meniscus"] {
        use std::os::unix::fs::PermissionsExt;
        std::fs::set_permissions(program.path(name), std::fs::Permissions::from_mode(0o755)).expect("rights");
    }
    let path = format!("{}:{}", program.path("bin").display(), std::env::var("PATH").unwrap_or_default());
    let status = Command::new("sh")
        .arg(&script)
        .args(["3", "dam/dam_break.pvd", "film.mp4", "--size", "64x36"])
        .env("PATH", path)
        .current_dir(program.path(""))
        .output()
        .expect("the script");
    assert!(status.status.success(), "{status:?}");
    program.run("render dam/dam_break.pvd -o single.mp4 --size 64x36").ok();
    let bytes =
        |name: &str| std::fs::read(program.path(name)).unwrap_or_else(|e| panic!("{name}: {e}: {status:?}"));
    assert!(bytes("film.mp4") == bytes("single.mp4"));
}

/// The solver wrote steps of 4 ms, then of 16 ms. Held frames would stand still in the second part and jump.
#[test]
fn sphere_entry_plays_at_constant_speed() {
    let Some(data) = data_dir() else { return };
    let program = program();
    let input = data.join("sphere_entry/fluid.pvd");
    let flags = "--frames 14..18 --speed 0.1 --every 3 --size 160x120 --report r.json";
    let render = |name: &str, more: &str| {
        program.run(&format!("render {} -o {name}_%02d.png {flags} {more}", input.display())).ok();
        let report = read_json(&program.path("r.json"));
        let times: Vec<f64> = report["frames"]
            .as_array()
            .expect("frames")
            .iter()
            .map(|frame| frame["time"].as_f64().expect("a time"))
            .collect();
        for (number, time) in times.iter().enumerate() {
            // 24 pictures a second at a tenth of real time.
            assert!((time - times[0] - number as f64 * 0.1 / 24.0).abs() < 1e-9, "{times:?}");
        }
        let picture = |number: usize| Pixels::read(&program.path(&format!("{name}_{number:02}.png")));
        let changes = (1..times.len()).map(|number| picture(number).mean_difference(&picture(number - 1)));
        changes.collect::<Vec<_>>()
    };
    let moving = render("i", "--interpolate");
    assert_eq!(moving.len() + 1, 10, "40 ms in steps of 4.17");
    let mean = moving.iter().sum::<f64>() / moving.len() as f64;
    // The flow itself slows down and speeds up by less than this.
    assert!(moving.iter().all(|change| (0.3..3.0).contains(&(change / mean))), "{moving:?}");
    let held = render("h", "");
    assert!(held.iter().filter(|change| **change == 0.0).count() >= 3, "{held:?}");
}
