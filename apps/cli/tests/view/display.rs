//! An X server without a screen, with simulated input.

use std::cell::Cell;
use std::collections::HashSet;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use x11rb::connection::Connection;
use x11rb::protocol::xproto::{
    AtomEnum, BUTTON_PRESS_EVENT, BUTTON_RELEASE_EVENT, ClientMessageEvent, ConfigureWindowAux, ConnectionExt,
    CreateWindowAux, EventMask, ImageFormat, InputFocus, KEY_PRESS_EVENT, KEY_RELEASE_EVENT, MOTION_NOTIFY_EVENT,
    Window, WindowClass,
};
use x11rb::protocol::xtest::ConnectionExt as _;
use x11rb::rust_connection::RustConnection;

const SIZE: [u16; 2] = [1280, 800];

/// A server of the test's own.
pub(crate) struct Display {
    server: Child,
    name: String,
    connection: RustConnection,
    root: Window,
    window: Cell<Option<Window>>,
    /// Where copied text arrives.
    mailbox: Window,
}

/// A picture of the whole screen: rows of BGRX.
#[derive(Clone, PartialEq)]
pub(crate) struct Shot {
    size: [u16; 2],
    pixels: Vec<u8>,
}

impl Display {
    /// `None` where there is no such server on this machine.
    pub(crate) fn start() -> Option<Self> {
        let screen = format!("{}x{}x24", SIZE[0], SIZE[1]);
        let started = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", &screen, "-nolisten", "tcp"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn();
        let mut server = match started {
            Ok(server) => server,
            Err(error) => {
                eprintln!("skipped-window: Xvfb: {error}");
                return None;
            }
        };
        let mut number = String::new();
        BufReader::new(server.stdout.take().expect("an output")).read_line(&mut number).expect("a display's number");
        let name = format!(":{}", number.trim());
        let (connection, screen) = x11rb::connect(Some(&name)).expect("a connection");
        let root = connection.setup().roots[screen].root;
        let mailbox = connection.generate_id().expect("an id");
        let about = CreateWindowAux::new();
        connection
            .create_window(0, mailbox, root, 0, 0, 1, 1, 0, WindowClass::INPUT_ONLY, 0, &about)
            .expect("a request")
            .check()
            .expect("a window");
        Some(Self { server, name, connection, root, window: Cell::new(None), mailbox })
    }

    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    /// Finds the program's window and gives it the keyboard focus. The window may become small later.
    pub(crate) fn find_window(&self) -> Option<Window> {
        if let Some(window) = self.window.get() {
            return Some(window);
        }
        let children = self.connection.query_tree(self.root).ok()?.reply().ok()?.children;
        let window = children.into_iter().find(|&window| {
            let geometry = self.connection.get_geometry(window).ok().and_then(|request| request.reply().ok());
            window != self.mailbox && geometry.is_some_and(|of| of.width > 100)
        })?;
        // Refused until the window is on the screen.
        self.connection.set_input_focus(InputFocus::PARENT, window, x11rb::CURRENT_TIME).ok()?.check().ok()?;
        self.window.set(Some(window));
        Some(window)
    }

    pub(crate) fn title(&self) -> Option<String> {
        let window = self.find_window()?;
        let (name, kind) = (self.atom("_NET_WM_NAME"), self.atom("UTF8_STRING"));
        let title = self.connection.get_property(false, window, name, kind, 0, 1024).ok()?.reply().ok()?.value;
        String::from_utf8(title).ok()
    }

    /// Presses and releases a key.
    pub(crate) fn press(&self, key: &str) {
        let symbol = match key {
            "Home" => 0xff50,
            "space" => 0x20,
            letter => u32::from(letter.as_bytes()[0]),
        };
        let setup = self.connection.setup();
        let (first, last) = (setup.min_keycode, setup.max_keycode);
        let request = self.connection.get_keyboard_mapping(first, last - first + 1).expect("a request");
        let mapping = request.reply().expect("a keyboard");
        let place = mapping.keysyms.iter().position(|&of| of == symbol).expect("a key");
        let code = first + (place / usize::from(mapping.keysyms_per_keycode)) as u8;
        for event in [KEY_PRESS_EVENT, KEY_RELEASE_EVENT] {
            self.fake(event, code, [0, 0]);
            std::thread::sleep(Duration::from_millis(60));
        }
    }

    /// Drags with the first button.
    pub(crate) fn drag(&self, from: [i16; 2], to: [i16; 2]) {
        const STEPS: i16 = 12;
        self.fake(MOTION_NOTIFY_EVENT, 0, from);
        self.fake(BUTTON_PRESS_EVENT, 1, from);
        for step in 1..=STEPS {
            let along = |from: i16, to: i16| from + (i32::from(to - from) * i32::from(step) / i32::from(STEPS)) as i16;
            self.fake(MOTION_NOTIFY_EVENT, 0, [along(from[0], to[0]), along(from[1], to[1])]);
            std::thread::sleep(Duration::from_millis(40));
        }
        self.fake(BUTTON_RELEASE_EVENT, 1, to);
    }

    fn fake(&self, event: u8, detail: u8, [x, y]: [i16; 2]) {
        let request = self.connection.xtest_fake_input(event, detail, 0, self.root, x, y, 0).expect("a request");
        request.check().expect("an event");
    }

    /// Text that a program has copied.
    pub(crate) fn clipboard(&self) -> Option<String> {
        let [selection, kind, property] = ["CLIPBOARD", "UTF8_STRING", "UMBRAGE"].map(|name| self.atom(name));
        let request = self.connection.convert_selection(self.mailbox, selection, kind, property, x11rb::CURRENT_TIME);
        request.ok()?.check().ok()?;
        std::thread::sleep(Duration::from_millis(200));
        let reply = self.connection.get_property(true, self.mailbox, property, AtomEnum::ANY, 0, 1 << 16).ok()?.reply();
        String::from_utf8(reply.ok()?.value).ok()
    }

    pub(crate) fn resize(&self, [width, height]: [u32; 2]) {
        let window = self.find_window().expect("a window");
        let size = ConfigureWindowAux::new().width(width).height(height);
        self.connection.configure_window(window, &size).expect("a request").check().expect("a size");
        std::thread::sleep(Duration::from_millis(500));
    }

    /// Asks the window to close, as window managers do.
    pub(crate) fn close(&self) {
        let window = self.find_window().expect("a window");
        let data = [self.atom("WM_DELETE_WINDOW"), x11rb::CURRENT_TIME, 0, 0, 0];
        let event = ClientMessageEvent::new(32, window, self.atom("WM_PROTOCOLS"), data);
        let request = self.connection.send_event(false, window, EventMask::NO_EVENT, event).expect("a request");
        request.check().expect("an event");
    }

    pub(crate) fn shot(&self) -> Shot {
        let [width, height] = SIZE;
        let request = self.connection.get_image(ImageFormat::Z_PIXMAP, self.root, 0, 0, width, height, u32::MAX);
        let image = request.expect("a request").reply().expect("a picture");
        Shot { size: SIZE, pixels: image.data }
    }

    fn atom(&self, name: &str) -> u32 {
        self.connection.intern_atom(false, name.as_bytes()).expect("a request").reply().expect("an atom").atom
    }
}

impl Drop for Display {
    fn drop(&mut self) {
        self.server.kill().ok();
        self.server.wait().ok();
    }
}

impl Shot {
    /// Number of different colours.
    pub(crate) fn colors(&self) -> usize {
        self.pixels.as_chunks::<4>().0.iter().collect::<HashSet<_>>().len()
    }

    /// The middle of the picture, between the menu and the timeline.
    pub(crate) fn middle(&self) -> [i16; 2] {
        let [width, height] = self.size.map(|side| side as i16);
        [width / 2, height / 2 - 2]
    }

    /// Whether fewer than 1 in 200 samples differ by more than two levels, as between engines.
    pub(crate) fn differs_little(&self, other: &Self) -> bool {
        let others = self.pixels.iter().zip(&other.pixels).filter(|(one, other)| one.abs_diff(**other) > 2).count();
        others < self.pixels.len() / 200
    }

    pub(crate) fn write(&self, path: &Path) {
        let [width, height] = self.size.map(u32::from);
        let mut encoder = png::Encoder::new(std::fs::File::create(path).expect("a file"), width, height);
        encoder.set_color(png::ColorType::Rgb);
        let rgb: Vec<u8> = self.pixels.as_chunks::<4>().0.iter().flat_map(|&[b, g, r, _]| [r, g, b]).collect();
        encoder.write_header().expect("a header").write_image_data(&rgb).expect("rows");
    }
}
