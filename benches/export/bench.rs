//! Writing pictures and films: how long a frame takes after it was drawn. The picture is an analytic pool in a gradient
//! sky, with the grain that ripples and glints give: neither flat, which compresses for nothing, nor noise, which does not
//! compress at all.
//!
//! | size | why |
//! |---|---|
//! | `720p` | the default of `render` |
//! | `1080p` | what films are made in |

use std::path::Path;

use bench_views::{Pool, Stage};
use criterion::{Criterion, criterion_group, criterion_main};
use meniscus_core::Pixels;
use meniscus_export::{
    DEFAULT_FILM_QUALITY, Encoder, FilmOptions, FrameRate, Still, StillOptions, open_film, write_still,
};

const SIZES: [(&str, [u32; 2]); 2] = [("720p", [1280, 720]), ("1080p", [1920, 1080])];

/// sRGB, red in the lowest byte: water as dark as its thickness and as bright as its tilt, floor and sky.
fn picture(size: [u32; 2]) -> Vec<u32> {
    let pool = Pool::new(size);
    let pixel = |i: usize| {
        let down = (i as u32 / size[0]) as f32 / size[1] as f32;
        let [tilt_x, tilt_y] =
            [pool.normal[i] as u16, (pool.normal[i] >> 16) as u16].map(|n| f32::from(n as i16) / 32767.0);
        let color = if pool.distance[i] < f32::MAX {
            let clear = (-pool.thickness[i] * 2.0).exp();
            let glint = ((tilt_x * 40.0).sin() * (tilt_y * 40.0).cos()).max(0.0).powi(8);
            [0.1 + 0.5 * clear, 0.3 + 0.4 * clear + 0.3 * tilt_y, 0.5 + 0.3 * clear].map(|c| c + glint)
        } else if pool.floor_distance[i] < f32::MAX {
            [0.55 - 0.1 * down; 3]
        } else {
            [0.4 + 0.4 * down, 0.6 + 0.3 * down, 0.9]
        };
        let [r, g, b] = color.map(|c| (c.clamp(0.0, 1.0) * 255.0).round() as u32);
        0xff00_0000 | b << 16 | g << 8 | r
    };
    (0..pool.distance.len()).map(pixel).collect()
}

fn write(path: &Path, size: [u32; 2], pixels: &Pixels) {
    let still = Still { size, pixels, with_alpha: false, channels: &[], note: "" };
    write_still(path, &still, StillOptions::default()).expect("a file in the temporary folder");
}

fn export(criterion: &mut Criterion) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut stage = Stage::new(criterion, "export");
    for (name, size) in SIZES {
        let size = if bench_views::is_measured() { size } else { [160, 90] };
        let path = folder.path().join(format!("{name}.png"));
        let pixels = u64::from(size[0]) * u64::from(size[1]);
        stage.cpu(
            ["png", name],
            pixels,
            || Pixels::Display8(picture(size)),
            // The picture is read, the file written.
            |_| path.metadata().ok().map(|file| 4 * pixels + file.len()),
            |picture| write(&path, size, picture),
        );
        // Of a film, every second picture is the other one, which has moved by two pixels.
        for ending in ["mp4", "avi"] {
            let still = picture(size);
            let moved: Vec<u32> = still.iter().cycle().skip(2).take(still.len()).copied().collect();
            let options = FilmOptions {
                size,
                rate: FrameRate::whole(24),
                pictures: 1_000_000,
                quality: DEFAULT_FILM_QUALITY,
                bits_per_second: None,
                encoder: Encoder::BuiltIn,
            };
            let path = folder.path().join(format!("{name}.{ending}"));
            let mut film = open_film(&path, &options).expect("a film in the temporary folder");
            let mut number = 0;
            stage.cpu(
                [ending, name],
                pixels,
                || [still, moved],
                |_| Some(4 * pixels),
                |pictures| {
                    number += 1;
                    film.push(&pictures[number % 2]).expect("a picture encoded");
                },
            );
        }
    }
}

criterion_group!(benches, export);
criterion_main!(benches);
