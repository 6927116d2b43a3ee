//! The window as users see it, drawn without a screen by whatever adapter there is.

mod choices;
mod interface;
mod shared_device;
mod window;
