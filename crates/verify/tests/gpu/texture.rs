//! Frames that a GPU renders to a texture show their developed films.

use std::collections::HashSet;

use umbrage::gpu::wgpu;
use umbrage::scene::Scene;
use umbrage::{Error, Renderer, Settings, Stats, ToneMap};

use crate::common::{Device, Pooled, device, renderer, small_device, small_renderer};

/// A renderer and its device, to read textures with.
struct Shared {
    renderer: Pooled<Renderer>,
    device: &'static Device,
}

impl Shared {
    /// A texture's pixels, in rows from the upper left corner.
    fn pixels(&self, texture: &wgpu::Texture) -> Vec<[u8; 4]> {
        let [width, height] = [texture.width(), texture.height()];
        let row = (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let buffer = self.device.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: u64::from(row * height),
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let mut encoder = self.device.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None };
        encoder.copy_texture_to_buffer(
            texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo { buffer: &buffer, layout },
            texture.size(),
        );
        self.device.queue.submit([encoder.finish()]);
        buffer.map_async(wgpu::MapMode::Read, .., |mapped| mapped.expect("mapped"));
        self.device.device.poll(wgpu::PollType::wait_indefinitely()).expect("done");
        let bytes = buffer.get_mapped_range(..).expect("mapped");
        let rows = bytes.chunks_exact(row as usize).flat_map(|row| row[..4 * width as usize].chunks_exact(4));
        rows.map(|pixel| [pixel[0], pixel[1], pixel[2], pixel[3]]).collect()
    }

    /// The pixels of a texture and of the film of the same frame, and the statistics of each.
    fn both(&mut self, scene: &Scene, seconds: f64, settings: &Settings) -> [(Vec<[u8; 4]>, Stats); 2] {
        let texture = self.renderer.render_to_texture(scene, seconds, settings).expect("a texture");
        assert_eq!([texture.width(), texture.height()], [settings.width, settings.height]);
        assert!(self.renderer.film().color.is_empty(), "no film was fetched");
        let of_texture = self.renderer.stats().clone();
        let drawn = self.pixels(&texture);
        let mut developed = Vec::new();
        self.renderer.render(scene, seconds, settings).expect("a film").develop_for_screen(settings, &mut developed);
        [(drawn, of_texture), (developed, self.renderer.stats().clone())]
    }
}

fn shared() -> Option<Shared> {
    Some(Shared { renderer: renderer()?, device: device()? })
}

fn open_scene(name: &str) -> Scene {
    umbrage::open(format!("demo:{name}?triangles=3000")).expect("a scene of the gallery")
}

fn sized(width: u32, height: u32) -> Settings {
    Settings { width, height, ..Settings::default() }
}

/// Expects the same pixels, except for `most` values that may be a level off.
fn expect_same(name: &str, drawn: &[[u8; 4]], developed: &[[u8; 4]], most: usize) {
    assert_eq!(drawn.len(), developed.len(), "{name}");
    let pairs = || drawn.as_flattened().iter().zip(developed.as_flattened());
    let worst = pairs().map(|(one, other)| one.abs_diff(*other)).max();
    let off = pairs().filter(|(one, other)| one != other).count();
    println!("{name}: {off} of {} channels differ, by at most {worst:?}", 4 * drawn.len());
    assert!(worst.is_none_or(|worst| worst <= 1) && off <= most, "{name}: {off} differ, by at most {worst:?}");
}

/// A picture of one colour would agree with many others.
fn expect_scenery(name: &str, pixels: &[[u8; 4]]) {
    let colors: HashSet<_> = pixels.iter().collect();
    assert!(colors.len() > 100, "{name}: {} colours", colors.len());
}

#[test]
fn textures_are_films_developed() {
    let Some(mut shared) = shared() else { return };
    let clip = Settings { tone_map: ToneMap::Clip, exposure_stops: 0.7, ..sized(130, 70) };
    let several = Settings { samples: 4, ..sized(97, 33) };
    let followed = Settings { bounces: 2, ambient_occlusion: 0.5, samples: 2, ..clip.clone() };
    for (name, settings) in [
        ("cloth", sized(200, 100)),
        ("glass", clip),
        ("hall", several),
        ("glass", followed.clone()),
        ("cloth", followed),
    ] {
        let scene = open_scene(name);
        let [(drawn, _), (developed, _)] = shared.both(&scene, 0.3, &settings);
        expect_scenery(name, &developed);
        // With clipping, only the levels matter. The tone map's divisions may be rounded in any way.
        let most = if settings.tone_map == ToneMap::Clip { 0 } else { drawn.len() / 100 };
        expect_same(name, &drawn, &developed, most);
    }
}

#[test]
fn counts_are_known_without_fetching() {
    let Some(mut shared) = shared() else { return };
    for (name, settings) in [("cloth", sized(100, 70)), ("glass", Settings { samples: 2, ..sized(70, 130) })] {
        let [(_, mut drawn), (_, mut fetched)] = shared.both(&open_scene(name), 0.3, &settings);
        assert!(drawn.shadow_rays > 0 && drawn.pixel_bytes > 0, "{name}: {drawn:?}");
        let is_done = |stats: &Stats, wanted| stats.stages.iter().any(|stage| stage.name == wanted);
        assert!(!is_done(&drawn, "fetch") && is_done(&fetched, "fetch"));
        // A film takes memory as well; the first frame uploads more than the next.
        for stats in [&mut drawn, &mut fetched] {
            (stats.stages, stats.pixel_bytes, stats.uploaded_bytes) = (Vec::new(), 0, 0);
        }
        assert_eq!(format!("{drawn:?}"), format!("{fetched:?}"), "{name}");
    }
}

#[test]
fn bands_are_put_together() {
    let (Some(renderer), Some(device)) = (small_renderer(), small_device()) else { return };
    let mut shared = Shared { renderer, device };
    // A row of the first size takes 48 bytes for each of 128 pixels, one of the second for each of 256: bands have 128
    // and 64 rows.
    for [width, height] in [[90, 200], [230, 150]] {
        let settings = Settings { tone_map: ToneMap::Clip, ..sized(width, height) };
        let [(drawn, of_texture), (developed, of_film)] = shared.both(&open_scene("marbles"), 0.2, &settings);
        expect_scenery("marbles", &developed);
        expect_same("marbles", &drawn, &developed, 0);
        assert_eq!(of_texture.shadow_rays, of_film.shadow_rays);
    }
}

#[test]
fn a_texture_stays_while_the_next_is_rendered() {
    let Some(mut shared) = shared() else { return };
    let scene = open_scene("cloth");
    let first = shared.renderer.render_to_texture(&scene, 0.0, &sized(90, 60)).expect("a texture");
    let before = shared.pixels(&first);
    let second = shared.renderer.render_to_texture(&scene, 0.5, &sized(90, 60)).expect("a texture");
    assert!(first != second);
    assert!(before == shared.pixels(&first), "it is drawn over too early");
    assert!(before != shared.pixels(&second), "nothing has moved");
    // The picture after that reuses its memory.
    let third = shared.renderer.render_to_texture(&scene, 0.5, &sized(90, 60)).expect("a texture");
    assert!(first == third && shared.pixels(&third) == shared.pixels(&second));
    // Another size leaves both unchanged.
    let other = shared.renderer.render_to_texture(&scene, 0.0, &sized(60, 130)).expect("a texture");
    assert_eq!([other.width(), other.height()], [60, 130]);
    assert!(shared.pixels(&third) == shared.pixels(&second));
    let settings = Settings { tone_map: ToneMap::Clip, ..sized(131, 60) };
    let [(drawn, _), (developed, _)] = shared.both(&scene, 0.0, &settings);
    expect_same("cloth", &drawn, &developed, 0);
}

#[test]
fn what_can_be_no_texture_is_an_error() {
    let scene = open_scene("cloth");
    let error = Renderer::default().render_to_texture(&scene, 0.0, &sized(8, 8)).expect_err("no GPU");
    assert_eq!(error.to_string(), "only a GPU renders to a texture");
    let Some(mut shared) = shared() else { return };
    let error = shared.renderer.render_to_texture(&scene, 0.0, &sized(8200, 8)).expect_err("too wide");
    assert!(error.to_string().contains("at most 8192"), "{error}");
    assert!(matches!(shared.renderer.render_to_texture(&scene, 0.0, &sized(0, 8)), Err(Error::ImageSize { .. })));
    // The next frame is right.
    let settings = Settings { tone_map: ToneMap::Clip, ..sized(64, 32) };
    let [(drawn, _), (developed, _)] = shared.both(&scene, 0.0, &settings);
    expect_same("cloth", &drawn, &developed, 0);
}
