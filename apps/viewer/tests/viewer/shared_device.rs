//! Pictures that stay on the window's device, as the window shows them.

use std::time::{Duration, Instant};

use eframe::egui::accesskit::Role;
use eframe::egui::{Key, vec2};
use eframe::egui_wgpu::{RenderState, RendererOptions};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use egui_kittest::wgpu::{WgpuTestRenderer, create_render_state};
use umbrage::gpu::Adapter;
use umbrage::gpu::wgpu::CurrentSurfaceTexture;
use umbrage_viewer::{App, EngineChoice, Graphics, Start, Surface};

/// A window on a device, without a screen.
struct Window {
    harness: Harness<'static, Option<App>>,
    surface: Surface,
}

impl Window {
    /// Opens a scene on the GPU, paused at its start, and waits for the first picture.
    fn open(state: &RenderState, shares_software: bool, scene: &str) -> Self {
        let start = Start {
            scene: Some(scene.into()),
            engine: Some(EngineChoice::Gpu(state.adapter.get_info().name)),
            samples: Some(1),
            forgets: true,
            ..Start::default()
        };
        let surface = Surface::default();
        let graphics = Graphics { state: state.clone(), shares_software, surface: surface.clone() };
        let harness = Harness::builder()
            .with_size(vec2(1000.0, 700.0))
            // egui's own fonts lack a cross.
            .allow_missing_glyphs()
            .renderer(WgpuTestRenderer::from_render_state(state.clone()))
            .build_ui_state(
                move |ui, app: &mut Option<App>| {
                    let graphics = graphics.clone();
                    app.get_or_insert_with(|| App::new(ui.ctx(), start.clone(), None, Some(graphics))).show(ui);
                },
                None,
            );
        let mut window = Self { harness, surface };
        window.settle();
        window.press(Key::Space);
        window.press(Key::Home);
        window
    }

    /// Waits until the chosen picture is on the screen.
    fn settle(&mut self) {
        let start = Instant::now();
        loop {
            self.harness.run_steps(2);
            if self.harness.state().as_ref().is_some_and(App::is_idle) {
                break;
            }
            assert!(start.elapsed() < Duration::from_secs(240), "nothing was shown in time");
            std::thread::sleep(Duration::from_millis(5));
        }
        self.harness.run_steps(3);
    }

    fn press(&mut self, key: Key) {
        self.harness.key_press(key);
        self.settle();
    }

    /// Whether pictures are drawn from the engine's texture.
    fn draws_textures(&self) -> bool {
        self.harness.query_all_by_label_contains("pictures stay on it").next().is_some()
    }

    /// Colours of the picture, without its margins.
    fn picture(&mut self) -> Vec<[u8; 4]> {
        let area = self.harness.get_by_label("Rendered scene").rect().shrink(60.0);
        let image = self.harness.render().expect("a rendered window");
        let columns = area.left() as u32..area.right() as u32;
        let rows = area.top() as u32..area.bottom() as u32;
        rows.flat_map(|y| columns.clone().map(move |x| [x, y])).map(|[x, y]| image.get_pixel(x, y).0).collect()
    }
}

/// egui's device, opened as for a window; `None`, with a note, without an adapter.
fn state() -> Option<RenderState> {
    Adapter::find("").map_err(|error| eprintln!("skipped-gpu: {error}")).ok()?;
    let state =
        create_render_state(Graphics::configuration("", Surface::default()).wgpu_setup, RendererOptions::PREDICTABLE);
    Some(state)
}

/// Number of channels that differ, and their maximum difference.
fn differences(one: &[[u8; 4]], other: &[[u8; 4]]) -> (usize, u8) {
    assert_eq!(one.len(), other.len());
    let pairs = one.as_flattened().iter().zip(other.as_flattened());
    let off = pairs.map(|(one, other)| one.abs_diff(*other)).filter(|off| *off > 0);
    off.fold((0, 0), |(count, worst), off| (count + 1, worst.max(off)))
}

#[test]
fn a_shared_texture_shows_what_a_copy_shows() {
    let (Some(shared), Some(apart)) = (state(), state()) else { return };
    let scene = "demo:cloth?triangles=2000";
    let mut copies = Window::open(&apart, false, scene);
    assert!(!copies.draws_textures(), "software has a device of its own");
    let mut textures = Window::open(&shared, true, scene);
    assert!(textures.draws_textures());
    let first = textures.picture();
    // A frame further, the second of the engine's two textures is shown, then the first again.
    for _ in 0..3 {
        let [drawn, copied] = [&mut textures, &mut copies].map(Window::picture);
        let colors: std::collections::HashSet<_> = copied.iter().collect();
        assert!(colors.len() > 100, "{} colours are no scenery", colors.len());
        let (off, worst) = differences(&drawn, &copied);
        assert!(worst <= 1 && off <= drawn.len() / 100, "{off} channels differ, by at most {worst}");
        for window in [&mut textures, &mut copies] {
            window.press(Key::ArrowRight);
        }
    }
    assert!(first != textures.picture(), "nothing has moved");
    // With heat maps, films are fetched; then textures are shown again.
    for window in [&mut textures, &mut copies] {
        window.press(Key::T);
    }
    let plain = textures.picture();
    let times = |window: &Window| window.harness.query_all_by_label_contains("develop").next().is_some();
    let can_time = shared.device.features().contains(umbrage::gpu::wgpu::Features::TIMESTAMP_QUERY);
    assert_eq!((times(&textures), times(&copies)), (can_time, false), "stages of the work panel");
    let [heat, none] = ["Triangles tested", "Light"].map(|entry| {
        // The list may be below the panel's end, and stays open after such a click.
        if textures.harness.query_by_role_and_label(Role::Button, entry).is_none() {
            textures.harness.get_by_role_and_label(Role::ComboBox, "Show").click_accesskit();
            textures.harness.run_steps(4);
        }
        textures.harness.get_by_role_and_label(Role::Button, entry).click_accesskit();
        textures.settle();
        textures.picture()
    });
    assert!(heat != plain, "no heat map is shown");
    assert_eq!(differences(&none, &plain), (0, 0), "the picture is back");
    // Another size.
    for window in [&mut textures, &mut copies] {
        window.harness.set_size(vec2(777.0, 555.0));
        window.settle();
    }
    let [drawn, copied] = [&mut textures, &mut copies].map(Window::picture);
    let (off, worst) = differences(&drawn, &copied);
    assert!(worst <= 1 && off <= drawn.len() / 100, "{off} channels differ, by at most {worst}");
    // The window's surface is lost.
    let told = |window: &Window| window.harness.query_by_label_contains("surface was lost").is_some();
    assert!(!told(&copies));
    let _ = copies.surface.answer(&CurrentSurfaceTexture::Lost);
    copies.settle();
    assert!(told(&copies), "a message");
}
