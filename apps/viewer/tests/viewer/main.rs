//! The window as users see it, drawn without a screen by any available adapter.

mod choices;
mod interface;
mod shared_device;
mod window;
