//! The clip of the page in the README: an animated picture (WebP) of a tilt that rises from a torus to chaos.

use std::time::Instant;

use super::Live;
use super::page::opened;

/// Size of the page and of the clip, pixels.
const PAGE: [u32; 2] = [1280, 720];
const CLIP: [u32; 2] = [960, 540];
/// Pictures of the clip.
const PICTURES: usize = 20;
/// Rise of the tilt between two pictures, degrees.
const RISE: f64 = 0.14;
/// Largest size of the file, bytes.
const LARGEST: usize = 1_000_000;

/// A chunk of a RIFF file.
fn chunk(name: &[u8; 4], data: &[u8]) -> Vec<u8> {
    let mut chunk = name.to_vec();
    chunk.extend((data.len() as u32).to_le_bytes());
    chunk.extend(data);
    chunk.resize(chunk.len().next_multiple_of(2), 0);
    chunk
}

/// A number of 24 bits.
fn three_bytes(number: u32) -> [u8; 3] {
    let [a, b, c, _] = number.to_le_bytes();
    [a, b, c]
}

/// The chunk with the pixels of a WebP file.
fn pixels(webp: &[u8]) -> &[u8] {
    let mut rest = &webp[12..];
    loop {
        let length = u32::from_le_bytes(rest[4..8].try_into().unwrap()) as usize;
        let end = (8 + length).next_multiple_of(2).min(rest.len());
        if rest.starts_with(b"VP8 ") {
            return &rest[..end];
        }
        rest = &rest[end..];
    }
}

/// An endless animation of WebP pictures, each with its duration, ms.
fn animation(pictures: &[(Vec<u8>, u32)]) -> Vec<u8> {
    const ANIMATED: [u8; 4] = [2, 0, 0, 0];
    let size = CLIP.map(|length| three_bytes(length - 1)).concat();
    let mut body = b"WEBP".to_vec();
    body.extend(chunk(b"VP8X", &[&ANIMATED[..], &size].concat()));
    body.extend(chunk(b"ANIM", &[0; 6]));
    for (picture, duration) in pictures {
        let place = [0; 6];
        let duration = three_bytes(*duration);
        let replaces = [2];
        let frame = [&place[..], &size, &duration, &replaces, pixels(picture)].concat();
        body.extend(chunk(b"ANMF", &frame));
    }
    chunk(b"RIFF", &body)
}

#[test]
#[ignore = "makes a picture: assets/screenshots/make"]
fn clip() {
    let folder = std::env::var_os("SQUEAKSCOPE_SCREENSHOTS")
        .expect("SQUEAKSCOPE_SCREENSHOTS names a folder");
    let live = Live::start("torus-1.75deg", &["--speed", "20", "--no-lyapunov"]);
    let (mut browser, tab) = opened(&live).expect("Chromium");
    browser.resize(&tab, PAGE);
    browser.run(
        &tab,
        "squeakscope.stage.show(['patch', 'portrait', 'scope', 'spectrum', 'section', 'body'])",
    );
    // Until the torus has closed and is classified.
    browser.until(&tab, "squeakscope.run.data.time > 0.2");
    let mut pictures = Vec::new();
    for k in 0..PICTURES {
        let began = Instant::now();
        let deg = 3.0 + RISE * k as f64;
        let tilt = format!("squeakscope.ask({{ do: 'set', key: 'tilt_deg', value: {deg:.2} }})");
        browser.run(&tab, &tilt);
        let picture = browser.webp(&tab, PAGE, CLIP);
        pictures.push((picture, began.elapsed().as_millis() as u32));
    }
    let clip = animation(&pictures);
    println!("{} pictures, {} kB", pictures.len(), clip.len() / 1000);
    assert!(clip.len() < LARGEST, "{} bytes", clip.len());
    std::fs::write(std::path::Path::new(&folder).join("live-page.webp"), clip).expect("written");
}
