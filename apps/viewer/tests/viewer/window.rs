//! A window without a screen, for tests that press its buttons.

use std::time::{Duration, Instant};

use eframe::egui::accesskit::Role;
use eframe::egui::{Key, Pos2, Rect, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use umbrage_viewer::{App, Start};

/// A window, without a screen.
pub(super) struct Window {
    pub(super) harness: Harness<'static, Option<App>>,
}

impl Window {
    /// Opens a scene and waits for the first picture; `None` without an adapter.
    pub(super) fn open(scene: &str) -> Option<Self> {
        Self::start(Start { scene: Some(scene.into()), ..Start::default() })
    }

    pub(super) fn start(start: Start) -> Option<Self> {
        if umbrage::gpu::Adapter::all().is_empty() {
            eprintln!("skipped-gpu: no adapter draws the window");
            return None;
        }
        // One sample by default, so that pictures that are compared don't change.
        let start = Start { forgets: true, samples: start.samples.or(Some(1)), ..start };
        let harness = Harness::builder().with_size(vec2(1000.0, 700.0)).wgpu().build_ui_state(
            move |ui, state: &mut Option<App>| {
                state.get_or_insert_with(|| App::new(ui.ctx(), start.clone(), None, None)).show(ui);
            },
            None,
        );
        let mut window = Self { harness };
        window.settle();
        Some(window)
    }

    /// Waits until the chosen picture is on the screen.
    pub(super) fn settle(&mut self) {
        let start = Instant::now();
        loop {
            self.harness.run_steps(1);
            self.expect_words_while_busy();
            self.harness.run_steps(1);
            if self.harness.state().as_ref().is_some_and(App::is_idle) {
                break;
            }
            assert!(start.elapsed() < Duration::from_secs(120), "nothing was shown in time");
            std::thread::sleep(Duration::from_millis(5));
        }
        self.harness.run_steps(3);
    }

    /// Nothing invites to drop a scene while one is being opened or rendered.
    fn expect_words_while_busy(&self) {
        let waits = self.harness.state().as_ref().is_some_and(|app| app.pictures() == 0 && !app.is_idle());
        assert!(!waits || !self.shows("Drop a scene here"), "a scene is on its way");
    }

    pub(super) fn click(&mut self, label: &str) {
        self.harness.get_by_label(label).click();
        self.settle();
    }

    pub(super) fn press(&mut self, key: Key) {
        self.harness.key_press(key);
        self.settle();
    }

    pub(super) fn shows(&self, text: &str) -> bool {
        self.harness.query_all_by_label_contains(text).next().is_some()
    }

    /// The pixels of the rendered scene in the window, except those that messages may cover.
    pub(super) fn pixels(&mut self) -> Vec<u8> {
        let window = self.harness.render().expect("a rendered window");
        let rect = self.harness.get_by_label("Rendered scene").rect();
        let [left, right] = [rect.left(), rect.right()].map(|x| x as usize);
        let (top, bottom) = (rect.top() as u32, rect.top() as u32 + (0.7 * rect.height()) as u32);
        let rows = window.rows().map(|row| row.flat_map(|pixel| pixel.0).collect::<Vec<u8>>());
        rows.skip(top as usize)
            .take((bottom - top) as usize)
            .flat_map(|row| row[4 * left..4 * right].to_vec())
            .collect()
    }

    /// Saves a picture of the window for review, if `UMBRAGE_WINDOW_PICTURES` names a folder.
    pub(super) fn keep(&mut self, name: &str) {
        if let Some(folder) = std::env::var_os("UMBRAGE_WINDOW_PICTURES") {
            let path = std::path::Path::new(&folder).join(format!("{name}.png"));
            self.harness.render().expect("a rendered window").save(path).expect("a file");
        }
    }

    /// Scrolls to a widget and clicks it.
    pub(super) fn click_in_panel(&mut self, label: &str) {
        self.harness.get_by_label(label).scroll_to_me();
        self.harness.run_steps(8);
        self.click(label);
    }

    /// Scrolls to a drop-down list and chooses an entry.
    pub(super) fn choose(&mut self, list: &str, entry: &str) {
        self.harness.get_by_role_and_label(Role::ComboBox, list).scroll_to_me();
        self.harness.run_steps(8);
        self.harness.get_by_role_and_label(Role::ComboBox, list).click();
        self.harness.run_steps(4);
        self.harness.get_by_role_and_label(Role::Button, entry).click();
        self.settle();
    }

    /// The pixels of a part of the window.
    pub(super) fn pixels_in(&mut self, part: Rect) -> Vec<[u8; 4]> {
        let image = self.harness.render().expect("a rendered window");
        let columns = part.left() as u32..part.right() as u32;
        let rows = part.top() as u32..part.bottom() as u32;
        rows.flat_map(|y| columns.clone().map(move |x| (x, y))).map(|(x, y)| image.get_pixel(x, y).0).collect()
    }

    /// A whole tile of 64×64 pixels of the picture.
    pub(super) fn tile(&self, column: u32, row: u32) -> Rect {
        let corner = self.harness.get_by_label("Rendered scene").rect().min;
        Rect::from_min_size(corner + vec2(64.0 * column as f32, 64.0 * row as f32), vec2(64.0, 64.0))
    }

    /// The heat map's count at a position of the picture.
    pub(super) fn count_at(&mut self, title: &str, place: Pos2) -> u32 {
        self.harness.hover_at(place);
        self.harness.run_steps(8);
        let prefix = format!("{title}: ");
        let said = self.harness.query_all_by_label_contains(&prefix).find_map(|node| {
            let node = node.accesskit_node();
            let text = node.label().or_else(|| node.value())?;
            text.strip_prefix(&prefix)?.parse().ok()
        });
        said.unwrap_or_else(|| panic!("no count under the cursor for {title}"))
    }

    /// The position at an offset from the picture's middle, in points.
    pub(super) fn in_picture(&self, right: f32, down: f32) -> Pos2 {
        self.harness.get_by_label("Rendered scene").rect().center() + vec2(right, down)
    }

    pub(super) fn drag(&mut self, from: Pos2, to: Pos2) {
        self.harness.hover_at(from);
        self.harness.step();
        self.harness.drag_at(from);
        self.harness.step();
        for step in 1..=4 {
            self.harness.hover_at(from + (to - from) * (step as f32 / 4.0));
            self.harness.step();
        }
        self.harness.drop_at(to);
        self.settle();
    }
}
