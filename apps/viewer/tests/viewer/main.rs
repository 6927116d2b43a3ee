//! The window as users see it, drawn without a screen by whatever adapter there is.

mod interface;
mod shared_device;
